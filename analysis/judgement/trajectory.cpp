#include "analysis/judgement/trajectory.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "analysis/counted.h"
#include "analysis/json_fields.h"
#include "analysis/loop.h"
#include "analysis/statistics/numbers/moments.h"

namespace tactbench::analysis {
namespace {

constexpr double kFullSweepShare = 0.01;  // as external_loop
constexpr double kOtherDwellShare = 0.2;
constexpr std::size_t kFewestRandomTurns = 8;
constexpr double kTurnsAtEndsShare = 1.0 / 3.0;  // of random reversals at most; a first-order reversal curve has half

std::vector<double> set_points_of(const SequenceData& data) {
  std::vector<double> set_points;
  if (data.repeats.empty()) return set_points;
  for (const Sample& step : data.repeats.front().steps) set_points.push_back(step.setpoint_psi);
  return set_points;
}

bool same_path(const std::vector<double>& a, const std::vector<double>& b) {
  return std::ranges::equal(a, b, same_level);
}

double median_held_s(const Dataset& dataset) {
  std::vector<double> held;
  for (const SequenceData& data : dataset.sequences)
    for (const Repeat& repeat : data.repeats)
      for (const Sample& step : repeat.steps)
        if (step.held_s > 0.0) held.push_back(step.held_s);
  return median_of(std::move(held));
}

struct Path {
  std::size_t turns = 0, at_ends = 0, frames = 0, inner = 0;
};

Path path_of(const std::vector<double>& set_points, double low, double high) {
  Path path;
  const double near = kFullSweepShare * (high - low);
  const auto at_end = [&](double psi) { return psi - low <= near || high - psi <= near; };
  const std::vector<Branch> branches = branches_along(set_points);
  for (std::size_t i = 0; i < branches.size(); ++i) {
    const double from = set_points[static_cast<std::size_t>(branches[i].first)],
                 to = set_points[static_cast<std::size_t>(branches[i].last)];
    const auto frames = static_cast<std::size_t>(branches[i].last - branches[i].first);
    path.frames += frames;
    if (std::abs(to - from) < high - low - 2.0 * near) path.inner += frames;
    if (i + 1 == branches.size()) continue;
    ++path.turns;
    path.at_ends += at_end(to) ? 1 : 0;
  }
  return path;
}

}  // namespace

const char* to_string(Trajectory trajectory) {
  switch (trajectory) {
    case Trajectory::kAsFitted:
      return "set-points as fitted";
    case Trajectory::kRandomReversals:
      return "random reversals";
    case Trajectory::kOther:
      break;
  }
  return "other set-points";
}

JudgedTrajectory judged_trajectory(const Dataset& judged, const Dataset& fitted) {
  JudgedTrajectory out;
  out.run = judged.run;
  std::vector<std::vector<double>> own, known;
  for (const SequenceData& data : judged.sequences) own.push_back(set_points_of(data));
  for (const SequenceData& data : fitted.sequences) known.push_back(set_points_of(data));
  double low = kNan, high = kNan;
  for (const std::vector<double>& set_points : own)
    for (const double psi : set_points) {
      low = std::fmin(low, psi);
      high = std::fmax(high, psi);
    }
  bool as_fitted = true, random = false;
  std::size_t frames = 0, inner = 0;
  for (const std::vector<double>& set_points : own) {
    as_fitted &= std::ranges::any_of(known, [&](const auto& other) { return same_path(set_points, other); });
    const Path path = path_of(set_points, low, high);
    frames += path.frames;
    inner += path.inner;
    out.reversals = std::max(out.reversals, path.turns);
    random |= path.turns >= kFewestRandomTurns &&
              static_cast<double>(path.at_ends) < kTurnsAtEndsShare * static_cast<double>(path.turns);
  }
  out.inner_share = frames > 0 ? static_cast<double>(inner) / static_cast<double>(frames) : 0.0;
  out.trajectory = as_fitted ? Trajectory::kAsFitted : random ? Trajectory::kRandomReversals : Trajectory::kOther;
  set_dwell(out, median_held_s(judged), median_held_s(fitted));
  return out;
}

void set_dwell(JudgedTrajectory& judged, double dwell_s, double fitted_dwell_s) {
  judged.dwell_s = dwell_s;
  judged.fitted_dwell_s = fitted_dwell_s;
  judged.other_dwell = std::abs(dwell_s - fitted_dwell_s) > kOtherDwellShare * fitted_dwell_s;
}

std::string display_text(const JudgedTrajectory& judged) {
  std::string words = fmt::format("{}: {}, {:.0f} % of the frames on inner branches", to_string(judged.trajectory),
                                  counted(judged.reversals, "turning point"), 100.0 * judged.inner_share);
  if (std::isfinite(judged.dwell_s)) words += fmt::format("; dwell {:.1f} s", judged.dwell_s);
  if (judged.other_dwell) words += fmt::format(" (fitted: {:.1f} s)", judged.fitted_dwell_s);
  return words;
}

nlohmann::ordered_json trajectory_json(const JudgedTrajectory& judged) {
  return {{"trajectory", to_string(judged.trajectory)},
          JSON_FIELDS(judged, reversals, inner_share, dwell_s, fitted_dwell_s, other_dwell)};
}

}  // namespace tactbench::analysis
