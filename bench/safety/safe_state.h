// Brings the bench to the safe state and proves it (docs/rules.md): vented, and pressure below the safe limit by two
// independent readings. A state that cannot be proved is reported as unverified. And which layers act if the program
// dies.
#pragma once

#include <string>
#include <vector>

#include "analysis/pressure_unit.h"
#include "bench/config/config.h"
#include "bench/rig/rig.h"
#include "db/record.h"

namespace tactbench::bench {

struct SafeProof {
  db::SafeState state = db::SafeState::kUnverified;
  analysis::PressureText text;  // text: "vented, verified (feedback 0.0 psi, reference 0.1 psi)"
};

// The frame of the unloaded array taken before the first load, mean counts per taxel; empty if there was none.
using UnloadedFrame = std::vector<double>;
UnloadedFrame unloaded_frame_of(const devices::ScanSet& scans);

// Vents, then retracts z if the stage was used, then reads the tactile array, if there is one, because it may
// contradict the pressures. The time is bounded by 10 s, 1.5 times SafetyLimits::vent_timeout_s and the module's
// watchdog (in process time), the travel of z home, and a few link timeouts.
SafeProof make_safe(Rig& rig, const UnloadedFrame& baseline) noexcept;

// Describes, for the preflight, the fail-safe layers of a bench that act when the program dies.
// One line per layer, fastest first. Never empty: a source without any layer gets a line that says so.
std::vector<std::string> fail_safe_layers(const BenchConfig& config,
                                          analysis::PressureUnit unit = analysis::PressureUnit::kPsi);

// What happens to the set-point when the pressure source is no longer reachable: "its watchdog (1000 ms) sets 0 V,
// ...".
std::string when_source_is_lost(const BenchConfig& config, analysis::PressureUnit unit = analysis::PressureUnit::kPsi);

}  // namespace tactbench::bench
