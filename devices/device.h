// Identity of a device: role, model, serial number, firmware; stored with each run.
#pragma once

#include <string>

namespace tactbench::devices {

enum class Origin { kSimulated, kHardware };

struct Identity {
  std::string role;  // "regulator", "pressure reference", "tactile scanner", ...
  std::string model;
  std::string serial;
  std::string firmware;
  Origin origin = Origin::kHardware;
};

}  // namespace tactbench::devices
