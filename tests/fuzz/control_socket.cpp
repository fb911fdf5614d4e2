// Both ends of a run's control socket. Whatever is sent to a run is answered by one JSON document, and the next command
// is read; whatever is answered in a run's place is accepted or refused, without a crash.
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "bench/run/control/control_client.h"
#include "bench/run/control/control_socket.h"
#include "devices/wire/wait.h"

using namespace tactbench;

namespace {

// A run that does nothing but listen, in a scope of this process's own.
struct Listening {
  Listening() {
    ::setenv("TACTBENCH_RUNTIME_DIR", folder.c_str(), 1);
    bench.id = "fuzzed";
    bench.in_process = true;
    socket.emplace(bench, control, 1);
  }
  ~Listening() {
    socket.reset();
    std::filesystem::remove_all(folder);
  }
  std::string folder = [] {
    std::string name = (std::filesystem::temp_directory_path() / "tactbench-fuzz-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) std::abort();
    return name;
  }();
  bench::BenchConfig bench;
  bench::Control control;
  std::optional<bench::ControlSocket> socket;
};

// Empty: hung up without a word.
std::string answer_to(const std::string& name, const std::string& said) {
  constexpr std::chrono::seconds kLongest(5);
  const int descriptor = bench::connect_to_name(name);
  if (descriptor < 0) std::abort();
  if (::send(descriptor, said.data(), said.size(), MSG_NOSIGNAL) < 0) std::abort();
  // libFuzzer's own timer interrupts a bare poll().
  if (devices::wait_for(descriptor, POLLIN, kLongest) == 0) std::abort();
  std::array<char, 8192> bytes{};
  const ssize_t size = ::recv(descriptor, bytes.data(), bytes.size(), 0);
  ::close(descriptor);
  return {bytes.data(), static_cast<std::size_t>(std::max<ssize_t>(size, 0))};
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t kLongest = 4096;  // a word has a few letters
  static Listening run;
  const std::string text(reinterpret_cast<const char*>(data), std::min(size, kLongest));
  const std::string answer = answer_to(run.socket->name(), text);
  if (!text.empty() && !bench::read_answer("fuzzed", {}, answer)) std::abort();
  (void)bench::read_answer("fuzzed", {}, text);
  return 0;
}
