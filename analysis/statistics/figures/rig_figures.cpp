#include "analysis/statistics/figures/rig_figures.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <tuple>
#include <vector>

#include "analysis/json_io.h"
#include "analysis/statistics/figures/levels.h"

namespace tactbench::analysis {
namespace {

// One level as it was held once: the frames from one command to the next.
struct RigHold {
  int repeat = 0, branch = 0;
  double setpoint_psi = 0.0, before_psi = 0.0;  // before: the level that was left
  bool first = false;                           // of its repeat: nothing was left
  std::vector<double> time_s, reference_psi, feedback_psi;
  std::vector<db::TracePoint> approach;
  double settling_s = 0.0;
};

std::vector<RigHold> holds_of(const StoredRun& run) {
  std::map<std::int64_t, db::BranchRecord> branches;
  for (const db::BranchRecord& branch : run.branches) branches[branch.branch] = branch;
  std::vector<RigHold> holds;
  for (const db::FrameRecord& frame : run.frames) {
    const db::BranchRecord& branch = branches.at(frame.branch);
    if (branch.is_void || frame.wrench || !std::isfinite(frame.reference_psi)) continue;
    const bool same_repeat = !holds.empty() && holds.back().repeat == branch.repeat;
    if (!same_repeat || holds.back().setpoint_psi != frame.setpoint_psi) {
      RigHold hold;
      hold.repeat = branch.repeat;
      hold.branch = branch.ordinal;
      hold.first = !same_repeat;
      hold.before_psi = same_repeat ? holds.back().setpoint_psi : frame.setpoint_psi;
      hold.setpoint_psi = frame.setpoint_psi;
      hold.approach = frame.trace;
      hold.settling_s = static_cast<double>(frame.since_command_ns - frame.in_band_ns) * 1e-9;
      holds.push_back(std::move(hold));
    }
    holds.back().time_s.push_back(static_cast<double>(frame.time_ns) * 1e-9);
    holds.back().reference_psi.push_back(frame.reference_psi);
    holds.back().feedback_psi.push_back(frame.feedback_psi);
  }
  return holds;
}

struct HoldLine {
  double slope = 0.0, rms = 0.0;
};

HoldLine line_through_hold(const std::vector<double>& x, const std::vector<double>& y) {
  const LineFit fit = line_fit(x, y);
  HoldLine line;
  line.slope = fit.xx > 0.0 ? fit.slope() : kNan;
  line.rms = std::sqrt(std::max(0.0, fit.yy - line.slope * fit.xy) / static_cast<double>(x.size()));
  return line;
}

void keep_largest(std::map<std::string, double>& figures, const char* name, double value) {
  if (!std::isfinite(value)) return;
  const auto [own, added] = figures.try_emplace(name, value);
  if (!added && std::abs(value) > std::abs(own->second)) own->second = value;
}

void keep_mean(std::map<std::string, double>& figures, const char* name, const std::vector<double>& values) {
  if (!values.empty()) figures[name] = mean_of(values);
}

// While the set-point moves, (set-point - reference) / rate; the first polls of a ramp are still catching up.
void gather_lags(const RigHold& hold, std::vector<double>& lags) {
  constexpr std::size_t kCatchingUp = 4;
  for (std::size_t i = kCatchingUp; i < hold.approach.size(); ++i) {
    const db::TracePoint &before = hold.approach[i - 1], &now = hold.approach[i];
    const double passed = before.before_frame_s - now.before_frame_s, moved = now.setpoint_psi - before.setpoint_psi;
    if (!(passed > 0.0) || moved == 0.0 || now.setpoint_psi == hold.setpoint_psi) continue;
    lags.push_back((now.setpoint_psi - now.reference_psi) * passed / moved);
  }
}

}  // namespace

std::map<std::string, double> chamber_figures(const StoredRun& run) {
  std::map<std::string, double> figures;
  std::vector<double> zero_reference, zero_feedback, offsets, settling, venting, lags, noise;
  std::map<std::pair<double, bool>, std::vector<double>> by_level;  // (set-point, rising) -> reference, by repeat
  for (const RigHold& hold : holds_of(run)) {
    const double reference = mean_of(hold.reference_psi), feedback = mean_of(hold.feedback_psi);
    const bool under_pressure = hold.setpoint_psi > 0.0;
    keep_largest(figures, "reference_minus_feedback_psi", reference - feedback);
    (under_pressure ? offsets : zero_reference).push_back(under_pressure ? reference - hold.setpoint_psi : reference);
    if (!under_pressure) zero_feedback.push_back(feedback);
    if (hold.time_s.size() >= 4) {
      const HoldLine line = line_through_hold(hold.time_s, hold.reference_psi);
      keep_largest(figures, "hold_drift_psi_per_min", 60.0 * line.slope);
      noise.push_back(line.rms * line.rms);
    }
    if (hold.first) continue;
    (under_pressure ? settling : venting).push_back(hold.settling_s);
    by_level[{hold.setpoint_psi, hold.setpoint_psi > hold.before_psi}].push_back(reference);
    gather_lags(hold, lags);
    const double direction = hold.setpoint_psi > hold.before_psi ? 1.0 : -1.0;
    for (const db::TracePoint& point : hold.approach)
      if (under_pressure)
        keep_largest(figures, "overshoot_psi", std::max(0.0, direction * (point.reference_psi - reference)));
  }
  if (offsets.empty()) return {};
  keep_mean(figures, "zero_reference_psi", zero_reference);
  keep_mean(figures, "zero_feedback_psi", zero_feedback);
  keep_mean(figures, "reference_minus_setpoint_psi", offsets);
  keep_mean(figures, "settling_s", settling);
  keep_mean(figures, "venting_s", venting);
  keep_mean(figures, "ramp_lag_s", lags);
  if (!noise.empty()) figures["hold_noise_psi"] = std::sqrt(mean_of(noise));
  for (const auto& [level, references] : by_level) {
    if (references.size() >= 2) keep_largest(figures, "repeatability_psi", sample_deviation(references));
    const auto rising = by_level.find({level.first, true});
    if (!level.second && rising != by_level.end())
      keep_largest(figures, "regulator_hysteresis_psi", mean_of(references) - mean_of(rising->second));
  }
  return figures;
}

std::map<std::string, double> press_figures(const StoredRun& run) {
  std::map<std::string, double> figures;
  std::map<std::int64_t, db::BranchRecord> branches;
  for (const db::BranchRecord& branch : run.branches) branches[branch.branch] = branch;
  std::map<std::tuple<int, double, double, double>, std::vector<double>> places;  // branch, target, x, y -> z
  std::map<std::int64_t, std::map<double, double>> rising;                        // of a loading branch: force -> z
  std::vector<double> relaxations, stiffnesses;
  for (const db::FrameRecord& frame : run.frames) {
    const db::BranchRecord& branch = branches.at(frame.branch);
    if (branch.is_void || !frame.wrench) continue;
    const db::WrenchRecord& press = *frame.wrench;
    if (branch.to_n > branch.from_n) rising[branch.branch][-press.wrench[2]] = press.place_mm[2];
    places[{branch.ordinal, press.target_n, press.place_mm[0], press.place_mm[1]}].push_back(press.place_mm[2]);
    if (press.force_start_n > 0.0)
      relaxations.push_back(100.0 * (press.force_start_n + press.wrench[2]) / press.force_start_n);  // -Fz presses
  }
  keep_mean(figures, "force_relaxation_percent", relaxations);
  for (const auto& [branch, heights] : rising) {
    const auto [low_n, low_mm] = *heights.begin();
    const auto [high_n, high_mm] = *heights.rbegin();
    if (high_mm > low_mm) stiffnesses.push_back((high_n - low_n) / (high_mm - low_mm));
  }
  keep_mean(figures, "press_stiffness_n_per_mm", stiffnesses);
  for (const auto& [place, heights] : places)
    if (heights.size() >= 2) keep_largest(figures, "stage_repeatability_um", 1000.0 * sample_deviation(heights));
  for (const db::CheckRecord& check : run.checks) {
    if (check.kind != "tare") continue;
    const auto detail = try_json(check.detail_json);
    if (detail.is_object() && detail.contains("drift_fz_n"))
      keep_largest(figures, "force_zero_drift_n", detail["drift_fz_n"].get<double>());
  }
  return figures;
}

}  // namespace tactbench::analysis
