#include "bench/safety/safe_state.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <numeric>
#include <optional>

#include "bench/process_time.h"

namespace tactbench::bench {

using devices::Nanoseconds;

namespace {

constexpr int kTries = 3;  // a link that fails this often in a row is given up

struct Witnesses {
  std::optional<double> feedback_psi, reference_psi;
};

// Waits for both pressures to fall, feeding the module on the way.
Witnesses watch_pressure_fall(Rig& rig) {
  const SafetyLimits& limits = rig.config().limits;
  devices::Clock& clock = rig.clock();
  const Nanoseconds deadline = clock.now() + seconds(limits.vent_timeout_s);
  Witnesses seen;
  for (int failures = 0; failures < kTries && clock.now() < deadline;) {
    try {
      rig.source().keep_alive();
      seen.feedback_psi = rig.source().feedback().pressure.value();
      seen.reference_psi = rig.reference().read().pressure.value();
      if (*seen.feedback_psi < limits.safe_psi && *seen.reference_psi < limits.safe_psi) return seen;
    } catch (const std::exception&) {
      ++failures;
      seen = {};
    }
    clock.wait_until(clock.now() + seconds(0.2));
  }
  return seen;
}

// Mean output back within 2 % of the converter's range of the unloaded frame: a witness that needs no module.
std::optional<bool> array_at_baseline(Rig& rig, const Baseline& baseline) {
  if (!rig.has_array() || baseline.empty()) return std::nullopt;
  try {
    const Baseline now = baseline_of(rig.array().read(1));
    const double rise =
        std::accumulate(now.begin(), now.end(), 0.0) - std::accumulate(baseline.begin(), baseline.end(), 0.0);
    return std::abs(rise) / static_cast<double>(baseline.size()) < 0.02 * 65535.0;
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

SafeProof prove(Rig& rig, const Baseline& baseline) {
  const SafetyLimits& limits = rig.config().limits;
  bool ordered = false;
  for (int i = 0; i < kTries && !ordered; ++i) ordered = rig.source().vent();
  Witnesses seen;
  if (ordered) seen = watch_pressure_fall(rig);
  std::vector<std::string> witnesses;
  int below = 0;
  bool above = false;
  const auto judge = [&](const char* name, const std::optional<double>& psi) {
    if (!psi) return;
    witnesses.push_back(fmt::format("{} {:.1f} psi", name, std::abs(*psi) < 0.05 ? 0.0 : *psi));  // no "-0.0"
    below += *psi < limits.safe_psi ? 1 : 0;
    above = above || *psi >= limits.safe_psi;
  };
  judge("feedback", seen.feedback_psi);
  if (rig.config().reference_independent) judge("reference", seen.reference_psi);
  if (below < 2) {
    if (!ordered) {  // the module's own watchdog vents it: give it the time that it needs
      rig.clock().wait_until(rig.clock().now() + seconds(rig.config().watchdog_s + limits.vent_timeout_s / 2));
    }
    const std::optional<bool> at_baseline = array_at_baseline(rig, baseline);
    if (at_baseline) {
      witnesses.push_back(*at_baseline ? "tactile array back at its unloaded baseline" : "tactile array still loaded");
      below += *at_baseline ? 1 : 0;
      above = above || !*at_baseline;
    }
  }
  SafeProof proof;
  proof.state = above ? db::SafeState::kFailed : below >= 2 ? db::SafeState::kVerified : db::SafeState::kUnverified;
  const char* head = proof.state == db::SafeState::kVerified ? "vented, verified"
                     : proof.state == db::SafeState::kFailed ? "NOT SAFE: pressure remains"
                                                             : "vent NOT verified";
  proof.text = fmt::format(
      "{} ({}{})", head, ordered ? "" : "the module did not take the order; its watchdog sets 0 V when not fed; ",
      witnesses.empty() ? "no witness could be read" : fmt::format("{}", fmt::join(witnesses, ", ")));
  return proof;
}

}  // namespace

Baseline baseline_of(const devices::ScanSet& scans) {
  const std::size_t taxels = static_cast<std::size_t>(scans.rows * scans.columns);
  Baseline mean(taxels, 0.0);
  for (std::size_t i = 0; i < scans.counts.size(); ++i)
    mean[i % taxels] += scans.counts[i] / static_cast<double>(scans.scans);
  return mean;
}

SafeProof make_safe(Rig& rig, const Baseline& baseline) noexcept {
  try {
    return prove(rig, baseline);
  } catch (const std::exception& error) {
    return {db::SafeState::kUnverified, fmt::format("vent NOT verified ({})", error.what())};
  }
}

}  // namespace tactbench::bench
