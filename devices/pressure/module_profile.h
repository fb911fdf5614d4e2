// Description of a Modbus analog module as data: its registers, scales and fail-safe behaviour. Profiles are files
// (devices/profiles/*.toml), read by bench/config/config_profile.h.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "devices/clock.h"
#include "devices/wire/modbus/modbus_value.h"

namespace tactbench::devices {

struct ModuleOutputs {
  int function = 16;        // 6, 16, or 23 (which reads the inputs in the same exchange)
  int address = 0;          // zero-based, of channel 0; one word per channel
  int channels = 0;         // 0: the module has no outputs
  int readback = 3;         // function that reads the outputs back at `address`; 0: none
  int dead_band = 0;        // counts by which the reading may differ from the written value
  Nanoseconds deadline{0};  // time after writing in which the reading may differ; 0: never
  LinearScale volts{0, 32767, 0, 10};
};

struct ModuleInputs {
  int function = 4;  // 3 or 4
  int address = 0;
  int channels = 0;  // 0: the module has no inputs
  int spare = 0;     // readable registers after the last channel (used to vary the length of RTU readings)
  RegisterFormat format{RegisterType::kI16};
  int status_offset = -1;  // registers from `address` to the status words, one per channel (ADAM-6024: 20); -1: none
  LinearScale volts{0, 32767, 0, 10};
};

struct ModuleFailSafe {
  std::vector<std::string> layers;   // protection layers as printed before a run; empty: none known
  int watchdog_address = -1;         // Beckhoff: 0x1120 time, +1 reset, +2 type, +3 fallback, +4 write lock; -1: none
  int fallbacks_address = -1;        // Beckhoff 0x1021: how often the watchdog fell back; -1: not reported
  int safe_mode_address = -1;        // Moxa: discrete inputs, one per output: the channel is in safe mode; -1: none
  int safe_mode_clear_address = -1;  // Moxa: coils that clear it
};

struct ModuleProfile {
  std::string name;   // "beckhoff-ek9000"
  std::string model;  // printed and stored: "Beckhoff EK9000 + EL4xxx/EL3xxx"
  bool tcp = true, rtu = false;
  Nanoseconds max_reply_delay = std::chrono::seconds(1);
  ModuleOutputs outputs;
  ModuleInputs inputs;
  ModuleFailSafe fail_safe;
  int dump_coil = -1;  // digital output that holds the dump valve closed (open without power); -1: no such valve
};

}  // namespace tactbench::devices
