#include "bench/guard/witness.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/pressure_unit.h"

namespace tactbench::bench {

using devices::Psi;

namespace {

constexpr double kFollowsPsi = 5.0;
constexpr double kZeroShare = 0.01;    // of the span: a zero error that sound instruments have
constexpr double kUnstatedU = 0.0025;  // of the span, if no uncertainty is stated

// `expanded_u`: 0: not stated.
TrueRange range_of(const SafetyLimits& limits, double low, double high, double expanded_u) {
  const double span = high - low;
  const double off = std::max(limits.safe_psi, (expanded_u > 0.0 ? expanded_u : kUnstatedU * span) + kZeroShare * span);
  return {std::max(low, 0.0) - off, high + off};
}

}  // namespace

TrueRange feedback_range(const BenchConfig& config) {
  const devices::LinearSpan& span = config.regulator.feedback_span;
  return range_of(config.limits, span.low.value(), span.high.value(), 0.0);
}

TrueRange reference_range(const BenchConfig& config) {
  if (!config.reference_independent) return feedback_range(config);
  const double expanded_u = config.reference_correction.empty()
                                ? config.reference_stated.expanded_uncertainty
                                : config.reference_correction.expanded_uncertainty(Psi(0.0));
  const devices::LinearSpan& span = config.reference.span;
  if (!config.reference_gauge) return range_of(config.limits, span.low.value(), span.high.value(), expanded_u);
  // A gauge has no span; its range is assumed to reach at least to the trip.
  return {range_of(config.limits, 0.0, config.limits.trip_psi, expanded_u).low_psi};
}

void PressureWitness::see(double psi, devices::Nanoseconds time) {
  if (psi != psi_ || time_.count() < 0) {  // NaN always differs
    changed_ = true;
    is_frozen_ = false;
  }
  psi_ = psi;
  time_ = time;
  ever_possible_ = ever_possible_ || possible();
  if (possible()) {
    impossible_since_.reset();
  } else if (!impossible_since_) {
    impossible_since_ = time;
  }
}

void PressureWitness::see_other(const PressureWitness& other) {
  if (!other.possible()) return;
  if (changed_) other_psi_ = other.psi_;
  changed_ = false;
  is_frozen_ = is_frozen_ || std::abs(other.psi_ - other_psi_) > kFollowsPsi;
}

double PressureWitness::impossible_s() const {
  return impossible_since_ ? devices::in_seconds(time_ - *impossible_since_) : 0.0;
}

std::string PressureWitness::doubt() const {
  if (!possible()) {
    return std::isfinite(range_.high_psi)
               ? "cannot be true: a sound one reads " + analysis::both_units_span(range_.low_psi, range_.high_psi)
               : fmt::format("cannot be true: a sound one reads {} or more", analysis::both_units(range_.low_psi, 1));
  }
  return is_frozen_ ? "is frozen: the other moved by more than " + analysis::both_units(kFollowsPsi) : "";
}

}  // namespace tactbench::bench
