// The tests' own libnidaqmx.so: a card whose inputs answer by a test's function of the output lines, that refuses calls
// out of order and fails where a test says. One card for the process, for one thread.
#pragma once

#include <dlfcn.h>

#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/support/paths.h"

namespace tactbench::tests {

struct FakeDaqmx {
  struct Device {
    std::string name = "Dev1";
    std::string product_type = "USB-6259";
    std::uint32_t serial = 0x01A2B3C4;
    bool simulated = false;
  };
  using Levels = std::vector<std::uint8_t>;

  std::vector<Device> devices = {{}};
  std::string separator = ", ";  // between their names
  // What input `channel` (0-based in its task) measures while the lines stand at `lines`, in sample n of this reading.
  std::function<double(const Levels& lines, int channel, int sample)> volts;
  std::string fail_function;  // "ReadAnalogF64": its call number `fail_call` (from 0) and all later return fail_code
  int fail_call = 0;
  int fail_code = 0;  // above 0, a warning: of ReadAnalogF64 alone
  int short_by = 0;   // samples of each channel that a reading lacks

  // What has happened.
  std::vector<std::string> calls;  // names without "DAQmx"
  std::vector<Levels> writes;
  Levels lines;
  int tasks = 0;
  std::string misuse;  // the first call out of order
  double rate = 0, convert_rate = 0, minimum = 0, maximum = 0, timeout = 0, write_timeout = 0;
  int terminal = 0;
};

extern "C" FakeDaqmx* tactbench_fake_daqmx();

// The card in the library at fake_nidaqmx_path(), which the code under test loads.
inline FakeDaqmx& fake_daqmx() {
  void* library = ::dlopen(fake_nidaqmx_path().c_str(), RTLD_NOW);
  void* symbol = library != nullptr ? ::dlsym(library, "tactbench_fake_daqmx") : nullptr;
  if (symbol == nullptr) throw std::runtime_error("no fake libnidaqmx.so");
  return *reinterpret_cast<decltype(&tactbench_fake_daqmx)>(symbol)();
}

}  // namespace tactbench::tests
