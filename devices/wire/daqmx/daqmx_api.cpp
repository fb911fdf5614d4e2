#include "devices/wire/daqmx/daqmx_api.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>

namespace tactbench::devices {
namespace {

constexpr double kWriteSeconds = 1.0;

struct NamedError {
  int code;
  const char* name;
  const char* remedy;
};
constexpr std::array kDaqmxErrors = {
    NamedError{-200284, "samples not yet available", "Allow a longer timeout, or check the sample clock."},
    NamedError{-200279, "samples overwritten before they were read", "Lower the sample rate."},
    NamedError{-200221, "timeout", "Allow a longer timeout; check the device's cable."},
    NamedError{-200220, "bad device identifier", "Correct the device's name in the bench file."},
    NamedError{-200170, "no such physical channel", "Correct the channels in the bench file."},
    NamedError{-200324, "device absent", "Plug the device in; nilsdev lists what the driver sees."},
    NamedError{-200045, "device removed", "Plug the device in again and start again."},
    NamedError{-200088, "invalid task", "Start again; if it recurs, this is a defect of tactbench: report it."},
    NamedError{-200019, "converter overrun", "Lower the sample or convert rate."},
    NamedError{-50103, "resource reserved", "End the other program that uses the device."},
    NamedError{-88709, "aborted", "Start again."},
    NamedError{-201003, "device cannot be accessed", "Check its cable and power, then start again."},
};

DaqmxCalls load(const std::string& library) {
  const auto fail = [](const std::string& what) {
    throw Fault("TB-DAQMX-LIBRARY", "NI-DAQmx", "loading NI-DAQmx: " + what,
                "Install NI's driver package (NI-DAQmx for Linux). NI may not support the USB-6259 on Linux: check "
                "NI's compatibility list; a scanner behind any program can be connected as a frame source instead "
                "(frame_protocol.md).");
  };
  const std::vector<std::string> names =
      library.empty() ? std::vector<std::string>{"libnidaqmx.so", "libnidaqmx.so.1"} : std::vector{library};
  void* handle = nullptr;  // never closed: NI's library has running threads
  std::string reasons;
  for (const std::string& name : names) {
    handle = ::dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (handle != nullptr) break;
    reasons += fmt::format("{}{}", reasons.empty() ? "" : "; ", ::dlerror());
  }
  if (handle == nullptr) fail(reasons);
  DaqmxCalls calls{};
  const auto resolve = [&](auto& function, const char* name) {
    void* symbol = ::dlsym(handle, (std::string("DAQmx") + name).c_str());
    if (symbol == nullptr) fail(fmt::format("{} has no function DAQmx{}", fmt::join(names, " or "), name));
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(symbol);
  };
  resolve(calls.GetSysDevNames, "GetSysDevNames");
  resolve(calls.GetDevProductType, "GetDevProductType");
  resolve(calls.GetDevSerialNum, "GetDevSerialNum");
  resolve(calls.GetDevIsSimulated, "GetDevIsSimulated");
  resolve(calls.GetErrorString, "GetErrorString");
  resolve(calls.GetExtendedErrorInfo, "GetExtendedErrorInfo");
  resolve(calls.CreateTask, "CreateTask");
  resolve(calls.ClearTask, "ClearTask");
  resolve(calls.StartTask, "StartTask");
  resolve(calls.StopTask, "StopTask");
  resolve(calls.TaskControl, "TaskControl");
  resolve(calls.GetTaskNumChans, "GetTaskNumChans");
  resolve(calls.CreateAIVoltageChan, "CreateAIVoltageChan");
  resolve(calls.CreateDOChan, "CreateDOChan");
  resolve(calls.CfgSampClkTiming, "CfgSampClkTiming");
  resolve(calls.SetAIConvRate, "SetAIConvRate");
  resolve(calls.ReadAnalogF64, "ReadAnalogF64");
  resolve(calls.WriteDigitalLines, "WriteDigitalLines");
  return calls;
}

std::optional<std::uint32_t> hexadecimal(const std::string& text) {
  std::uint32_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, 16);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

bool DaqmxError::timed_out() const { return code_ == -200284 || code_ == -200221; }
bool DaqmxError::device_gone() const {
  return code_ == -200324 || code_ == -200045 || code_ == -201003 || code_ == -200220;
}
bool DaqmxError::samples_lost() const { return code_ == -200279 || code_ == -200019; }

DaqmxApi::DaqmxApi(const std::string& library) : calls_(std::make_shared<const DaqmxCalls>(load(library))) {}

void DaqmxApi::check(int code, const std::string& asked) {
  if (code == 0) return;
  std::array<char, 2048> words{};
  // The extended text is of the last error only; a warning has its own text.
  if (code < 0) calls_->GetExtendedErrorInfo(words.data(), words.size());
  if (words[0] == '\0') calls_->GetErrorString(code, words.data(), words.size());
  words.back() = '\0';
  if (code > 0) {
    const auto warning = fmt::format("{}: warning {}: {}", asked, code, words.data());
    if (std::find(warnings_.begin(), warnings_.end(), warning) == warnings_.end()) warnings_.push_back(warning);
    return;
  }
  const auto known =
      std::find_if(kDaqmxErrors.begin(), kDaqmxErrors.end(), [&](const auto& e) { return e.code == code; });
  const bool named = known != kDaqmxErrors.end();
  throw DaqmxError(code,
                   fmt::format("{}: NI-DAQmx error {}{}{}: {}", asked, code, named ? ", " : "",
                               named ? known->name : "", words.data()),
                   named ? known->remedy : "See NI's documentation for the error's number.");
}

// Called with no room for the text, the driver returns its length; that is not a warning.
std::string DaqmxApi::text(const std::function<int(char*, std::uint32_t)>& query, const std::string& asked) {
  const int size = query(nullptr, 0);
  if (size <= 0) {
    check(size, asked);
    return {};
  }
  std::string text(static_cast<std::size_t>(size), '\0');
  check(query(text.data(), static_cast<std::uint32_t>(text.size())), asked);
  return text.substr(0, text.find('\0'));
}

std::vector<DaqmxDevice> DaqmxApi::list_devices() {
  const std::string names =
      text([this](char* into, std::uint32_t size) { return calls_->GetSysDevNames(into, size); }, "listing devices");
  std::vector<DaqmxDevice> devices;
  for (std::size_t begin = 0; begin < names.size();) {
    const std::size_t end = std::min(names.find(',', begin), names.size());
    std::string name = names.substr(begin, end - begin);
    name.erase(0, name.find_first_not_of(' '));
    begin = end + 1;
    if (name.empty()) continue;
    const std::string asked = "identifying " + name;
    std::uint32_t serial = 0;
    std::uint32_t simulated = 0;
    auto type = text(
        [&](char* into, std::uint32_t size) { return calls_->GetDevProductType(name.c_str(), into, size); }, asked);
    check(calls_->GetDevSerialNum(name.c_str(), &serial), asked);
    check(calls_->GetDevIsSimulated(name.c_str(), &simulated), asked);
    devices.push_back({std::move(name), std::move(type), fmt::format("{:08X}", serial), simulated != 0});
  }
  return devices;
}

DaqmxDevice DaqmxApi::device(const std::string& name, const std::string& expected_serial) {
  const auto devices = list_devices();
  std::string present;
  for (const DaqmxDevice& device : devices) {
    if (device.name != name) {
      present += fmt::format("{}{} ({}, serial {})", present.empty() ? "" : ", ", device.name, device.product_type,
                             device.serial);
      continue;
    }
    if (!expected_serial.empty() && hexadecimal(expected_serial) != hexadecimal(device.serial)) {
      throw Fault(
          "TB-DAQMX-SERIAL", name,
          fmt::format("{} is configured with serial {}, but has serial {}", name, expected_serial, device.serial),
          "Connect the right device, or correct its serial (hexadecimal) in the bench file.");
    }
    return device;
  }
  throw Fault("TB-DAQMX-DEVICE", name,
              fmt::format("{} is configured; the driver sees {}", name, present.empty() ? "no device" : present),
              "Plug the device in, or correct its name in the bench file; nilsdev lists what the driver sees.");
}

DaqmxTask::DaqmxTask(DaqmxApi& api) : api_(api) { api_.check(api_.calls().CreateTask("", &handle_), "making a task"); }

DaqmxTask::~DaqmxTask() {
  stop();
  api_.calls().ClearTask(handle_);
}

void DaqmxTask::add_voltages(const std::string& channels, DaqmxTerminal terminal, Volts range) {
  const int wiring = terminal == DaqmxTerminal::kRse    ? daqmx::kRse
                     : terminal == DaqmxTerminal::kNrse ? daqmx::kNrse
                                                        : daqmx::kDifferential;
  api_.check(api_.calls().CreateAIVoltageChan(handle_, channels.c_str(), "", wiring, -range.value(), range.value(),
                                              daqmx::kVolts, nullptr),
             "adding analog inputs " + channels);
}

void DaqmxTask::add_output_lines(const std::string& lines) {
  api_.check(api_.calls().CreateDOChan(handle_, lines.c_str(), "", daqmx::kChannelPerLine),
             "adding digital outputs " + lines);
}

int DaqmxTask::channels() {
  std::uint32_t channels = 0;
  api_.check(api_.calls().GetTaskNumChans(handle_, &channels), "counting channels");
  return static_cast<int>(channels);
}

void DaqmxTask::finite_samples(double rate_hz, int samples) {
  api_.check(api_.calls().CfgSampClkTiming(handle_, nullptr, rate_hz, daqmx::kRising, daqmx::kFiniteSamples,
                                           static_cast<std::uint64_t>(samples)),
             fmt::format("requesting {} samples at {:g} Hz", samples, rate_hz));
}

void DaqmxTask::convert_rate(double rate_hz) {
  api_.check(api_.calls().SetAIConvRate(handle_, rate_hz),
             fmt::format("requesting {:g} conversions a second", rate_hz));
}

void DaqmxTask::commit() { api_.check(api_.calls().TaskControl(handle_, daqmx::kCommit), "reserving the hardware"); }

void DaqmxTask::start() { api_.check(api_.calls().StartTask(handle_), "starting a task"); }

void DaqmxTask::stop() noexcept { api_.calls().StopTask(handle_); }

void DaqmxTask::read(int samples, Nanoseconds timeout, std::span<double> volts) {
  std::fill(volts.begin(), volts.end(), std::numeric_limits<double>::quiet_NaN());
  int came = 0;
  const double seconds = std::chrono::duration<double>(timeout).count();
  api_.check(api_.calls().ReadAnalogF64(handle_, samples, seconds, daqmx::kByScan, volts.data(),
                                        static_cast<std::uint32_t>(volts.size()), &came, nullptr),
             fmt::format("reading {} samples", samples));
  const auto bad = std::find_if(volts.begin(), volts.end(), [](double value) { return !std::isfinite(value); });
  if (came == samples && bad == volts.end()) return;
  throw Fault("TB-DAQMX-SHORT", "NI-DAQmx",
              came != samples ? fmt::format("{} samples of each channel were requested, {} came", samples, came)
                              : fmt::format("value {} of {} is not a voltage", bad - volts.begin(), volts.size()),
              "Read again; if it recurs, check the device with NI's own tools.");
}

void DaqmxTask::write_lines(std::span<const std::uint8_t> levels) {
  int written = 0;
  api_.check(
      api_.calls().WriteDigitalLines(handle_, 1, 1, kWriteSeconds, daqmx::kByScan, levels.data(), &written, nullptr),
      "writing digital outputs");
}

}  // namespace tactbench::devices
