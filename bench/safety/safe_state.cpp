#include "bench/safety/safe_state.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <optional>
#include <utility>

#include "analysis/statistics/numbers/moments.h"
#include "bench/common/process_time.h"
#include "bench/safety/retract.h"

namespace tactbench::bench {

using devices::Nanoseconds;

namespace {

constexpr double kFilmRelaxes = 10.0;
constexpr int kTries = 3;  // after this many failures in a row the link is not tried again

struct Witnesses {
  std::optional<double> feedback_psi, reference_psi;
};

// Waits, feeding the module on the way: after a pause's proof the run goes on, which it cannot once the module has
// fallen back. One that cannot be fed falls back to 0 V.
class FedWait {
 public:
  explicit FedWait(Rig& rig) : rig_(rig) {}
  void until(Nanoseconds time) {
    devices::Clock& clock = rig_.clock();
    while (clock.now() < time) {
      clock.wait_until(std::min(time, clock.now() + seconds(0.2)));
      if (failures_ == kTries) continue;
      try {
        rig_.source().keep_alive();
      } catch (const std::exception&) {
        ++failures_;
      }
    }
  }

 private:
  Rig& rig_;
  int failures_ = 0;
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

// Half of the taxels back within 2 % of the converter's range of the unloaded frame: a witness that needs no module.
// The median, so that a row that is stuck does not decide.
std::optional<bool> array_at_baseline(Rig& rig, const Baseline& baseline) {
  if (!rig.has_array() || baseline.empty()) return std::nullopt;
  try {
    Baseline rise = baseline_of(rig.array().read(1));
    for (std::size_t i = 0; i < rise.size(); ++i) rise[i] -= baseline.at(i);
    const double middle = analysis::quantile_of(std::move(rise), 0.5);
    return middle < 0.02 * 65535.0;  // outputs below the unloaded frame: that frame still relaxed
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

// Both pressures come through one module, and a module that repeats old readings may show 0 psi at 60. The film needs a
// moment to recover after the vent.
void hear_array(Rig& rig, const Baseline& baseline, SafeProof& proof) {
  const Nanoseconds deadline = rig.clock().now() + seconds(kFilmRelaxes);
  FedWait wait(rig);
  std::optional<bool> at_baseline = array_at_baseline(rig, baseline);
  while (at_baseline && !*at_baseline && rig.clock().now() < deadline) {
    wait.until(rig.clock().now() + seconds(0.5));
    at_baseline = array_at_baseline(rig, baseline);
  }
  if (!at_baseline || *at_baseline) return;
  proof.state = db::SafeState::kUnverified;
  proof.text += "; NOT verified: the tactile array is still loaded, so one of the witnesses is wrong";
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
    if (!ordered) {  // the module's own watchdog vents: waits for its timeout
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

// For a stage whose replies are lost but which may still obey. Returns the final force on the indenter; none: not
// known.
std::optional<double> send_home_unheard(Rig& rig, SafeProof& proof) {
  bool sent = rig.send_z_home();
  if (sent) proof.text += "; z was sent home without hearing of it";
  const Nanoseconds deadline = rig.clock().now() + rig.config().stage->options.axes[2].home_timeout;
  std::optional<double> force_n;
  for (int failures = 0; failures < kTries;) {
    try {
      force_n = std::abs(rig.force()->read(RetractOptions().records).wrench.force_n[2]);
      if (*force_n < rig.config().limits.contact_n) break;
    } catch (const std::exception&) {
      ++failures;
      force_n.reset();
    }
    if (!sent || rig.clock().now() >= deadline) break;
    rig.clock().wait_until(rig.clock().now() + seconds(5.0));
    sent = rig.send_z_home();  // a single command may have been lost as well
  }
  // No position is known: waits as long as homing takes.
  if (sent && !force_n) rig.clock().wait_until(deadline);
  if (force_n) proof.text += fmt::format(", {:.2f} N then", *force_n);
  return force_n;
}

// The stage has been near the specimen only where force is measured.
void retract_stage(Rig& rig, SafeProof& proof) {
  if (rig.stage_gate() == nullptr || rig.force() == nullptr) return;
  const SafetyLimits& limits = rig.config().limits;
  RetractOptions options;
  options.clear_z_mm = limits.clear_z_mm;
  options.speed_mm_per_s = rig.config().stage->options.axes[2].maximum_speed.value();
  options.safe_force_n = limits.contact_n;
  FedWait wait(rig);
  const RetractProof stage =
      retract(*rig.stage_gate(), rig.force(), rig.clock(), options, [&](Nanoseconds time) { wait.until(time); });
  proof.text += "; " + stage.text;
  if (stage.verified) return;
  const std::optional<double> force_n = stage.z_mm ? stage.force_n : send_home_unheard(rig, proof);
  if (force_n && !(*force_n < limits.contact_n)) {
    proof.state = db::SafeState::kFailed;
  } else if (proof.state == db::SafeState::kVerified) {
    proof.state = db::SafeState::kUnverified;
  }
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
  SafeProof proof;
  try {
    proof = prove(rig, baseline);
  } catch (const std::exception& error) {
    proof = {db::SafeState::kUnverified, fmt::format("vent NOT verified ({})", error.what())};
  }
  try {
    retract_stage(rig, proof);
  } catch (const std::exception& error) {
    proof = {db::SafeState::kUnverified, fmt::format("{}; retraction NOT verified ({})", proof.text, error.what())};
  }
  try {
    if (proof.state == db::SafeState::kVerified) hear_array(rig, baseline, proof);
  } catch (const std::exception& error) {
    proof = {db::SafeState::kUnverified, fmt::format("{}; NOT verified ({})", proof.text, error.what())};
  }
  return proof;
}

}  // namespace tactbench::bench
