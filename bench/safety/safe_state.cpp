#include "bench/safety/safe_state.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <functional>
#include <optional>
#include <utility>

#include "analysis/pressure_unit.h"
#include "analysis/statistics/numbers/moments.h"
#include "bench/common/process_time.h"
#include "bench/pressure/pressure_kinds.h"
#include "bench/safety/retract.h"

namespace tactbench::bench {

using devices::Nanoseconds;

namespace {

constexpr double kFilmRelaxes = 10.0;
constexpr int kTries = 3;  // after this many failures in a row the link is not tried again

// Feeds the module while it waits: after a pause's proof the run goes on, which it cannot once the module has fallen
// back. One that cannot be fed falls back as safe_state.h says.
class FedWait {
 public:
  explicit FedWait(Rig& rig) : rig_(rig) {}
  void feed() {
    if (failures_ == kTries) return;
    try {
      rig_.source().keep_alive();
    } catch (const std::exception&) {
      ++failures_;
    }
  }
  void until(Nanoseconds time) {
    devices::Clock& clock = rig_.clock();
    while (clock.now() < time) {
      clock.wait_until(std::min(time, clock.now() + seconds(0.2)));
      feed();
    }
  }

 private:
  Rig& rig_;
  int failures_ = 0;
};

// One instrument's reading of the chamber, as the guard sees it. A failure of one does not affect the other.
struct Witness {
  const char* name;
  const PressureWitness& seen;
  std::function<double()> read;
  double safe_psi, patience_s;
  std::optional<double> psi = std::nullopt;  // none: the last try to read it failed
  std::string doubt = {};                    // why this reading proves nothing
  int failures = 0;
  std::optional<Nanoseconds> doubted_since = std::nullopt;

  void look() {
    if (failures == kTries) return;
    psi.reset();
    try {
      psi = read();
    } catch (const std::exception&) {
      ++failures;
    }
  }
  // Once all have been read: standing still shows against the other's reading.
  void judge(Nanoseconds now) {
    doubt = psi ? seen.doubt() : "";
    if (doubt.empty()) {
      doubted_since.reset();
    } else if (!doubted_since) {
      doubted_since = now;
    }
  }
  [[nodiscard]] bool proves() const { return psi && doubt.empty() && *psi < safe_psi; }
  // A high reading warns even where it cannot be true.
  [[nodiscard]] bool warns() const { return psi && *psi >= safe_psi; }
  // There is nothing more to wait for.
  [[nodiscard]] bool settled(Nanoseconds now) const {
    return proves() || failures == kTries || (doubted_since && !warns() && now - *doubted_since > seconds(patience_s));
  }
  void append_to(analysis::PressureText& text) const {
    text += name;
    if (!psi) {
      text += " could not be read";
      return;
    }
    (text += " ").add(*psi, 1);
    if (!doubt.empty()) text += " (" + doubt + ")";
  }
};

std::vector<Witness> witnesses_of(Rig& rig) {
  const SafetyLimits& limits = rig.config().limits;
  std::vector<Witness> all = {{"feedback", rig.guard().feedback(),
                               [&rig] { return rig.source().feedback().pressure.value(); }, limits.safe_psi,
                               limits.disagreement_s}};
  if (rig.config().reference_independent) {
    all.push_back({"reference", rig.guard().reference(), [&rig] { return rig.reference().read().pressure.value(); },
                   limits.safe_psi, limits.disagreement_s});
  }
  return all;
}

// Waits for the pressures to fall. `feed`: the module still obeys.
void watch_pressure_fall(Rig& rig, std::vector<Witness>& witnesses, bool feed) {
  devices::Clock& clock = rig.clock();
  const Nanoseconds deadline = clock.now() + seconds(rig.config().limits.vent_timeout_s);
  FedWait wait(rig);
  for (;;) {
    if (feed) wait.feed();
    for (Witness& witness : witnesses) witness.look();
    for (Witness& witness : witnesses) witness.judge(clock.now());
    const auto settled = [&](const Witness& witness) { return witness.settled(clock.now()); };
    if (std::ranges::all_of(witnesses, settled) || clock.now() >= deadline) return;
    clock.wait_until(clock.now() + seconds(0.2));
  }
}

// Half of the taxels back within 2 % of the converter's range of the unloaded frame: a witness that needs no module.
// The median, so that a row that is stuck does not decide.
std::optional<bool> array_is_unloaded(Rig& rig, const UnloadedFrame& baseline) {
  if (!rig.has_array() || baseline.empty()) return std::nullopt;
  try {
    UnloadedFrame rise = unloaded_frame_of(rig.array().read(1));
    for (std::size_t i = 0; i < rise.size(); ++i) rise[i] -= baseline.at(i);
    const double middle = analysis::quantile_of(std::move(rise), 0.5);
    return middle < 0.02 * 65535.0;  // outputs below the unloaded frame: that frame still relaxed
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

// The same, once the film has had time to recover after the vent.
std::optional<bool> array_back(Rig& rig, const UnloadedFrame& baseline) {
  const Nanoseconds deadline = rig.clock().now() + seconds(kFilmRelaxes);
  FedWait wait(rig);
  std::optional<bool> is_unloaded = array_is_unloaded(rig, baseline);
  while (is_unloaded && !*is_unloaded && rig.clock().now() < deadline) {
    wait.until(rig.clock().now() + seconds(0.5));
    is_unloaded = array_is_unloaded(rig, baseline);
  }
  return is_unloaded;
}

// Both pressures come through one module, and a module that repeats old readings may show 0 psi at 60.
void contradict_by_array(Rig& rig, const UnloadedFrame& baseline, SafeProof& proof) {
  if (array_back(rig, baseline).value_or(true)) return;
  proof.state = db::SafeState::kUnverified;
  proof.text += "; NOT verified: the tactile array is still loaded, so one of the pressure instruments is wrong";
}

SafeProof prove(Rig& rig, const UnloadedFrame& baseline) {
  const BenchConfig& config = rig.config();
  bool ordered = false;
  for (int i = 0; i < kTries && !ordered; ++i) ordered = rig.source().vent();
  // Else the module's own watchdog may vent: waits for its timeout.
  if (!ordered) {
    rig.clock().wait_until(rig.clock().now() + seconds(config.watchdog_s + config.limits.vent_timeout_s / 2));
  }
  std::vector<Witness> witnesses = witnesses_of(rig);
  watch_pressure_fall(rig, witnesses, ordered);
  analysis::PressureText proved;
  std::vector<const char*> doubted;
  for (const Witness& witness : witnesses) {
    if (&witness != &witnesses.front()) proved += ", ";
    witness.append_to(proved);
    if (!witness.psi || !witness.doubt.empty()) doubted.push_back(witness.name);
  }
  auto below = std::ranges::count_if(witnesses, &Witness::proves);
  bool above = std::ranges::any_of(witnesses, &Witness::warns);
  if (below < 2) {
    const std::optional<bool> is_unloaded =
        ordered && !above ? array_back(rig, baseline) : array_is_unloaded(rig, baseline);
    if (is_unloaded) {
      proved += *is_unloaded ? ", tactile array back at its unloaded baseline" : ", tactile array still loaded";
      below += *is_unloaded ? 1 : 0;
      above = above || !*is_unloaded;
    }
  }
  // Where nothing holds the set-point at 0 psi, an empty chamber may be loaded again.
  const bool stays = ordered || (config.watchdog_s > 0.0 && zero_volt_vents(config));
  SafeProof proof;
  proof.state = above                 ? db::SafeState::kFailed
                : below >= 2 && stays ? db::SafeState::kVerified
                                      : db::SafeState::kUnverified;
  const bool verified = proof.state == db::SafeState::kVerified;
  const char* head = verified                                ? "vented, verified"
                     : proof.state == db::SafeState::kFailed ? "NOT SAFE: pressure remains"
                                                             : "vent NOT verified";
  const std::string order =
      ordered ? "" : "the pressure source did not accept the command: " + when_source_is_lost(config) + "; ";
  proof.text = fmt::format("{} ({}", head, order);
  proof.text.add(proved) += ")";
  if (!verified) proof.text += "; read a hand gauge before the chamber is opened";
  if (!verified && !doubted.empty())
    proof.text += fmt::format(", then check supply and wiring of {}", fmt::join(doubted, " and "));
  return proof;
}

// If 0 V does not vent, a module that is lost after the proof loads the chamber again.
void warn_of_lost_module(Rig& rig, SafeProof& proof) {
  const BenchConfig& config = rig.config();
  if (zero_volt_vents(config)) return;
  try {
    rig.source().keep_alive();
    proof.text += "; once it is no longer written to: " + when_source_is_lost(config);
  } catch (const std::exception&) {
    proof.state = db::SafeState::kUnverified;
    proof.text += "; NOT verified: the pressure source was lost: " + when_source_is_lost(config);
  }
}

// For a stage whose replies are lost but which may still obey. Returns the final force on the indenter; none: not
// known.
std::optional<double> send_home_unheard(Rig& rig, SafeProof& proof) {
  bool sent = rig.stage_gate()->send_home(devices::Axis::kZ);
  if (sent) proof.text += "; z was sent home without hearing of it";
  const Nanoseconds deadline = rig.clock().now() + rig.config().stage->axis(2).home_timeout;
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
    sent = rig.stage_gate()->send_home(devices::Axis::kZ);  // a single command may have been lost as well
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
  options.low_end_z_mm = rig.config().stage->axis(2).low.value();
  options.speed_mm_per_s = rig.config().stage->axis(2).maximum_speed.value();
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

UnloadedFrame unloaded_frame_of(const devices::ScanSet& scans) {
  const std::size_t taxels = static_cast<std::size_t>(scans.rows * scans.columns);
  UnloadedFrame mean(taxels, 0.0);
  for (std::size_t i = 0; i < scans.counts.size(); ++i)
    mean[i % taxels] += scans.counts[i] / static_cast<double>(scans.scans);
  return mean;
}

SafeProof make_safe(Rig& rig, const UnloadedFrame& baseline) noexcept {
  SafeProof proof;
  try {
    proof = prove(rig, baseline);
  } catch (const std::exception& error) {
    proof = {db::SafeState::kUnverified, fmt::format("vent NOT verified ({})", error.what())};
  }
  try {
    retract_stage(rig, proof);
  } catch (const std::exception& error) {
    proof.state = db::SafeState::kUnverified;
    proof.text += fmt::format("; retraction NOT verified ({})", error.what());
  }
  try {
    if (proof.state == db::SafeState::kVerified) contradict_by_array(rig, baseline, proof);
    if (proof.state == db::SafeState::kVerified) warn_of_lost_module(rig, proof);
  } catch (const std::exception& error) {
    proof.state = db::SafeState::kUnverified;
    proof.text += fmt::format("; NOT verified ({})", error.what());
  }
  return proof;
}

using analysis::PressureUnit;

std::string when_source_is_lost(const BenchConfig& config, PressureUnit unit) {
  return pressure_kind(config).when_lost(config, unit);
}

std::vector<std::string> fail_safe_layers(const BenchConfig& config, PressureUnit unit) {
  std::vector<std::string> lines = {"tactbench: every run ends vented, with proof of it; trip above " +
                                    unit.short_text(config.limits.trip_psi)};
  if (!config.in_process && config.dead_man.enabled) {
    lines.push_back(fmt::format(
        "dead-man in a separate process: fires when the program ends, is stopped for {:g} ms or makes no progress "
        "for {:g} ms; vents over {}{}{}",
        1000.0 * config.dead_man.timeout_s, 1000.0 * config.dead_man.progress_s,
        on_serial_line(config) ? "the same serial line, which it then opens" : "its own connection",
        config.stage ? fmt::format(", stops the stage and backs z off by {:g} mm", config.dead_man.back_off_mm) : "",
        on_serial_line(config)       ? ""  // one line, which the sequencer reads
        : config.dead_man.blind_ends ? "; if it can no longer reach the module the run ends"
                                     : "; if it can no longer reach the module the run is warned"));
  } else if (!config.in_process) {
    lines.push_back(fmt::format("WARNING: [dead_man] enabled = false: when the program dies, {}",
                                when_source_is_lost(config, unit)));
  }
  const std::vector<std::string> own = pressure_kind(config).layers(config, unit);
  lines.insert(lines.end(), own.begin(), own.end());
  return lines;
}

}  // namespace tactbench::bench
