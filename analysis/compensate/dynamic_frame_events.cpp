#include <algorithm>
#include <cmath>
#include <limits>

#include "analysis/compensate/dynamic_frame_state.h"

namespace tactbench::analysis {

namespace {

constexpr double kUniform = 0.28867513459481288;  // 1 / sqrt(12): standard uncertainty of a value anywhere within 1

}  // namespace

// The linearised output over the output.
template <class Real>
Real DynamicFrameCompensator<Real>::State::per_left(std::size_t taxel, Real output) const {
  const Real c = blocks[taxel / kLanes].divider[taxel % kLanes];
  return Real(1) / (Real(1) - std::min(output * c, Real(Divider::kMost)));
}

template <class Real>
Real DynamicFrameCompensator<Real>::State::linear(std::size_t taxel, Real output) const {
  return output * per_left(taxel, output);
}

template <class Real>
typename DynamicFrameCompensator<Real>::State::Reading DynamicFrameCompensator<Real>::State::reading(
    std::size_t taxel, const BranchPiece<Real>& piece, Real output) const {
  const Real per = per_left(taxel, output);
  return {per_interval * piece.along(output * per), per_interval * piece.slope * per * per};
}

template <class Real>
typename DynamicFrameCompensator<Real>::State::Reading DynamicFrameCompensator<Real>::State::read(
    std::size_t taxel, const Staircase<Real>& memory, Real output) const {
  return reading(taxel, memory.piece(everett(taxel), linear(taxel, output)), output);
}

template <class Real>
void DynamicFrameCompensator<Real>::State::take_extreme(std::size_t taxel) {
  DynamicBlock<Real>& b = block(taxel);
  const std::size_t i = taxel % kLanes;
  b.extreme[i] = b.mean[i];
  b.extreme_weight[i] = b.weight[i];
  const Real weight = b.weight[i];
  b.turn[i] = b.mean[i];
  if (weight < Real(1)) b.turn[i] -= b.rising[i] * shared.lead * std::sqrt(weight) * (Real(1) - weight);
}

// Puts the piece that holds the mean into the lane's rows, and reads it.
template <class Real>
typename DynamicFrameCompensator<Real>::State::Reading DynamicFrameCompensator<Real>::State::locate(std::size_t taxel) {
  DynamicBlock<Real>& b = block(taxel);
  const std::size_t i = taxel % kLanes;
  Taxel& t = taxels[taxel];
  const Real per = per_left(taxel, b.mean[i]), u = b.mean[i] * per;
  if (b.mean[i] == b.extreme[i]) t.memory.go(u);
  const BranchPiece<Real> piece = t.memory.piece(everett(taxel), u);
  b.low[i] = piece.u_low;
  b.high[i] = piece.u_high;
  b.u[i] = piece.u_a;
  b.x[i] = per_interval * piece.x_a;
  b.slope[i] = per_interval * piece.slope;
  b.reverse[i] = std::numeric_limits<Real>::quiet_NaN();
  const Real x = piece.along(u);
  const Reading here{per_interval * x, b.slope[i] * per * per};
  if (residuals.empty()) return here;
  const std::size_t at = interval_of(x, intervals);
  const Real residual = b.residual_scale[i] * residuals[b.rising[i] > Real(0) ? at : intervals + at];
  const Real changed = b.doubted[i] * (static_cast<Real>(at) + Real(0.5));
  b.residual[i] = changed > Real(0) ? std::sqrt(residual * residual + changed * changed) : residual;
  return here;
}

template <class Real>
typename DynamicFrameCompensator<Real>::State::Reading DynamicFrameCompensator<Real>::State::located(
    std::size_t taxel) const {
  const DynamicBlock<Real>& b = blocks[taxel / kLanes];
  const std::size_t i = taxel % kLanes;
  const Real per = per_left(taxel, b.mean[i]);
  return {b.x[i] + b.slope[i] * (b.mean[i] * per - b.u[i]), b.slope[i] * per * per};
}

template <class Real>
Real DynamicFrameCompensator<Real>::State::reverse_sensitivity(std::size_t taxel, const Staircase<Real>& memory) const {
  const DynamicBlock<Real>& b = blocks[taxel / kLanes];
  const std::size_t i = taxel % kLanes;
  const auto off = static_cast<Real>(options.flat_in_noises);
  if (off <= Real(0)) return Real(0);
  Staircase<Real> tentative = memory;
  tentative.turn(everett(taxel), linear(taxel, b.turn[i]));
  const Real there = read(taxel, tentative, b.turn[i] - b.rising[i] * off).x;
  return std::abs(read(taxel, tentative, b.turn[i]).x - there) / off;
}

template <class Real>
void DynamicFrameCompensator<Real>::State::show(std::size_t taxel, const Reading& reading, Real sensitivity,
                                                Real doubt) {
  DynamicBlock<Real>& b = block(taxel);
  const std::size_t i = taxel % kLanes;
  b.last_x[i] = reading.x;
  b.last_slope[i] = std::min(reading.slope, b.steepest[i]);
  b.last_mean[i] = b.mean[i];
  Real uncertainty = b.weight[i] < Real(1) ? std::sqrt(b.weight[i]) * sensitivity : sensitivity;
  if (doubt > Real(0)) uncertainty = std::sqrt(uncertainty * uncertainty + doubt * doubt);
  b.uncertainty[i] = std::min(uncertainty, shared.span);
}

// As DynamicTaxelCompensator::observe_top: at a turn from rising to falling.
template <class Real>
void DynamicFrameCompensator<Real>::State::observe_top(std::size_t taxel) {
  DynamicBlock<Real>& b = block(taxel);
  const std::size_t i = taxel % kLanes;
  Taxel& t = taxels[taxel];
  const auto share = static_cast<Real>(observer.share);
  if (b.turn[i] < t.top_from) return;
  const Real measured = b.turn[i] / t.gain;
  t.highest = std::max(measured, t.highest - static_cast<Real>(observer.forget) * (t.highest - measured));
  const Real gain = std::clamp(t.top / t.highest, Real(1) / (Real(1) + Real(5) * share), Real(1) / (Real(1) - share));
  const Real change = gain / t.gain;
  t.gain = gain;
  t.top_from = (Real(1) - share) * t.top * gain;
  b.gain[i] = t.plain_gain * gain;
  b.doubted[i] = static_cast<Real>(observer.doubt) * std::abs(Real(1) - gain) * per_interval;
  for (Real* const row : {b.mean, b.extreme, b.turn, b.last_mean}) row[i] *= change;
}

template <class Real>
void DynamicFrameCompensator<Real>::State::attend_turned(std::size_t taxel) {
  DynamicBlock<Real>& b = block(taxel);
  const std::size_t i = taxel % kLanes;
  Taxel& t = taxels[taxel];
  const bool rose = b.rising[i] > Real(0);
  if (rose) observe_top(taxel);
  const Real at = linear(taxel, b.turn[i]);
  if (t.unknown) {
    t.memory.turn(everett(taxel), at);
    t.other.turn(everett(taxel), at);
  } else if (b.low[i] <= at && at <= b.high[i]) {
    t.memory.turn_at((b.x[i] + b.slope[i] * (at - b.u[i])) * intervals_per, at);
  } else {
    t.memory.turn(everett(taxel), at);
  }
  face(taxel, !rose);
  take_extreme(taxel);
  t.back_known = false;
}

template <class Real>
void DynamicFrameCompensator<Real>::State::attend_unknown(std::size_t taxel, bool turned, bool back, bool is_held) {
  DynamicBlock<Real>& b = block(taxel);
  const std::size_t i = taxel % kLanes;
  Taxel& t = taxels[taxel];
  if (!t.decided) {
    back = is_held = false;
    const auto band = static_cast<Real>(options.band_in_noises);
    const Real off = t.started ? b.mean[i] - t.first : Real(0), weight = b.weight[i];
    if (off * off > band * band * std::max(weight, t.first_weight)) {
      const bool rises = off > Real(0);
      (rises ? t.other : t.memory).turn(everett(taxel), linear(taxel, t.first));
      t.decided = true;
      face(taxel, rises);
      take_extreme(taxel);
    } else if (!t.started || weight < t.first_weight) {
      t.started = true;
      t.first = b.mean[i];
      t.first_weight = weight;
    }
  } else if (turned) {
    attend_turned(taxel);
    back = is_held = false;
  }
  const Real u = linear(taxel, b.mean[i]);
  if (t.decided && b.mean[i] == b.extreme[i]) {
    t.memory.go(u);
    t.other.go(u);
  }
  const auto read_one = [&](const Staircase<Real>& memory, Real& sensitivity, Real& doubt) {
    Reading here = read(taxel, memory, b.mean[i]);
    sensitivity = here.slope;
    doubt = Real(0);
    if (back || is_held) sensitivity = std::max(sensitivity, reverse_sensitivity(taxel, memory));
    if (back) {
      Staircase<Real> tentative = memory;
      tentative.turn(everett(taxel), linear(taxel, b.turn[i]));
      const Reading there = read(taxel, tentative, b.mean[i]);
      doubt = static_cast<Real>(kUniform) * std::abs(there.x - here.x);
      here = there;
    }
    return here;
  };
  Real sensitivity, doubt, low_sensitivity, low_doubt;
  Reading here = read_one(t.memory, sensitivity, doubt);
  const Reading there = read_one(t.other, low_sensitivity, low_doubt);
  const Real apart = std::abs(here.x - there.x);
  if (apart <= static_cast<Real>(options.known_psi)) {
    set_unknown(t, false);
    if (!t.decided) take_extreme(taxel);
    t.decided = true;
    (void)locate(taxel);
    show(taxel, here, sensitivity, doubt);
    return;
  }
  here.x = Real(0.5) * (here.x + there.x);
  const Real both = std::max(doubt, low_doubt);
  show(taxel, here, std::max(sensitivity, low_sensitivity), std::sqrt(both * both + Real(0.25) * apart * apart));
}

// A taxel that did not turn, once its piece is known.
template <class Real>
void DynamicFrameCompensator<Real>::State::rest(std::size_t taxel, bool is_held, bool back) {
  DynamicBlock<Real>& b = block(taxel);
  const std::size_t i = taxel % kLanes;
  Taxel& t = taxels[taxel];
  if (is_held && std::isnan(b.reverse[i])) b.reverse[i] = reverse_sensitivity(taxel, t.memory);
  Reading here = located(taxel);
  Real sensitivity = here.slope, doubt = Real(0);
  if (is_held) sensitivity = std::max(sensitivity, b.reverse[i]);
  if (back) {
    const Real u = linear(taxel, b.mean[i]);
    if (!t.back_known || t.back_turn != b.turn[i] || !t.back.holds(u)) {
      Staircase<Real> tentative = t.memory;
      tentative.turn(everett(taxel), linear(taxel, b.turn[i]));
      t.back = tentative.piece(everett(taxel), u);
      t.back_turn = b.turn[i];
      t.back_known = true;
    }
    const Reading there = reading(taxel, t.back, b.mean[i]);
    doubt = static_cast<Real>(kUniform) * std::abs(there.x - here.x);
    here = there;
  }
  show(taxel, here, sensitivity, doubt);
}

template struct DynamicFrameCompensator<float>::State;
template struct DynamicFrameCompensator<double>::State;

}  // namespace tactbench::analysis
