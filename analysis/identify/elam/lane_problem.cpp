#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "analysis/identify/elam/lanes.h"

namespace tactbench::analysis {
namespace {

constexpr double kUniform = 1e-10;  // of a step: how far a knot of a uniform grid may be off
constexpr std::size_t kParts = 64;

std::vector<std::size_t> first_segments(const std::vector<double>& knots) {
  std::vector<std::size_t> first(kParts + 1);
  const double width = (knots.back() - knots.front()) / static_cast<double>(kParts);
  std::size_t i = 0;
  for (std::size_t part = 0; part <= kParts; ++part) {
    const double start = knots.front() + width * (static_cast<double>(part) - 1e-6);
    while (i + 2 < knots.size() && knots[i + 1] <= start) ++i;
    first[part] = i;
  }
  return first;
}

}  // namespace

LaneTable::LaneTable(const PatternCurve& curve)
    : knots_(curve.x().begin(), curve.x().end()), y_(curve.y().begin(), curve.y().end()) {
  const auto steps = static_cast<double>(knots_.size() - 1);
  x0_ = knots_.front();
  per_x_ = steps / (knots_.back() - x0_);
  for (std::size_t i = 0; i < knots_.size(); ++i)
    uniform_ = uniform_ && std::abs((knots_[i] - x0_) * per_x_ - static_cast<double>(i)) < kUniform;
  if (uniform_)
    for (std::size_t i = 0; i < knots_.size(); ++i) knots_[i] = static_cast<double>(i);
  else
    per_x_ = static_cast<double>(kParts) / (knots_.back() - x0_);
  rows_.reserve(2 * knots_.size());
  for (std::size_t i = 0; i + 1 < knots_.size(); ++i) {
    rows_.insert(rows_.end(), {y_[i], y_[i + 1] - y_[i]});
    places_.insert(places_.end(), {knots_[i], 1.0 / (knots_[i + 1] - knots_[i])});
    by_y_.push_back((knots_[i + 1] - knots_[i]) / (y_[i + 1] - y_[i]));
  }
  rows_.insert(rows_.end(), {y_.back(), 0.0});
  next_y_.assign(y_.begin() + 1, y_.end());
  next_y_.back() = std::numeric_limits<double>::infinity();
  y0_ = y_.front();
  per_y_ = static_cast<double>(kParts) / (y_.back() - y0_);
  first_by_x_ = first_segments(knots_);
  first_by_y_ = first_segments(y_);
}

std::size_t LaneTable::segment(double u) const {
  if (uniform_) return static_cast<std::size_t>(std::clamp(u, 0.0, static_cast<double>(last())));
  const double part = (u - x0_) * per_x_;
  std::size_t i = part > 0.0 ? first_by_x_[static_cast<std::size_t>(std::min(part, static_cast<double>(kParts)))] : 0;
  while (i < last() && u >= knots_[i + 1]) ++i;
  return i;
}

double LaneTable::value(double u) const {
  const std::size_t i = segment(u);
  return rows_[2 * i] + rows_[2 * i + 1] * ((u - places_[2 * i]) * places_[2 * i + 1]);
}

LaneTable::Place LaneTable::inverse(double y) const {
  const double part = (y - y0_) * per_y_;
  std::size_t i = part > 0.0 ? first_by_y_[static_cast<std::size_t>(std::min(part, static_cast<double>(kParts)))] : 0;
  // Two steps without a branch are nearly always enough.
  i += y >= next_y_[i] ? 1 : 0;
  i += y >= next_y_[i] ? 1 : 0;
  while (y >= next_y_[i]) ++i;
  return {knots_[i] + (y - y_[i]) * by_y_[i], by_y_[i]};
}

LaneProblem lane_problem(const ElamModel& model, std::span<const CurveSamples> curves, bool ascending) {
  LaneProblem problem{LaneTable(ascending ? model.ascending : model.descending), 0, 0, 0, 0, 0, 0, {}, {}, {}, {}, {}};
  const LaneTable& table = problem.table;
  problem.x0 = table.unit(model.x0());
  problem.xu = table.unit(model.xu());
  problem.y0 = model.y0();
  problem.yu = model.yu();
  problem.smallest_rise = kSaturatedShare * (model.yu() - model.y0());
  std::vector<std::size_t> order;
  for (const CurveSamples& samples : curves) {
    LaneCurve curve;
    const double turn = std::clamp(samples.x_turn, model.x0(), model.xu());
    curve.first = problem.x.size();
    curve.x_turn = table.unit(turn);
    curve.y_turn = std::max(samples.y_turn, model.y0());
    if (ascending) curve.y_turn = std::min(curve.y_turn, model.yu());
    curve.rise = ascending ? model.yu() - curve.y_turn : curve.y_turn - model.y0();
    curve.length = problem.xu - curve.x_turn;
    curve.share = curve.length / (problem.xu - problem.x0);
    curve.x_pattern = table.inverse(curve.y_turn).u;
    order.resize(samples.x.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::ranges::sort(order, {}, [&](std::size_t i) { return samples.x[i]; });
    for (const std::size_t i : order) {
      const double x = samples.x[i], low = ascending ? turn : model.x0(), high = ascending ? model.xu() : turn;
      if (x <= low || x >= high) {
        const double end = x <= low ? (ascending ? curve.y_turn : model.y0()) : (ascending ? model.yu() : curve.y_turn);
        problem.constant += samples.weight[i] * (samples.y[i] - end) * (samples.y[i] - end);
        continue;
      }
      problem.x.push_back(table.unit(x));
      problem.y.push_back(samples.y[i]);
      problem.weight.push_back(samples.weight[i]);
      if (!ascending) problem.pattern.push_back(table.value(problem.x.back()) - model.y0());
    }
    curve.end = problem.x.size();
    problem.curves.push_back(curve);
  }
  return problem;
}

AscendingLanes::AscendingLanes(const LaneProblem& own, std::size_t most) : problem(&own), stride((most + 7) / 8 * 8) {
  for (std::vector<double>* list : {&u, &v, &beta}) list->assign(stride, 0.5);
  j.assign(stride, 0.0);
  is_split.assign(stride, false);
  splits.assign(stride * own.curves.size(), own.x0);
  by_beta.assign(stride * own.curves.size(), 0.0);
  for (auto& list : normal) list.assign(stride, 0.0);
  for (auto& list : right) list.assign(stride, 0.0);
}

void AscendingLanes::split(std::size_t i) {
  is_split[i] = true;
  for (std::size_t c = 0; c < problem->curves.size(); ++c) {
    const LaneCurve& curve = problem->curves[c];
    const LaneTable::Place place = problem->table.inverse(curve.y_turn + beta[i] * curve.rise);  // (22)
    splits[c * stride + i] = place.u;
    by_beta[c * stride + i] = place.by_y * curve.rise;
  }
}

}  // namespace tactbench::analysis
