#include "analysis/identify/rivals/gpi_search.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

namespace tactbench::analysis {
namespace {

constexpr double kConverged = 1e-12;  // share by which J fell
constexpr double kLargestDamping = 1e9;

// The unknowns stay where exponentials are harmless; no fit that was seen came near.
GpiVector within(GpiVector p) {
  const double low = std::log(1e-3), high = std::log(60.0);
  for (const int k : {kLnA, kLnB}) p[k] = std::clamp(p[k], low, high);
  for (const int k : {kLnDl, kLnDr}) p[k] = std::clamp(p[k], -20.0, 10.0);
  p[kLnAlpha] = std::clamp(p[kLnAlpha], -10.0, 4.0);
  p[kS] = std::clamp(p[kS], -8.0, 20.0);
  for (const int k : {kL0, kR0}) p[k] = std::clamp(p[k], -1e3, 1e3);
  return p;
}

enum Side : unsigned char { kLeft, kRight, kStart };

// An operator's output is an envelope at an earlier knot less or plus r_i, or still its start: with that kept, the
// derivative costs a look-up.
struct Operator {
  double output = 0.0;
  Side side = kStart;
  std::size_t knot = 0;
};
using Operators = std::array<Operator, kGpiOperators>;

}  // namespace

struct GpiSearch::Table {
  std::vector<double> left, left_by_ln_a, left_by_ln_dl, right, right_by_ln_b, right_by_ln_dr;

  static void fill(std::span<const double> knots, double ln_a, double start, double ln_rise, std::vector<double>& value,
                   std::vector<double>& by_ln_a, std::vector<double>& by_ln_rise) {
    const double a = std::exp(ln_a), rise = std::exp(ln_rise), end = std::exp(-a), whole = -std::expm1(-a);
    value.resize(knots.size());
    by_ln_a.resize(knots.size());
    by_ln_rise.resize(knots.size());
    for (std::size_t k = 0; k < knots.size(); ++k) {
      const double below = std::expm1(-a * knots[k]), shape = -below / whole;
      value[k] = start + rise * shape;
      by_ln_rise[k] = rise * shape;
      by_ln_a[k] = rise * a * (knots[k] * (1.0 + below) - shape * end) / whole;
    }
  }
};

GpiParameters gpi_parameters(const GpiVector& p, double x_span, double y_span) {
  GpiParameters found;
  const auto envelope = [&](double ln_a, double start, double ln_rise, double& a0, double& a1, double& a3) {
    const double a = std::exp(ln_a);
    a0 = y_span * std::exp(ln_rise) / -std::expm1(-a);
    a1 = a / x_span;
    a3 = y_span * start + a0;
  };
  envelope(p[kLnA], p[kL0], p[kLnDl], found.a0, found.a1, found.a3);
  envelope(p[kLnB], p[kR0], p[kLnDr], found.b0, found.b1, found.b3);
  found.alpha = y_span * std::exp(p[kLnAlpha]);
  found.tau = p[kS] / found.alpha;
  return found;
}

GpiSearch::GpiSearch(const FitSamples& samples) {
  const double span = samples.x_high - samples.x_low;
  const auto share = [&](std::size_t i) { return (samples.x[i] - samples.x_low) / span; };
  std::vector<bool> fitted(samples.x.size(), false), used(samples.x.size(), false);
  for (const std::size_t i : samples.fitted) fitted[i] = used[i] = true;
  for (const FitSamples::Part& part : samples.parts) used[part.first] = used[part.last] = true;
  knots_.push_back(0.0);
  for (std::size_t i = 0; i < used.size(); ++i)
    if (used[i]) knots_.push_back(share(i));
  std::ranges::sort(knots_);
  knots_.erase(std::unique(knots_.begin(), knots_.end()), knots_.end());
  const auto knot = [&](std::size_t i) {
    return static_cast<std::size_t>(std::ranges::lower_bound(knots_, share(i)) - knots_.begin());
  };
  for (const FitSamples::Part& part : samples.parts) {
    if (part.opens_history) steps_.push_back({0, 0, true, false, true});
    if (part.opens_history) steps_.push_back({knot(part.first), 0, false, false, true});
    for (std::size_t i = part.first + 1; i <= part.last; ++i)
      if (fitted[i] || i == part.last) steps_.push_back({knot(i), i, false, fitted[i], i == part.last});
  }
}

void GpiSearch::evaluate(const GpiVector& p, std::span<const double> y, Table& table, Normal& into) const {
  Table::fill(knots_, p[kLnA], p[kL0], p[kLnDl], table.left, table.left_by_ln_a, table.left_by_ln_dl);
  Table::fill(knots_, p[kLnB], p[kR0], p[kLnDr], table.right, table.right_by_ln_b, table.right_by_ln_dr);
  std::array<double, kGpiOperators> threshold, density;
  for (std::size_t i = 0; i < threshold.size(); ++i) {
    threshold[i] = std::exp(p[kLnAlpha]) * static_cast<double>(i);
    density[i] = std::exp(-p[kS] * static_cast<double>(i));
  }
  into.j = 0.0;
  into.hessian.setZero();
  into.gradient.setZero();
  Operators operators{};
  for (const Step& step : steps_) {
    if (step.virgin) operators = {};
    Operators now = operators;
    const double left = table.left[step.knot], right = table.right[step.knot];
    for (std::size_t i = 0; i < now.size(); ++i) {
      if (right + threshold[i] < now[i].output) now[i] = {right + threshold[i], kRight, step.knot};
      if (left - threshold[i] > now[i].output) now[i] = {left - threshold[i], kLeft, step.knot};
    }
    if (step.compare) {
      double off = -y[step.sample];
      GpiVector slope = GpiVector::Zero();
      for (std::size_t i = 0; i < now.size(); ++i) {
        const double weight = density[i];
        const std::size_t k = now[i].knot;
        off += weight * now[i].output;
        slope[kS] -= static_cast<double>(i) * weight * now[i].output;
        if (now[i].side == kLeft) {
          slope[kLnA] += weight * table.left_by_ln_a[k];
          slope[kL0] += weight;
          slope[kLnDl] += weight * table.left_by_ln_dl[k];
          slope[kLnAlpha] -= weight * threshold[i];
        } else if (now[i].side == kRight) {
          slope[kLnB] += weight * table.right_by_ln_b[k];
          slope[kR0] += weight;
          slope[kLnDr] += weight * table.right_by_ln_dr[k];
          slope[kLnAlpha] += weight * threshold[i];
        }
      }
      into.j += off * off;
      into.gradient += off * slope;
      into.hessian.noalias() += slope * slope.transpose();
    }
    if (step.move) operators = now;
  }
}

GpiSearch::Found GpiSearch::search(const GpiVector& start, std::span<const double> y, int steps) const {
  Table table;
  Normal here, there;
  Found best{within(start), 0.0};
  evaluate(best.unknowns, y, table, here);
  double damping = 1e-2, faster = 2.0;
  for (int step = 0; step < steps && damping < kLargestDamping; ++step) {
    auto damped = here.hessian;
    for (int k = 0; k < kGpiUnknowns; ++k) damped(k, k) += damping * (here.hessian(k, k) + 1e-9);
    const GpiVector to = within(best.unknowns - damped.ldlt().solve(here.gradient));
    evaluate(to, y, table, there);
    if (!(there.j < here.j)) {
      damping *= faster;
      faster *= 2.0;
      continue;
    }
    const GpiVector moved = to - best.unknowns;
    const double promised = -moved.dot(2.0 * here.gradient + here.hessian * moved);
    const double kept = promised > 0.0 ? (here.j - there.j) / promised : 0.0;
    damping *= std::clamp(1.0 - std::pow(2.0 * kept - 1.0, 3.0), 1.0 / 3.0, 2.0);  // after Nielsen
    faster = 2.0;
    const bool converged = here.j - there.j <= kConverged * here.j;
    best.unknowns = to;
    std::swap(here, there);
    if (converged) break;
  }
  best.j = here.j;
  return best;
}

}  // namespace tactbench::analysis
