#include <algorithm>
#include <cmath>

#include "analysis/compensate/frame_state.h"

namespace tactbench::analysis {

namespace {

constexpr double kUniform = 0.28867513459481288;  // 1 / sqrt(12): standard uncertainty of what lies anywhere within 1

}  // namespace

template <class Real>
void FrameLanes<Real>::locate(std::size_t taxel) {
  LaneBlock<Real>& b = block(taxel);
  const std::size_t i = taxel % kLanes;
  const LanePiece<Real> now{b.from[i],    b.to[i], b.at[i], b.slope[i], b.sensitivity[i], b.reverse_sensitivity[i],
                            pieces[taxel]};
  const LanePiece<Real> then = former[taxel];
  former[taxel] = now;
  if (b.mean[i] > then.from && b.mean[i] <= then.to) {
    b.from[i] = then.from;
    b.to[i] = then.to;
    b.at[i] = then.at;
    b.slope[i] = then.slope;
    b.sensitivity[i] = then.sensitivity;
    b.reverse_sensitivity[i] = then.reverse_sensitivity;
    pieces[taxel] = then.index;
    return;
  }
  const CurvePiece piece = piece_at(patterns[taxel], curves[taxel], static_cast<double>(b.mean[i]));
  b.from[i] = static_cast<Real>(piece.from);
  b.to[i] = static_cast<Real>(piece.to);
  b.at[i] = static_cast<Real>(piece.at);
  b.slope[i] = static_cast<Real>(piece.slope);
  pieces[taxel] = static_cast<std::uint32_t>(piece.index);
  look_up(taxel);
}

// A piece's sensitivities are the larger ones of its two ends: what lies between is not observed better than that.
template <class Real>
void FrameLanes<Real>::look_up(std::size_t taxel) {
  LaneBlock<Real>& b = block(taxel);
  const std::size_t i = taxel % kLanes, piece = pieces[taxel];
  const KnotSensitivity<Real>* const low = sensitivities_of(taxel) + piece;
  const KnotSensitivity<Real>* const high = piece < knots ? low + 1 : low;
  b.sensitivity[i] = std::isnan(low->own) ? low->own : low->own > high->own ? low->own : high->own;
  b.reverse_sensitivity[i] = std::isnan(low->reverse)       ? low->reverse
                             : low->reverse > high->reverse ? low->reverse
                                                            : high->reverse;
}

// As TaxelCompensator::read, without tables. `back`: the output is behind the extreme; then or when held, it may have
// turned.
template <class Real>
typename FrameCompensator<Real>::State::Reading FrameCompensator<Real>::State::read(std::size_t taxel,
                                                                                    const ComposedCurve& curve,
                                                                                    bool back, bool held) const {
  const LaneBlock<Real>& b = lanes.block(taxel);
  const std::size_t i = taxel % kLanes;
  const TaxelPattern& pattern = lanes.patterns[taxel];
  const double mean = static_cast<double>(b.mean[i]);
  Reading result;
  result.pressure = input_at(pattern, curve, mean);
  double slope = sensitivity(pattern, curve, mean, result.pressure), doubt = 0.0;
  if (back || held) {
    const ComposedCurve tentative = reversed(pattern, curve, static_cast<double>(b.turn[i]));
    const double there = input_at(pattern, tentative, mean);
    slope = std::max(slope, sensitivity(pattern, tentative, mean, there));
    if (back) {
      doubt = std::abs(there - result.pressure) * kUniform;
      result.pressure = there;
    }
  }
  const double noise = static_cast<double>(b.root_weight[i]) * slope;
  result.uncertainty = std::sqrt(noise * noise + doubt * doubt);
  result.flat = lanes.options.flat_in_noises * noise > lanes.options.flat_psi;
  return result;
}

template <class Real>
void FrameCompensator<Real>::State::put(std::size_t taxel, const Reading& reading, std::uint16_t more_bits) {
  LaneBlock<Real>& b = lanes.block(taxel);
  const std::size_t i = taxel % kLanes;
  b.pressure[i] = static_cast<Real>(reading.pressure);
  b.uncertainty[i] = static_cast<Real>(reading.uncertainty);
  b.bits[i] = (b.bits[i] & ~Whole<Real>{kTaxelFlat}) | (reading.flat ? kTaxelFlat : 0) | more_bits;
}

template <class Real>
void FrameCompensator<Real>::State::fill_knot(std::size_t taxel, std::size_t knot, double y, bool held) {
  KnotSensitivity<Real>& known = lanes.sensitivities_of(taxel)[knot];
  const bool own = std::isnan(known.own), reverse = held && std::isnan(known.reverse);
  if (!own && !reverse) return;
  const TaxelPattern& pattern = lanes.patterns[taxel];
  const ComposedCurve& curve = lanes.curves[taxel];
  const double x = input_at(pattern, curve, y);
  if (own) known.own = static_cast<Real>(sensitivity(pattern, curve, y, x));
  if (reverse) known.reverse = static_cast<Real>(reverse_sensitivity(pattern, curve, y, x));
}

template <class Real>
void FrameCompensator<Real>::State::fill_piece(std::size_t taxel, bool held) {
  LaneBlock<Real>& b = lanes.block(taxel);
  const std::size_t i = taxel % kLanes, piece = lanes.pieces[taxel];
  const auto from = static_cast<double>(b.from[i]), to = static_cast<double>(b.to[i]);
  fill_knot(taxel, piece, piece == index_below(lanes.patterns[taxel]) ? to : from, held);
  if (piece < lanes.knots) fill_knot(taxel, piece + 1, to, held);
  lanes.look_up(taxel);
}

template <class Real>
void FrameCompensator<Real>::State::find_way_back(std::size_t taxel) {
  LaneBlock<Real>& b = lanes.block(taxel);
  const std::size_t i = taxel % kLanes;
  const TaxelPattern& pattern = lanes.patterns[taxel];
  if (b.back_turn[i] != b.turn[i]) {
    b.back_turn[i] = b.turn[i];
    ways_back[taxel] = reversed(pattern, lanes.curves[taxel], static_cast<double>(b.turn[i]));
  }
  const CurvePiece piece = piece_at(pattern, ways_back[taxel], static_cast<double>(b.mean[i]));
  b.back_from[i] = static_cast<Real>(piece.from);
  b.back_to[i] = static_cast<Real>(piece.to);
  b.back_at[i] = static_cast<Real>(piece.at);
  b.back_slope[i] = static_cast<Real>(piece.slope);
}

template <class Real>
void FrameCompensator<Real>::State::attend_known(std::size_t taxel, std::uint32_t what) {
  LaneBlock<Real>& b = lanes.block(taxel);
  const std::size_t i = taxel % kLanes;
  if ((what & kLaneTurned) != 0) {
    set_curve(taxel, reversed(lanes.patterns[taxel], lanes.curves[taxel], static_cast<double>(b.turn[i])));
    b.sign[i] = -b.sign[i];
    take_extreme(taxel);
    put(taxel, read(taxel, lanes.curves[taxel], false, false), 0);
    return;
  }
  const bool held = (what & kLaneHeld) != 0;
  if ((what & kLaneUnfilled) != 0) fill_piece(taxel, held);
  const Real worst = held && b.reverse_sensitivity[i] > b.sensitivity[i] ? b.reverse_sensitivity[i] : b.sensitivity[i];
  const auto noise = static_cast<double>(b.root_weight[i] * worst);
  const double here = static_cast<double>(b.at[i] + b.slope[i] * (b.mean[i] - b.from[i]));
  Reading result{here, noise, noise * lanes.options.flat_in_noises > lanes.options.flat_psi};
  if ((what & kLaneBack) != 0) {
    find_way_back(taxel);
    result.pressure = static_cast<double>(b.back_at[i] + b.back_slope[i] * (b.mean[i] - b.back_from[i]));
    const double doubt = (result.pressure - here) * kUniform;
    result.uncertainty = std::sqrt(noise * noise + doubt * doubt);
  }
  put(taxel, result, 0);
}

// TaxelCompensator::decide_when_beyond.
template <class Real>
void FrameCompensator<Real>::State::decide(std::size_t taxel) {
  LaneBlock<Real>& b = lanes.block(taxel);
  const std::size_t i = taxel % kLanes;
  History& history = histories[taxel];
  const Real off = history.started ? b.mean[i] - history.extreme : Real(0);
  const auto band = static_cast<Real>(lanes.options.band_in_noises);
  if (off * off > band * band * std::max(b.weight[i], history.weight)) {
    const bool rises = off > Real(0);
    ComposedCurve& turned = rises ? history.other : lanes.curves[taxel];
    turned = reversed(lanes.patterns[taxel], turned, static_cast<double>(history.extreme));
    history.decided = true;
    b.sign[i] = rises ? Real(1) : Real(-1);
    take_extreme(taxel);
  } else if (!history.started || b.weight[i] < history.weight) {
    history.started = true;
    history.extreme = b.mean[i];
    history.weight = b.weight[i];
  }
}

template <class Real>
void FrameCompensator<Real>::State::attend_unknown(std::size_t taxel, std::uint32_t what) {
  LaneBlock<Real>& b = lanes.block(taxel);
  const TaxelPattern& pattern = lanes.patterns[taxel];
  History& history = histories[taxel];
  bool back = history.decided && (what & kLaneBack) != 0, held = history.decided && (what & kLaneHeld) != 0;
  if (!history.decided) {
    decide(taxel);
  } else if ((what & kLaneTurned) != 0) {
    const auto turn = static_cast<double>(b.turn[taxel % kLanes]);
    lanes.curves[taxel] = reversed(pattern, lanes.curves[taxel], turn);
    history.other = reversed(pattern, history.other, turn);
    b.sign[taxel % kLanes] = -b.sign[taxel % kLanes];
    take_extreme(taxel);
    back = held = false;
  }
  Reading result = read(taxel, lanes.curves[taxel], back, held);
  const Reading low = read(taxel, history.other, back, held);
  const double apart = std::abs(result.pressure - low.pressure);
  if (apart <= lanes.options.known_psi) {
    history.unknown = false;
    if (!history.decided) {
      b.sign[taxel % kLanes] = Real(1);
      take_extreme(taxel);
    }
    set_curve(taxel, lanes.curves[taxel]);
    put(taxel, result, 0);
    return;
  }
  result.pressure = 0.5 * (result.pressure + low.pressure);
  const double noise = std::max(result.uncertainty, low.uncertainty);
  result.uncertainty = std::sqrt(noise * noise + 0.25 * apart * apart);
  result.flat = result.flat || low.flat;
  put(taxel, result, kTaxelUnknown);
}

template <class Real>
void FrameCompensator<Real>::State::attend() {
  for (std::size_t k = 0; k < lanes.event_count; ++k) {
    const auto [taxel, what] = lanes.events[k];
    if (taxel >= lanes.taxels || (!saved.empty() && lost[taxel])) continue;
    if (histories[taxel].unknown)
      attend_unknown(taxel, what);
    else
      attend_known(taxel, what);
  }
}

template struct FrameLanes<float>;
template struct FrameLanes<double>;
template struct FrameCompensator<float>::State;
template struct FrameCompensator<double>::State;

}  // namespace tactbench::analysis
