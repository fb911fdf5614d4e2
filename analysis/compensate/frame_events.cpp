#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "analysis/compensate/frame_state.h"

namespace tactbench::analysis {

namespace {

constexpr double kUniform = 0.28867513459481288;  // 1 / sqrt(12): standard uncertainty of a value anywhere within 1

// The smallest number above.
template <class Real>
Real next_above(Real value) {
  using Bits = std::conditional_t<sizeof(Real) == 4, std::int32_t, std::int64_t>;
  if (value == Real(0)) return std::numeric_limits<Real>::denorm_min();
  const auto bits = std::bit_cast<Bits>(value);
  return std::bit_cast<Real>(value > Real(0) ? bits + 1 : bits - 1);
}

// NaN when one of them is.
template <class Real>
Real larger(Real a, Real b) {
  return a > b || std::isnan(a) ? a : b;
}

}  // namespace

template <class Real>
Real FrameCompensator<Real>::State::residual2_at(const Place& at, double pressure) const {
  const auto own = std::span<const Real>(residuals2).subspan(at.taxel * residual_size, residual_size);
  return BinsOf<Real>{lowest_psi, lowest_psi + span_psi, own}.at(pressure, at.t.rises);
}

template <class Real>
typename FrameCompensator<Real>::State::LanePiece FrameCompensator<Real>::State::lane_piece(
    const Place& at, const CurvePiece& piece) const {
  const auto from = static_cast<Real>(piece.from), to = static_cast<Real>(piece.to), above = next_above(from);
  const auto x = static_cast<Real>(piece.at), slope = static_cast<Real>(piece.slope);
  const Real residual2 = residual2_at(at, piece.along(0.5 * (piece.from + piece.to)));
  if (at.t.rises) return {above, to, from, x, slope, residual2, piece};
  return {-to, -above, -from, x, -slope, residual2, piece};
}

// A piece's sensitivities are the larger ones of its two ends: points between are observed at least as well.
template <class Real>
void FrameCompensator<Real>::State::look_up(const Place& at) {
  LanePiece& here = at.t.pieces[at.t.here];
  const Sensitivity* const low = sensitivities_of(at.taxel) + here.piece.index;
  const Sensitivity* const high = here.piece.index < knots ? low + 1 : low;
  here.own = larger(low->own, high->own);
  here.worst = larger(here.own, larger(low->reverse, high->reverse));
}

template <class Real>
void FrameCompensator<Real>::State::show(const Place& at) {
  const LanePiece& here = at.t.pieces[at.t.here];
  LaneBlock<Real>& b = at.b;
  const std::size_t i = at.i;
  b.low[i] = here.low;
  b.high[i] = here.high;
  b.origin[i] = here.origin;
  b.at[i] = here.at;
  b.slope[i] = here.slope;
  b.own[i] = here.own;
  b.worst[i] = here.worst;
  b.residual2[i] = here.residual2;
}

// The piece before the last is dropped.
template <class Real>
void FrameCompensator<Real>::State::locate(const Place& at) {
  const std::size_t near = at.t.pieces[at.t.here ^ 1].piece.near;
  at.t.pieces[at.t.here] = lane_piece(at, piece_at(at.pattern, at.t.curve, at.mean(), near));
  look_up(at);
}

// As TaxelCompensator::read, without tables. `back`: the output is behind the extreme; then or when held, it may have
// turned.
template <class Real>
typename FrameCompensator<Real>::State::Reading FrameCompensator<Real>::State::read(const Place& at,
                                                                                    const ComposedCurve& curve,
                                                                                    bool back, bool held) const {
  const double mean = at.mean();
  Reading result;
  result.pressure = input_at(at.pattern, curve, mean);
  double slope = sensitivity(at.pattern, curve, mean, result.pressure, curve.turn_near), doubt = 0.0;
  if (back || held) {
    const ComposedCurve tentative = reversed(at.pattern, curve, at.turn());
    const double there = input_at(at.pattern, tentative, mean);
    slope = std::max(slope, sensitivity(at.pattern, tentative, mean, there, tentative.turn_near));
    if (back) {
      doubt = std::abs(there - result.pressure) * kUniform;
      result.pressure = there;
    }
  }
  const double noise = static_cast<double>(std::sqrt(at.b.weight[at.i])) * slope;
  result.uncertainty = std::sqrt(noise * noise + doubt * doubt);
  result.flat = options.flat_in_noises * noise > options.flat_psi;
  return result;
}

template <class Real>
void FrameCompensator<Real>::State::fill_knot(const Place& at, std::size_t knot, double y, bool held) {
  Sensitivity& known = sensitivities_of(at.taxel)[knot];
  const bool own = std::isnan(known.own), reverse = held && std::isnan(known.reverse);
  const CurvePiece& piece = at.t.pieces[at.t.here].piece;
  const double x = piece.along(y);
  if (own) known.own = static_cast<Real>(sensitivity(at.pattern, at.t.curve, y, x, piece.near));
  if (reverse) known.reverse = static_cast<Real>(reverse_sensitivity(at.pattern, at.t.curve, y, x, at.t.way_back));
}

template <class Real>
void FrameCompensator<Real>::State::fill_piece(const Place& at, bool held) {
  const CurvePiece& piece = at.t.pieces[at.t.here].piece;
  fill_knot(at, piece.index, piece.index == index_below(at.pattern) ? piece.to : piece.from, held);
  if (piece.index < knots) fill_knot(at, piece.index + 1, piece.to, held);
  look_up(at);
  show(at);
}

// The curve back from the extreme, and its piece behind it.
template <class Real>
void FrameCompensator<Real>::State::find_way_back(const Place& at) {
  Taxel& t = at.t;
  const Real turn_in_lane = at.b.turn[at.i];
  if (t.back_turn != turn_in_lane) {
    t.back_turn = turn_in_lane;
    const double turn = at.turn();
    const CurvePiece &here = t.pieces[t.here].piece, &before = t.pieces[t.here ^ 1].piece;
    const double x = here.holds(turn)     ? here.along(turn)
                     : before.holds(turn) ? before.along(turn)
                                          : input_at(at.pattern, t.curve, turn, here.near);
    t.way_back = reversed(at.pattern, t.curve, turn, x, t.way_back);
  }
  t.back = lane_piece(at, piece_at(at.pattern, t.way_back, at.mean(), t.way_back.turn_near));
}

template <class Real>
typename FrameCompensator<Real>::State::Reading FrameCompensator<Real>::State::attend_turned(const Place& at) {
  set_curve(at, reversed(at.pattern, at.t.curve, at.turn()));
  take_extreme(at);
  return read(at, at.t.curve, false, false);
}

// TaxelCompensator::decide_when_beyond.
template <class Real>
void FrameCompensator<Real>::State::decide(const Place& at) {
  LaneBlock<Real>& b = at.b;
  const std::size_t i = at.i;
  History& history = histories[at.taxel];
  const Real off = history.started ? b.mean[i] - history.extreme : Real(0);
  const Real band = static_cast<Real>(options.band_in_noises), weight = b.weight[i];
  if (off * off > band * band * std::max(weight, history.weight)) {
    const bool rises = off > Real(0);
    ComposedCurve& turned = rises ? history.other : at.t.curve;
    turned = reversed(at.pattern, turned, static_cast<double>(history.extreme));
    history.decided = true;
    face(at, rises);
    take_extreme(at);
  } else if (!history.started || weight < history.weight) {
    history.started = true;
    history.extreme = b.mean[i];
    history.weight = weight;
  }
}

template <class Real>
typename FrameCompensator<Real>::State::Reading FrameCompensator<Real>::State::attend_unknown(const Place& at,
                                                                                              bool turned, bool back,
                                                                                              bool held) {
  History& history = histories[at.taxel];
  back = history.decided && back;
  held = history.decided && held;
  if (!history.decided) {
    decide(at);
  } else if (turned) {
    const double turn = at.turn();
    at.t.curve = reversed(at.pattern, at.t.curve, turn);
    history.other = reversed(at.pattern, history.other, turn);
    face(at, !at.t.rises);
    take_extreme(at);
    back = held = false;
  }
  Reading result = read(at, at.t.curve, back, held);
  const Reading low = read(at, history.other, back, held);
  const double apart = std::abs(result.pressure - low.pressure);
  if (apart <= options.known_psi) {
    at.t.unknown = false;
    if (!history.decided) take_extreme(at);
    set_curve(at, ComposedCurve(at.t.curve));
    return result;
  }
  result.pressure = 0.5 * (result.pressure + low.pressure);
  const double noise = std::max(result.uncertainty, low.uncertainty);
  result.uncertainty = std::sqrt(noise * noise + 0.25 * apart * apart);
  result.flat = result.flat || low.flat;
  return result;
}

// The new piece, in the rows as well.
template <class Real>
void FrameCompensator<Real>::State::change_piece(const Place& at) {
  at.t.here ^= 1;
  if (!at.t.pieces[at.t.here].holds(at.b.mean[at.i])) locate(at);
  show(at);
}

// The rare events.
template <class Real>
void FrameCompensator<Real>::State::attend_rare(const Place& at, bool turned, bool back, bool held,
                                                const FrameResults<Real>& results) {
  const Reading reading = at.t.unknown ? attend_unknown(at, turned, back, held) : attend_turned(at);
  const auto uncertainty = static_cast<Real>(reading.uncertainty);
  results.pressure[at.taxel] = at.b.pressure[at.i] = static_cast<Real>(reading.pressure);
  results.uncertainty[at.taxel] = at.b.uncertainty[at.i] =
      std::sqrt(uncertainty * uncertainty + residual2_at(at, reading.pressure));
  const int range = results.status[at.taxel] & ~kTaxelFlat;
  results.status[at.taxel] =
      static_cast<std::uint16_t>(range | (reading.flat ? kTaxelFlat : 0) | (at.t.unknown ? kTaxelUnknown : 0));
}

template <class Real>
void FrameCompensator<Real>::State::attend(const FrameResults<Real>& results) {
  // Copies, since the compiler cannot know that results do not alias them.
  const FrameResults<Real> to = results;
  const Real band2 = lanes.limits.band2, hold2 = lanes.limits.hold2, flat = lanes.limits.flat;
  const std::uint16_t *const events = lanes.bits.events.data(), *const helds = lanes.bits.held.data();
  LaneBlock<Real>* const blocks = lanes.blocks.data();
  Taxel* const all_taxels = taxels.data();
  const TaxelPattern* const all_patterns = patterns.data();
  const bool far = count > 1024;
  for (std::size_t k = 0, end = lanes.bits.events.size(); k < end; k += 4) {
    std::uint64_t word = 0;
    for (std::size_t j = 0; j < 4; ++j) word |= std::uint64_t{events[k + j]} << (kLanes * j);
    // A large array's data for events is far away in memory; all of it is prefetched at once.
    if (far)
      for (std::uint64_t left = word; left != 0; left &= left - 1) {
        const std::size_t taxel = k * kLanes + static_cast<std::size_t>(std::countr_zero(left));
        const auto* const bytes = reinterpret_cast<const char*>(all_taxels + taxel);
        for (std::size_t line = 0; line < sizeof(Taxel); line += 64) __builtin_prefetch(bytes + line);
        __builtin_prefetch(all_patterns + taxel);
        __builtin_prefetch(reinterpret_cast<const char*>(all_patterns + taxel) + 64);
        __builtin_prefetch(reinterpret_cast<const char*>(all_patterns + taxel) + 128);
      }
    for (; word != 0; word &= word - 1) {
      const std::size_t taxel = k * kLanes + static_cast<std::size_t>(std::countr_zero(word)), i = taxel % kLanes;
      const Place at{taxel, i, blocks[taxel / kLanes], all_taxels[taxel], all_patterns[taxel]};
      LaneBlock<Real>& b = at.b;
      const Taxel& t = at.t;
      const Real mean = b.mean[i], turn = b.turn[i], weight = b.weight[i], other = b.extreme_weight[i];
      const Real behind = turn > mean ? turn - mean : Real(0), wider = weight > other ? weight : other;
      const bool turned = behind * behind > band2 * wider, back = behind * behind > hold2 * wider;
      const bool held = (helds[taxel / kLanes] >> i & 1) != 0;
      if (turned || t.unknown) [[unlikely]] {
        attend_rare(at, turned, back, held, to);
        continue;
      }
      if (!t.pieces[t.here].holds(mean)) change_piece(at);
      const LanePiece& here = t.pieces[t.here];
      if (std::isnan(held ? here.worst : here.own)) fill_piece(at, held);
      Real pressure = here.along(mean), residual2 = here.residual2;
      const Real noise = std::sqrt(weight) * (held ? here.worst : here.own);
      const int flat_bit = noise > flat ? kTaxelFlat : 0;
      Real noise2 = noise * noise;
      if (back) {
        if (t.back_turn != turn || !t.back.holds(mean)) find_way_back(at);
        const Real there = t.back.along(mean), doubt = (there - pressure) * Real(kUniform);
        pressure = there;
        noise2 += doubt * doubt;
        residual2 = t.back.residual2;
      }
      to.pressure[taxel] = b.pressure[i] = pressure;
      to.uncertainty[taxel] = b.uncertainty[i] = std::sqrt(noise2 + residual2);
      to.status[taxel] = static_cast<std::uint16_t>((to.status[taxel] & ~kTaxelFlat) | flat_bit);
    }
  }
}

template struct FrameCompensator<float>::State;
template struct FrameCompensator<double>::State;

}  // namespace tactbench::analysis
