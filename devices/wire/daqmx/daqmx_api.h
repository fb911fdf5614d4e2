// The part of NI-DAQmx that tactbench uses, loaded at run time so that tactbench builds and runs without NI's driver.
// NI may not support the USB-6259 on Linux at all. Prototypes and constants are our own, from NI's public
// documentation. Not verified on hardware; verified against the tests' own libnidaqmx.so.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "devices/clock.h"
#include "devices/device.h"
#include "devices/units.h"
#include "devices/wire/options.h"

namespace tactbench::devices {

struct DaqmxCalls;  // the library's functions; daqmx_api.h

struct DaqmxDevice {
  std::string name;          // "Dev1"
  std::string product_type;  // "USB-6259"
  std::string serial;        // hexadecimal, as on NI's label: "01A2B3C4"
  bool simulated = false;    // simulated by the driver, without hardware
};

// Fault TB-DAQMX-ERROR: the driver refused; what() holds number, name and the driver's own text.
class DaqmxError : public Fault {
 public:
  DaqmxError(int code, const std::string& message, const std::string& remedy)
      : Fault("TB-DAQMX-ERROR", "NI-DAQmx", message, remedy), code_(code) {}
  [[nodiscard]] int code() const { return code_; }
  [[nodiscard]] bool timed_out() const;     // the samples did not come in time
  [[nodiscard]] bool device_gone() const;   // absent, removed or out of reach
  [[nodiscard]] bool samples_lost() const;  // overrun, or overwritten before they were read

 private:
  int code_;
};

class DaqmxApi {
 public:
  // Loads `library`; if empty, libnidaqmx.so, else libnidaqmx.so.1. It stays loaded for the life of the process. Throws
  // Fault TB-DAQMX-LIBRARY (not found, or it lacks a function).
  explicit DaqmxApi(const std::string& library = {});

  // All of these throw DaqmxError.
  [[nodiscard]] std::vector<DaqmxDevice> list_devices();
  // Also throws Fault TB-DAQMX-DEVICE (no such device: names those present) and TB-DAQMX-SERIAL (another serial;
  // `expected_serial` empty: any).
  [[nodiscard]] DaqmxDevice device(const std::string& name, const std::string& expected_serial);
  // `code` is a call's return value: below 0 throws, above 0 is a warning and is kept.
  void check(int code, const std::string& asked);
  [[nodiscard]] const std::vector<std::string>& warnings() const { return warnings_; }  // each once
  [[nodiscard]] const DaqmxCalls& calls() const { return *calls_; }

 private:
  std::string text(const std::function<int(char*, std::uint32_t)>& query, const std::string& asked);
  std::shared_ptr<const DaqmxCalls> calls_;
  std::vector<std::string> warnings_;
};

// One task of the driver; stopped and cleared at the end. `api` must outlive it. All functions except stop() throw
// DaqmxError.
class DaqmxTask {
 public:
  explicit DaqmxTask(DaqmxApi& api);
  ~DaqmxTask();
  DaqmxTask(const DaqmxTask&) = delete;
  DaqmxTask& operator=(const DaqmxTask&) = delete;

  // `channels` as NI writes them, "Dev1/ai0:15"; measured from -range to +range.
  void add_voltages(const std::string& channels, DaqmxTerminal terminal, Volts range);
  void add_output_lines(const std::string& lines);  // "Dev1/port0/line0:15"
  [[nodiscard]] int channels();                     // each line counts as one
  void finite_samples(double rate_hz, int samples);
  void convert_rate(double rate_hz);  // from one channel to the next within a sample
  void commit();                      // reserves the hardware, so that starting is fast
  void start();
  void stop() noexcept;
  // Waits up to `timeout` for `samples` of each channel; volts (samples x channels) is filled sample by sample. Fewer
  // samples than requested, and a value that is not finite, throw Fault TB-DAQMX-SHORT.
  void read(int samples, Nanoseconds timeout, std::span<double> volts);
  void write_lines(std::span<const std::uint8_t> levels);  // one 0 or 1 for each line

 private:
  DaqmxApi& api_;
  void* handle_ = nullptr;
};

// The C interface of NI-DAQmx as far as tactbench uses it: own prototypes (x86-64 Linux: int32 is int, a task handle
// void*, bool32 unsigned, float64 double), the values of its constants, and the errors named here.
struct DaqmxCalls {
  using Task = void*;
  int (*GetSysDevNames)(char* names, std::uint32_t size);
  int (*GetDevProductType)(const char* device, char* type, std::uint32_t size);
  int (*GetDevSerialNum)(const char* device, std::uint32_t* serial);
  int (*GetDevIsSimulated)(const char* device, std::uint32_t* simulated);
  int (*GetErrorString)(int code, char* text, std::uint32_t size);
  int (*GetExtendedErrorInfo)(char* text, std::uint32_t size);
  int (*CreateTask)(const char* name, Task* task);
  int (*ClearTask)(Task task);
  int (*StartTask)(Task task);
  int (*StopTask)(Task task);
  int (*TaskControl)(Task task, int action);
  int (*GetTaskNumChans)(Task task, std::uint32_t* channels);
  int (*CreateAIVoltageChan)(Task task, const char* channels, const char* names, int terminal, double minimum,
                             double maximum, int units, const char* custom_scale);
  int (*CreateDOChan)(Task task, const char* lines, const char* names, int grouping);
  int (*CfgSampClkTiming)(Task task, const char* source, double rate, int edge, int mode, std::uint64_t samples);
  int (*SetAIConvRate)(Task task, double rate);
  int (*ReadAnalogF64)(Task task, int samples, double timeout, std::uint32_t order, double* into, std::uint32_t size,
                       int* samples_read, std::uint32_t* reserved);
  int (*WriteDigitalLines)(Task task, int samples, std::uint32_t auto_start, double timeout, std::uint32_t order,
                           const std::uint8_t* levels, int* samples_written, std::uint32_t* reserved);
};

namespace daqmx {
inline constexpr int kRse = 10083, kNrse = 10078, kDifferential = 10106;
inline constexpr int kVolts = 10348, kRising = 10280, kFiniteSamples = 10178, kCommit = 3;
inline constexpr int kChannelPerLine = 0;
inline constexpr std::uint32_t kByScan = 1;  // all channels of a sample, then the next sample
}  // namespace daqmx

}  // namespace tactbench::devices
