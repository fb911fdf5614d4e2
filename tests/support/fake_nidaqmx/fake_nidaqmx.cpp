#include "tests/support/fake_nidaqmx/fake_nidaqmx.h"

#include <algorithm>
#include <cstring>
#include <memory>

using tactbench::tests::FakeDaqmx;

namespace {

constexpr int kBadDevice = -200220;
constexpr int kNoChannel = -200170;
constexpr int kInvalidTask = -200088;
constexpr int kNotYet = -200284;

struct Task {
  int inputs = 0;
  int outputs = 0;
  int samples = 0;
  bool started = false;
};

FakeDaqmx card;
std::vector<std::unique_ptr<Task>> tasks;
std::string last_error;

int refuse(int code, const std::string& why) {
  last_error = "fake driver: " + why;
  return code;
}

// Notes the call; what it has to return, or 0.
int enter(const char* function) {
  const auto before = std::count(card.calls.begin(), card.calls.end(), function);
  card.calls.emplace_back(function);
  if (card.fail_function != function || before < card.fail_call) return 0;
  return card.fail_code < 0 ? refuse(card.fail_code, "as the test asked") : card.fail_code;
}

int misused(const char* what) {
  if (card.misuse.empty()) card.misuse = what;
  return refuse(kInvalidTask, what);
}

Task* find(void* handle) {
  const auto found = std::find_if(tasks.begin(), tasks.end(), [&](const auto& task) { return task.get() == handle; });
  if (found != tasks.end()) return found->get();
  misused("no such task");
  return nullptr;
}

const FakeDaqmx::Device* find_device(const std::string& name) {
  for (const auto& device : card.devices) {
    if (device.name == name) return &device;
  }
  return nullptr;
}

// How many channels "Dev1/ai0:5,Dev1/ai7" names; an error's number when a device is not there.
int count(const std::string& list) {
  int total = 0;
  for (std::size_t begin = 0; begin < list.size();) {
    const std::size_t end = std::min(list.find(',', begin), list.size());
    const std::string item = list.substr(begin, end - begin);
    begin = end + 1;
    const std::size_t slash = item.find('/');
    if (find_device(item.substr(0, slash)) == nullptr) return refuse(kBadDevice, "no device for " + item);
    const std::size_t colon = item.find(':');
    const std::size_t digits = item.find_last_not_of("0123456789", colon == std::string::npos ? colon : colon - 1) + 1;
    const int first = std::stoi(item.substr(digits));
    const int last = colon == std::string::npos ? first : std::stoi(item.substr(colon + 1));
    if (last > 31) return refuse(kNoChannel, "no channel " + std::to_string(last));
    total += last - first + 1;
  }
  return total;
}

int put_text(const std::string& text, char* into, std::uint32_t size) {
  if (size == 0) return static_cast<int>(text.size() + 1);
  if (into == nullptr || size <= text.size()) return refuse(-200228, "buffer too small");
  std::memcpy(into, text.c_str(), text.size() + 1);
  return 0;
}

}  // namespace

extern "C" {

FakeDaqmx* tactbench::tests::tactbench_fake_daqmx() { return &card; }

int DAQmxGetSysDevNames(char* names, std::uint32_t size) {
  if (const int code = enter("GetSysDevNames")) return code;
  std::string list;
  for (const auto& device : card.devices) list += (list.empty() ? "" : card.separator) + device.name;
  return put_text(list, names, size);
}

int DAQmxGetDevProductType(const char* device, char* type, std::uint32_t size) {
  if (const int code = enter("GetDevProductType")) return code;
  const auto* found = find_device(device);
  return found != nullptr ? put_text(found->product_type, type, size) : refuse(kBadDevice, "no such device");
}

int DAQmxGetDevSerialNum(const char* device, std::uint32_t* serial) {
  if (const int code = enter("GetDevSerialNum")) return code;
  const auto* found = find_device(device);
  if (found == nullptr) return refuse(kBadDevice, "no such device");
  *serial = found->serial;
  return 0;
}

int DAQmxGetDevIsSimulated(const char* device, std::uint32_t* simulated) {
  if (const int code = enter("GetDevIsSimulated")) return code;
  const auto* found = find_device(device);
  if (found == nullptr) return refuse(kBadDevice, "no such device");
  *simulated = found->simulated ? 1 : 0;
  return 0;
}

int DAQmxGetErrorString(int code, char* text, std::uint32_t size) {
  return put_text("words for " + std::to_string(code), text, size);
}

int DAQmxGetExtendedErrorInfo(char* text, std::uint32_t size) { return put_text(last_error, text, size); }

int DAQmxCreateTask(const char*, void** task) {
  if (const int code = enter("CreateTask")) return code;
  tasks.push_back(std::make_unique<Task>());
  *task = tasks.back().get();
  ++card.tasks;
  return 0;
}

int DAQmxClearTask(void* handle) {
  if (const int code = enter("ClearTask")) return code;
  if (find(handle) == nullptr) return kInvalidTask;
  std::erase_if(tasks, [&](const auto& task) { return task.get() == handle; });
  --card.tasks;
  return 0;
}

int DAQmxStartTask(void* handle) {
  if (const int code = enter("StartTask")) return code;
  Task* task = find(handle);
  if (task == nullptr) return kInvalidTask;
  if (task->samples == 0) return misused("started before its timing was set");
  if (task->started) return misused("started twice");
  task->started = true;
  return 0;
}

int DAQmxStopTask(void* handle) {
  if (const int code = enter("StopTask")) return code;
  Task* task = find(handle);
  if (task == nullptr) return kInvalidTask;
  task->started = false;
  return 0;
}

int DAQmxTaskControl(void* handle, int action) {
  if (const int code = enter("TaskControl")) return code;
  if (find(handle) == nullptr) return kInvalidTask;
  return action == 3 ? 0 : misused("only Commit is known");
}

int DAQmxGetTaskNumChans(void* handle, std::uint32_t* channels) {
  if (const int code = enter("GetTaskNumChans")) return code;
  const Task* task = find(handle);
  if (task == nullptr) return kInvalidTask;
  *channels = static_cast<std::uint32_t>(task->inputs + task->outputs);
  return 0;
}

int DAQmxCreateAIVoltageChan(void* handle, const char* channels, const char*, int terminal, double minimum,
                             double maximum, int units, const char* custom_scale) {
  if (const int code = enter("CreateAIVoltageChan")) return code;
  Task* task = find(handle);
  if (task == nullptr) return kInvalidTask;
  if (units != 10348 || custom_scale != nullptr) return misused("volts without a scale are known");
  const int counted = count(channels);
  if (counted < 0) return counted;
  task->inputs += counted;
  card.terminal = terminal;
  card.minimum = minimum;
  card.maximum = maximum;
  return 0;
}

int DAQmxCreateDOChan(void* handle, const char* lines, const char*, int grouping) {
  if (const int code = enter("CreateDOChan")) return code;
  Task* task = find(handle);
  if (task == nullptr) return kInvalidTask;
  if (grouping != 0) return misused("one channel a line is known");
  const int counted = count(lines);
  if (counted < 0) return counted;
  task->outputs += counted;
  return 0;
}

int DAQmxCfgSampClkTiming(void* handle, const char*, double rate, int edge, int mode, std::uint64_t samples) {
  if (const int code = enter("CfgSampClkTiming")) return code;
  Task* task = find(handle);
  if (task == nullptr) return kInvalidTask;
  if (task->inputs == 0) return misused("timing before channels");
  if (task->started) return misused("timing while running");
  if (edge != 10280 || mode != 10178) return misused("finite samples on rising edges are known");
  task->samples = static_cast<int>(samples);
  card.rate = rate;
  return 0;
}

int DAQmxSetAIConvRate(void* handle, double rate) {
  if (const int code = enter("SetAIConvRate")) return code;
  const Task* task = find(handle);
  if (task == nullptr) return kInvalidTask;
  if (task->samples == 0) return misused("convert rate before timing");
  card.convert_rate = rate;
  return 0;
}

int DAQmxReadAnalogF64(void* handle, int samples, double timeout, std::uint32_t order, double* into, std::uint32_t size,
                       int* samples_read, std::uint32_t*) {
  *samples_read = 0;
  if (const int code = enter("ReadAnalogF64"); code < 0) return code;
  const Task* task = find(handle);
  if (task == nullptr) return kInvalidTask;
  if (!task->started) return misused("read before start");
  if (order != 1) return misused("samples come grouped by scan");
  if (samples > task->samples) return refuse(kNotYet, "more samples than were acquired");
  if (size < static_cast<std::uint32_t>(samples * task->inputs)) return misused("array too small");
  card.timeout = timeout;
  *samples_read = samples - card.short_by;
  for (int sample = 0; sample < *samples_read; ++sample) {
    for (int channel = 0; channel < task->inputs; ++channel) {
      *into++ = card.volts ? card.volts(card.lines, channel, sample) : 0.0;
    }
  }
  return card.fail_function == "ReadAnalogF64" && card.fail_code > 0 ? card.fail_code : 0;
}

int DAQmxWriteDigitalLines(void* handle, int samples, std::uint32_t auto_start, double timeout, std::uint32_t,
                           const std::uint8_t* levels, int* samples_written, std::uint32_t*) {
  if (const int code = enter("WriteDigitalLines")) return code;
  const Task* task = find(handle);
  if (task == nullptr) return kInvalidTask;
  if (task->outputs == 0 || samples != 1 || auto_start == 0) return misused("one sample to lines, starting by itself");
  card.lines.assign(levels, levels + task->outputs);
  card.writes.push_back(card.lines);
  card.write_timeout = timeout;
  *samples_written = 1;
  return 0;
}

}  // extern "C"
