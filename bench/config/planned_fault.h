// Faults that can be injected into the simulated rig, and what triggers them.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace tactbench::bench {

enum class FaultKind {  // each with the unit of its value, if it has one
  kValveStuck,          // holds the pressure, takes no command
  kLeak,                // psi/s
  kOvershoot,           // psi beyond the next level; `times` counts levels
  kSupplyLost,          // psi/s by which the pressure falls; it cannot rise
  kRegulatorUnpowered,  // the chamber keeps its pressure, the monitor reads 0 V
  kFeedbackOffset,      // psi, added to the monitor's reading
  kReferenceOffset,     // psi, added to the reference's reading
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
  kControllerRefused,    // it refuses every command
  kControllerUnplugged,  // the line hangs up permanently
  kStageStalled,         // 1 x, 2 y, 3 z, 0 all: does not move although the device counts steps
  kStageSilent,
  kStageLate,
  kStageCorrupt,
  kStageTorn,
  kStageUnplugged,  // the line hangs up permanently
  kForceSaturated,
  kForceStale,
  kForceSilent,
  kRowStuck,  // row whose counts no longer change
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
  // Condition that starts the fault, whichever is met first; none: at once.
  std::optional<double> at_s;    // process time
  std::optional<double> at_psi;  // the chamber's pressure first reaches this from below
  std::optional<double> at_n;    // the force on the specimen first reaches this
  double lasts_s = std::numeric_limits<double>::infinity();
  std::optional<double> value;  // none: the default of the kind
  long times = 0;               // number of answers affected; 0: no limit; kOvershoot: 1
};

}  // namespace tactbench::bench
