// The C interface of NI-DAQmx as far as tactbench uses it: own prototypes (x86-64 Linux: int32 is int, a task handle
// void*, bool32 unsigned, float64 double), the values of its constants, and the errors that are named here.
#pragma once

#include <cstdint>

namespace tactbench::devices {

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
