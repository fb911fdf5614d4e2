#include "analysis/identify/elam/lanes.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "analysis/identify/elam/vector_lanes.h"

// Vectors wider than the base's registers are passed between always-inlined functions only.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wpsabi"

namespace tactbench::analysis {
namespace {

// Start and rise of the segment that holds u, and how far into it u lies (in segments). `per` is 1 / width.
template <bool kUniform>
TACTBENCH_INLINE void look_up(const LaneTable& table, const double* rows, const Lanes& u, Lanes& start, Lanes& rise,
                              Lanes& part, Lanes& per) {
  if constexpr (kUniform) {
    const auto index = __builtin_convertvector(u, LaneIndex);  // rounding beyond the range: 0, or xu's
    part = u - __builtin_convertvector(index, Lanes);
    for (std::size_t k = 0; k < kLanes; ++k) {
      start[k] = rows[2 * index[k]];
      rise[k] = rows[2 * index[k] + 1];
    }
  } else {
    for (std::size_t k = 0; k < kLanes; ++k) {
      const std::size_t i = table.segment(u[k]);
      start[k] = rows[2 * i];
      rise[k] = rows[2 * i + 1];
      per[k] = table.places()[2 * i + 1];
      part[k] = (u[k] - table.places()[2 * i]) * per[k];
    }
  }
}

TACTBENCH_INLINE void bounds(const Lanes& values, double& low, double& high) {
  low = high = values[0];
  for (std::size_t k = 1; k < kLanes; ++k) {
    low = values[k] < low ? values[k] : low;
    high = values[k] > high ? values[k] : high;
  }
}

template <bool kUniform>
TACTBENCH_INLINE void descending_on(const LaneProblem& p, const double* alphas, std::size_t count, double* js,
                                    double* betas) {
  const Lanes zero{}, one = zero + 1.0;
  const double* rows = p.table.rows();
  const double nothing = 1e-12 * (p.xu - p.x0);
  for (std::size_t at = 0; at < count; at += kLanes) {
    Lanes alpha;
    load(alpha, alphas + at);
    Lanes rr = zero + p.constant, gr = zero, gg = zero;  // of residuals at beta_d = 1 and their slopes
    for (const LaneCurve& curve : p.curves) {
      const Lanes xs = p.x0 + alpha * (curve.x_turn - p.x0);  // (14)
      Lanes start, rise, part, per = one;
      look_up<kUniform>(p.table, rows, xs, start, rise, part, per);
      const Lanes ysp = start + rise * part;
      const Lanes right_x = curve.x_turn - xs, left_x = xs - p.x0, right_y = p.yu - ysp, left_y = ysp - p.y0;
      const auto right_flat = right_y <= p.smallest_rise, left_flat = left_y <= p.smallest_rise;
      const Lanes by_right_x = 1.0 / (right_x > nothing ? right_x : zero + nothing);
      const Lanes by_left_x = 1.0 / (left_x > nothing ? left_x : zero + nothing);
      const Lanes by_right_y = 1.0 / (right_flat ? one : right_y), by_left_y = 1.0 / (left_flat ? one : left_y);
      const Lanes stretch = (p.xu - xs) * by_right_x;
      double low = 0.0, high = 0.0;
      bounds(xs, low, high);
      for (std::size_t i = curve.first; i < curve.end; ++i) {
        const double x = p.x[i], weight = p.weight[i];
        Lanes slope = zero, residual = zero;
        if (x < high) {  // left of the split in some lane, Eqs (18), (19)
          slope = curve.rise * (left_flat ? (x - p.x0) * by_left_x : p.pattern[i] * by_left_y);
          residual = (p.y[i] - p.y0) - slope;
        }
        if (x >= low) {  // Eqs (16), (17): flat at y_turn for beta_d = 1
          const auto right = xs <= x;
          const Lanes off = right ? x - xs : zero;  // a lane left of the split must read a valid entry, too
          look_up<kUniform>(p.table, rows, xs + stretch * off, start, rise, part, per);
          const Lanes share = right_flat ? off * by_right_x : (start + rise * part - ysp) * by_right_y;
          slope = right ? curve.rise * (1.0 - share) : slope;
          residual = right ? zero + (p.y[i] - curve.y_turn) : residual;
        }
        const Lanes weighted = weight * slope;
        rr += weight * residual * residual;
        gr += weighted * residual;
        gg += weighted * slope;
      }
    }
    Lanes step = gr / (gg > 0.0 ? gg : one);  // of beta_d, from 1
    step = step < 0.0 ? step : zero;
    step = step > -1.0 ? step : zero - 1.0;
    const Lanes j = rr + step * (gg * step - 2.0 * gr);
    store(js + at, j);
    store(betas + at, Lanes(1.0 + step));
  }
}

template <bool kUniform, Gradient kGradient>
TACTBENCH_INLINE void ascending_on(AscendingLanes& lanes, std::size_t count) {
  const LaneProblem& p = *lanes.problem;
  const Lanes zero{}, one = zero + 1.0;
  const double* rows = p.table.rows();
  const double nothing = 1e-12 * (p.xu - p.x0);
  for (std::size_t at = 0; at < count; at += kLanes) {
    Lanes u, v, j = zero + p.constant;
    load(u, &lanes.u[at]);
    load(v, &lanes.v[at]);
    Lanes normal[6] = {zero, zero, zero, zero, zero, zero}, right[3] = {zero, zero, zero};
    std::size_t from = at;  // in splits and by_beta, which are empty where there are no curves
    for (const LaneCurve& curve : p.curves) {
      Lanes split, by_beta;
      load(split, lanes.splits.data() + from);
      load(by_beta, lanes.by_beta.data() + from);
      from += lanes.stride;
      const Lanes xs = curve.x_turn + (u + (v - u) * curve.share) * curve.length;  // (21)
      const Lanes left_x = xs - curve.x_turn, right_x = p.xu - xs;
      const Lanes by_left = 1.0 / (left_x > nothing ? left_x : zero + nothing);
      const Lanes by_right = 1.0 / (right_x > nothing ? right_x : zero + nothing);
      const Lanes left_stretch = (split - curve.x_pattern) * by_left, right_stretch = (p.xu - split) * by_right;
      double low = 0.0, high = 0.0;
      bounds(xs, low, high);
      // Sums of weight x (dy/dsplit)^2 and weight x residual x dy/dsplit, on either side of the split; dy/dxs is
      // -stretch x dy/dsplit.
      Lanes left_qq = zero, left_rq = zero, right_qq = zero, right_rq = zero;
      for (std::size_t i = curve.first; i < curve.end; ++i) {
        const double x = p.x[i], weight = p.weight[i];
        Lanes start = zero, rise = zero, part = zero, per = one, pattern = zero, inside = zero;
        const double off = x - curve.x_turn;
        if (x <= low) {  // left of the split in all lanes, Eqs (25), (26)
          pattern = curve.x_pattern + left_stretch * off;
          if constexpr (kGradient != Gradient::kNone) inside = off * by_left;
        } else if (x > high) {  // Eqs (23), (24)
          pattern = split + right_stretch * (x - xs);
          if constexpr (kGradient != Gradient::kNone) inside = 1.0 - (x - xs) * by_right;
        } else {
          const auto left = xs >= x;
          pattern = left ? curve.x_pattern + left_stretch * off : split + right_stretch * (x - xs);
          if constexpr (kGradient != Gradient::kNone) inside = left ? off * by_left : 1.0 - (x - xs) * by_right;
        }
        look_up<kUniform>(p.table, rows, pattern, start, rise, part, per);
        const Lanes residual = p.y[i] - (start + rise * part);
        const Lanes weighted = weight * residual;
        j += weighted * residual;
        if constexpr (kGradient != Gradient::kNone) {
          const Lanes q = (kUniform ? rise : rise * per) * inside;
          const Lanes qq = weight * q * q, rq = weighted * q;
          if (x <= low) {
            left_qq += qq;
            left_rq += rq;
          } else if (x > high) {
            right_qq += qq;
            right_rq += rq;
          } else {
            const auto left = xs >= x;
            left_qq += left ? qq : zero;
            left_rq += left ? rq : zero;
            right_qq += left ? zero : qq;
            right_rq += left ? zero : rq;
          }
        }
      }
      if constexpr (kGradient != Gradient::kNone) {
        const double by_u = curve.length * (1.0 - curve.share), by_v = curve.length * curve.share;
        const Lanes ll = left_stretch * left_stretch * left_qq + right_stretch * right_stretch * right_qq;
        const Lanes l = -(left_stretch * left_rq + right_stretch * right_rq);
        normal[0] += ll * (by_u * by_u);
        normal[1] += ll * (by_u * by_v);
        normal[2] += ll * (by_v * by_v);
        right[0] += l * by_u;
        right[1] += l * by_v;
        if constexpr (kGradient == Gradient::kSpace) {
          const Lanes ls = -(left_stretch * left_qq + right_stretch * right_qq) * by_beta;
          normal[3] += ls * by_u;
          normal[4] += ls * by_v;
          normal[5] += (left_qq + right_qq) * by_beta * by_beta;
          right[2] += (left_rq + right_rq) * by_beta;
        }
      }
    }
    store(&lanes.j[at], j);
    if constexpr (kGradient != Gradient::kNone) {
      constexpr int kNormal = kGradient == Gradient::kSpace ? 6 : 3, kRight = kGradient == Gradient::kSpace ? 3 : 2;
      for (int k = 0; k < kNormal; ++k) store(&lanes.normal[static_cast<std::size_t>(k)][at], normal[k]);
      for (int k = 0; k < kRight; ++k) store(&lanes.right[static_cast<std::size_t>(k)][at], right[k]);
    }
  }
}

template <bool kUniform>
TACTBENCH_INLINE void ascending_by(AscendingLanes& lanes, std::size_t count, Gradient gradient) {
  switch (gradient) {
    case Gradient::kNone:
      return ascending_on<kUniform, Gradient::kNone>(lanes, count);
    case Gradient::kPlane:
      return ascending_on<kUniform, Gradient::kPlane>(lanes, count);
    case Gradient::kSpace:
      return ascending_on<kUniform, Gradient::kSpace>(lanes, count);
  }
}

TACTBENCH_CLONES void descending(const LaneProblem& p, const double* alpha, std::size_t count, double* j,
                                 double* beta) {
  if (p.table.uniform())
    descending_on<true>(p, alpha, count, j, beta);
  else
    descending_on<false>(p, alpha, count, j, beta);
}

TACTBENCH_CLONES void ascending(AscendingLanes& lanes, std::size_t count, Gradient gradient) {
  if (lanes.problem->table.uniform())
    ascending_by<true>(lanes, count, gradient);
  else
    ascending_by<false>(lanes, count, gradient);
}

}  // namespace
#pragma GCC diagnostic pop

void lane_descending(const LaneProblem& problem, std::span<const double> alpha, std::span<double> j,
                     std::span<double> beta) {
  descending(problem, alpha.data(), alpha.size(), j.data(), beta.data());
}

void lane_ascending(AscendingLanes& lanes, std::size_t count, Gradient gradient) {
  ascending(lanes, (count + kLanes - 1) / kLanes * kLanes, gradient);
}

namespace {

constexpr double kSameStep = 1e-10;  // of a step: how far a knot of a uniform grid may be off
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
    uniform_ = uniform_ && std::abs((knots_[i] - x0_) * per_x_ - static_cast<double>(i)) < kSameStep;
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
