#include "analysis/identify/elam/lanes.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <limits>
#include <stdexcept>
#include <string>

// Vectors wider than the base's registers are passed between always-inlined functions only.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"
#include "analysis/identify/elam/lanes_kernel.h"

namespace tactbench::analysis {
namespace {

using Descending = void (*)(const LaneProblem&, const double*, std::size_t, double*, double*);
using Ascending = void (*)(AscendingLanes&, std::size_t, Gradient);

template <int N>
TACTBENCH_INLINE void descending(const LaneProblem& p, const double* alpha, std::size_t count, double* j,
                                 double* beta) {
  if (p.table.uniform())
    kernel::descending<N, true>(p, alpha, count, j, beta);
  else
    kernel::descending<N, false>(p, alpha, count, j, beta);
}

template <int N, bool kUniform>
TACTBENCH_INLINE void ascending_on(AscendingLanes& lanes, std::size_t count, Gradient gradient) {
  switch (gradient) {
    case Gradient::kNone:
      return kernel::ascending<N, kUniform, Gradient::kNone>(lanes, count);
    case Gradient::kPlane:
      return kernel::ascending<N, kUniform, Gradient::kPlane>(lanes, count);
    case Gradient::kSpace:
      return kernel::ascending<N, kUniform, Gradient::kSpace>(lanes, count);
  }
}

template <int N>
TACTBENCH_INLINE void ascending(AscendingLanes& lanes, std::size_t count, Gradient gradient) {
  if (lanes.problem->table.uniform())
    ascending_on<N, true>(lanes, count, gradient);
  else
    ascending_on<N, false>(lanes, count, gradient);
}

// An attribute and names cannot stand in parentheses. NOLINTBEGIN(bugprone-macro-parentheses)
#define TACTBENCH_LEVEL(name, lanes_of_level, target)                                                    \
  target void descending_##name(const LaneProblem& p, const double* alpha, std::size_t count, double* j, \
                                double* beta) {                                                          \
    descending<lanes_of_level>(p, alpha, count, j, beta);                                                \
  }                                                                                                      \
  target void ascending_##name(AscendingLanes& lanes, std::size_t count, Gradient gradient) {            \
    ascending<lanes_of_level>(lanes, count, gradient);                                                   \
  }
// NOLINTEND(bugprone-macro-parentheses)

TACTBENCH_LEVEL(base, 2, )
#if defined(__x86_64__)
TACTBENCH_LEVEL(avx2, 4, __attribute__((target("avx2"))))
TACTBENCH_LEVEL(avx512, 8, __attribute__((target("avx512f,avx512dq,avx512vl"))))
constexpr std::array<Descending, 3> kDescending{descending_base, descending_avx2, descending_avx512};
constexpr std::array<Ascending, 3> kAscending{ascending_base, ascending_avx2, ascending_avx512};
#else
constexpr std::array<Descending, 3> kDescending{descending_base, descending_base, descending_base};
constexpr std::array<Ascending, 3> kAscending{ascending_base, ascending_base, ascending_base};
#endif
#undef TACTBENCH_LEVEL

Dispatch chosen() {
  const char* name = std::getenv("TACTBENCH_LANES");  // read once, before any thread of ours
  for (const Dispatch dispatch : dispatches())
    if (name != nullptr && std::string(name) == to_string(dispatch)) return dispatch;
  return best_dispatch();
}

std::atomic<int> forced{-1};

}  // namespace
#pragma GCC diagnostic pop

Dispatch lane_dispatch() {
  const int dispatch = forced.load(std::memory_order_relaxed);
  if (dispatch >= 0) return static_cast<Dispatch>(dispatch);
  static const Dispatch own = chosen();
  return own;
}

void force_lane_dispatch(Dispatch dispatch) {
  if (std::ranges::find(dispatches(), dispatch) == dispatches().end())
    throw std::invalid_argument(std::string("this processor does not have the lanes of ") + to_string(dispatch));
  forced = static_cast<int>(dispatch);
}

void unforce_lane_dispatch() { forced = -1; }

void lane_descending(const LaneProblem& problem, std::span<const double> alpha, std::span<double> j,
                     std::span<double> beta) {
  kDescending[static_cast<std::size_t>(lane_dispatch())](problem, alpha.data(), alpha.size(), j.data(), beta.data());
}

void lane_ascending(AscendingLanes& lanes, std::size_t count, Gradient gradient) {
  kAscending[static_cast<std::size_t>(lane_dispatch())](lanes, (count + 7) / 8 * 8, gradient);
}

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

namespace {

std::size_t dispatches_here() {
#if defined(__x86_64__)
  if (!__builtin_cpu_supports("avx2")) return 1;
  // All instruction sets used by a version are checked; no known processor has only some of them.
  const bool avx512 = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                      __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl");
  return avx512 ? 3 : 2;
#else
  return 1;
#endif
}

}  // namespace

const char* to_string(Dispatch dispatch) {
  constexpr std::array kNames{"base", "avx2", "avx512"};
  return kNames[static_cast<std::size_t>(dispatch)];
}

std::span<const Dispatch> dispatches() {
  static constexpr std::array kAll{Dispatch::kBase, Dispatch::kAvx2, Dispatch::kAvx512};
  static const std::size_t count = dispatches_here();
  return std::span(kAll).first(count);
}

Dispatch best_dispatch() { return dispatches().back(); }

}  // namespace tactbench::analysis
