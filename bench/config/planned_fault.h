// Faults that can be injected into the simulated rig, and what triggers them.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace tactbench::bench {

enum class FaultKind {  // with the unit of the value, where there is one
  kValveStuck,          // holds the pressure, takes no command
  kLeak,                // psi/s
  kOvershoot,           // psi beyond the next level; a level is one time
  kSupplyLost,          // psi/s by which the pressure falls; it cannot rise
  kRegulatorUnpowered,  // the chamber keeps its pressure, the monitor reads 0 V
  kFeedbackOffset,      // psi, of the monitor
  kReferenceOffset,     // psi, of the reference
  kModuleSilent,
  kModuleLate,
  kModuleCorrupt,
  kModuleStale,       // reads return the previous values
  kModuleException,   // server device failure
  kModuleBusy,        // server device busy
  kModuleUnplugged,   // TCP: connections close at once; serial: silence
  kControllerSilent,  // of a serial regulator
  kControllerLate,
  kControllerCorrupt,
  kControllerRefused,    // it carries nothing out
  kControllerUnplugged,  // the line hangs up for good
  kStageStalled,         // 1 x, 2 y, 3 z, 0 all: does not move although the device counts steps
  kStageSilent,
  kStageLate,
  kStageCorrupt,
  kStageTorn,
  kStageUnplugged,  // the line hangs up for good
  kForceSaturated,
  kForceStale,
  kForceSilent,
  kRowStuck,  // row: its counts stay as they are
  kScannerSilent,
  kScannerStale,
  kScannerCorrupt,
  kScannerTorn,  // a report is missing
  kScannerUnplugged,
};
inline constexpr int kFaultKinds = static_cast<int>(FaultKind::kScannerUnplugged) + 1;
[[nodiscard]] const std::vector<std::string>& fault_kind_names();  // "valve_stuck", in the order of FaultKind
[[nodiscard]] double default_fault_value(FaultKind kind);

struct PlannedFault {
  FaultKind kind = FaultKind::kLeak;
  // What starts it, whichever is first; none: at once.
  std::optional<double> at_s;    // process time
  std::optional<double> at_psi;  // the chamber's pressure first comes to this from below
  std::optional<double> at_n;    // the force on the specimen first comes to this
  double lasts_s = std::numeric_limits<double>::infinity();
  std::optional<double> value;  // none: the usual one
  long times = 0;               // number of answers affected; 0: no limit; kOvershoot: 1
};

}  // namespace tactbench::bench
