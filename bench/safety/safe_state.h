// The safe state, brought about and proved (contract.md, "Safe"): vented, and pressure below the safe limit by two
// witnesses. What cannot be reached is reported unverified.
#pragma once

#include <string>
#include <vector>

#include "bench/rig.h"
#include "db/record.h"

namespace tactbench::bench {

struct SafeProof {
  db::SafeState state = db::SafeState::kUnverified;
  std::string text;  // for people: "vented; feedback 0.0 psi, reference 0.1 psi"
};

// The unloaded frame taken before the first load, mean counts per taxel; empty when there was none.
using Baseline = std::vector<double>;
Baseline baseline_of(const devices::ScanSet& scans);

// Bounded by SafetyLimits::vent_timeout_s of process time plus a few link timeouts.
SafeProof make_safe(Rig& rig, const Baseline& baseline) noexcept;

}  // namespace tactbench::bench
