// Converts outputs to inputs for any curve. A curve holds a model's memory at the last stored turn. It measures outputs
// from the output at the lowest input, and has
//   top(), x_low(), x_high()    output at the highest input; ends of the inputs
//   place(y), stretch(y)        the output u in which its branches are linear; slope of the inputs over a piece's
//   output(u)                   the y that has it
//   input(x)                    of an x of its pieces
//   start(from_top)             at rest at the lowest input, or on the way down from the highest
//   piece(u)                    the linear piece of the present branch there, constant beyond its ends
//   go(u)                       the branch went on to there: loops that it closed are forgotten
//   back_from(u, piece)         the Way back that begins there, on that piece, and of which piece(way, u) is one
//   turn(way)                   the branch turned, and that way is the present one
//
// An output that moves by more than its noise between samples is used directly; otherwise it is averaged over up to 8
// samples. Behind the furthest mean since the last turn there are three zones, scaled by that mean's noise. In the
// first, "held", the present branch is read. In the second, the way back from the extreme is read, so that rise and
// fall are treated equally, but the turn is tentative. Beyond the dead band the turn is stored. So wiggles within the
// dead band leave no memory, and a slow fall is not averaged away, because the extreme is kept.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "analysis/compensate/compensator.h"
#include "analysis/models/pattern_curve.h"

namespace tactbench::analysis {

template <class Curve>
class TurningCompensator final : public Compensator {
 public:
  TurningCompensator(Curve curve, const CompensatorSetup& setup)
      : time_(setup.time),
        creep_scale_(setup.creep_scale),
        lag_share_(setup.lag_share),
        zero_(setup.zero),
        per_gain_(1.0 / setup.gain),
        x_low_(curve.x_low()),
        span_(curve.x_high() - curve.x_low()),
        top_(curve.top()),
        stated_noise_(setup.noise / std::abs(setup.gain)),
        top_doubt_(setup.options.top_doubt),
        moving_(setup.options.moving),
        least_weight_(1.0 / setup.options.longest_mean),
        residual_(setup.residual),
        low_(curve),
        high_(std::move(curve)),
        options_(setup.options),
        noise_(std::max(stated_noise_, kLeastNoise * top_)),
        worked_s_(setup.worked_s) {
    const double noise2 = noise_ * noise_;
    per_noise2_ = noise2 > 0.0 ? 1.0 / noise2 : kNoNoise;
    jump2_ = options_.jump_in_noises * options_.jump_in_noises * noise2;
    band2_ = options_.band_in_noises * options_.band_in_noises * noise2;
    const double hold = std::min(options_.hold_in_noises, options_.band_in_noises);
    hold2_ = hold * hold * noise2;
    rest2_ = options_.rest_in_noises * options_.rest_in_noises * noise2;
    off_ = options_.flat_in_noises * noise_;
    const double flat = options_.flat_share * span_ / options_.flat_in_noises;
    flat2_ = flat * flat;
    steepest_guess_ = kSteepestGuess * span_ / top_;
    band_ = options_.band_in_noises * noise_;
    margin_ = std::max(options_.possible_share * top_, band_);
    for (std::size_t j = 0; time_ && j < kCreepElements; ++j)
      creep_doubt_[j] = std::max(options_.creep_doubt * creep_scale_ * time_->dynamics.creep_share[j],
                                 j == 0 ? options_.swift_doubt : 0.0);
    start(Start::kAtRest);
  }

  Compensated step(double output, double seconds) override {
    const DynamicsStep* const passed = passed_in(seconds);
    const double above = (output - zero_) * per_gain_ * scale_;
    double factor = 1.0, y = above;
    if (passed != nullptr) {
      const double moved = last_slope_ * (above / last_factor_ - last_y_);
      const double guess = std::clamp(last_x_ + moved, 0.0, span_);
      factor = creep_factor(time_->dynamics, dynamics_, *passed, guess, creep_scale_);
      y = above / factor;
    }
    // Before creep is removed, which may be smaller than the model says.
    const bool beyond = above < -margin_ || above > top_ + margin_;
    if (beyond || std::isnan(above)) [[unlikely]] {
      if (!accepted_though_beyond(y)) return hold(passed, beyond);
    } else {
      y = std::clamp(y, -margin_, top_ + margin_);
      spikes_ = 0;
    }
    last_factor_ = factor;
    if (started_) [[likely]] {
      follow(y);
    } else {
      mean_ = extreme_ = turn_ = y;
      started_ = true;
    }
    const bool stands =
        weight_ == least_weight_ && mean_ >= reusable_from_ && mean_ <= reusable_to_ && zone_is_unchanged();
    const Reading now = stands ? read_again(low_, noise2_) : read_fully();
    last_x_ = now.x - x_low_;
    last_y_ = mean_;
    double pressure = last_x_, unsettled = 0.0;
    if (passed != nullptr) {
      last_slope_ = std::min(now.slope, steepest_guess_);
      pressure = std::clamp(before_lag(lag_share_, dynamics_, *passed, last_x_), 0.0, span_);
      advance(time_->dynamics, dynamics_, *passed, pressure);
      unsettled = std::min(unsettled_share(pressure) * std::abs(mean_ * now.slope), span_);
    }
    const double squared = now.squared + squared_residual(last_x_) + unsettled * unsettled;
    last_ = {x_low_ + pressure, std::sqrt(squared), noise2_ > flat2_, beyond, unknown_, false};
    return last_;
  }

  Compensated lost(double seconds) override {
    const DynamicsStep* const passed = passed_in(seconds);
    steps_ = kStepCeiling;
    return hold(passed, false);
  }

  void start(Start how) override {
    low_.start(false);
    unknown_ = how == Start::kUnknown;
    if (unknown_) high_.start(true);
    started_ = decided_ = !unknown_;
    reusable_from_ = kNowhere;
    ascending_ = held_ = true;
    back_ = false;
    steps_ = kStepCeiling;
    mean_ = extreme_ = turn_ = 0.0;
    weight_ = extreme_weight_ = 1.0;
    scale_ = 1.0;
    highest_ = 0.0;
    spikes_ = 0;
    dynamics_ = {};
    if (time_) work_unseen(time_->dynamics, dynamics_, worked_s_, span_);
    last_x_ = last_slope_ = last_y_ = 0.0;
    last_factor_ = extreme_factor_ = 1.0;  // without effect until a reading has a slope
    last_ = {x_low_, unknown_ ? span_ : std::sqrt(squared_residual(0.0)), false, false, unknown_, false};
  }

  void work(double seconds) override {
    if (passed_in(seconds) != nullptr) work_unseen(time_->dynamics, dynamics_, seconds, span_);
  }

  void rest(double seconds) override {
    const DynamicsStep* const passed = passed_in(seconds);
    DynamicsState gone_on = dynamics_;
    if (passed != nullptr) advance(time_->dynamics, gone_on, *passed, 0.0);
    start(Start::kAtRest);
    dynamics_ = gone_on;
  }

  bool tare(double output) override {
    const bool small = std::abs((output - zero_) * per_gain_) <= options_.tare_share * top_;
    if (small) zero_ = output;
    start(small ? Start::kAtRest : Start::kUnknown);
    return small;
  }

  [[nodiscard]] bool at_rest(double output) const override {
    return (output - zero_) * per_gain_ <= std::max(kAtRestShare * top_, band_);
  }
  [[nodiscard]] bool ascending() const override { return ascending_; }

 private:
  // The mean square of the steps is a running one over this many samples, each limited to a ceiling, so that a halt is
  // detected soon after a fast move.
  static constexpr double kStepWindow = 24.0, kStepCeiling = 14.0;
  static constexpr double kNoNoise = 1e30;      // replaces 1 / 0 if there is no noise: any step is a move
  static constexpr double kLeastNoise = 1e-12;  // of the output at the top: used for a sample without noise
  static constexpr double kAtRestShare = 0.01;
  static constexpr double kNowhere = std::numeric_limits<double>::quiet_NaN();

  // One history: its curve, the way back from a turn that is not stored yet, and the last pieces read.
  struct Branch {
    CurvePiece here = {}, there = {};
    double slope_at = kNowhere, slope = 0.0;  // steepest slope within the flat criterion's step, x per y
    double back_slope_at = kNowhere, back_slope = 0.0;
    double back_from = kNowhere;  // the output at the turn of the way back
    typename Curve::Way back = {};
    Curve curve;
    explicit Branch(Curve own) : curve(std::move(own)) {}

    void forget() {
      here = {};
      back_from = slope_at = back_slope_at = kNowhere;
    }
    void start(bool from_top) {
      curve.start(from_top);
      forget();
    }
    void turn(double y) {
      find_back(y);
      curve.turn(back);
      forget();
    }
    void go(double y) {
      const double u = curve.place(y);
      if (here.holds(u)) return;
      curve.go(u);
      here = curve.piece(u);
      back_from = slope_at = kNowhere;
    }
    // `piece`: the last piece read, `here` or on the way back.
    double read(CurvePiece& piece, bool on_back, double y) const {
      const double u = curve.place(y);
      if (!piece.holds(u)) piece = on_back ? curve.piece(back, u) : curve.piece(u);
      return curve.input(piece.along(u));
    }
    double steepest(const CurvePiece& at, bool on_back, double y, double off) const {
      const auto x = [&](double to) {
        CurvePiece piece = at;
        return read(piece, on_back, to);
      };
      const double middle = x(y);
      return std::max(middle - x(y - off), x(y + off) - middle) / off;
    }
    double x(double y) { return read(here, false, y); }
    void find_back(double from) {
      if (back_from == from) return;
      const double u = curve.place(from);
      back = curve.back_from(u, u > here.low && u < here.high ? here : curve.piece(u));  // at an end, the next piece
      back_from = from;
      there = {};
      back_slope_at = kNowhere;
    }
    double x_back(double from, double y) {
      find_back(from);
      return read(there, true, y);
    }
    // Within half the step the same value is used.
    double steepest_at(double y, double off) {
      if (off <= 0.0) return 0.0;
      if (!(std::abs(y - slope_at) <= 0.5 * off)) {
        slope = steepest(here, false, y, off);
        slope_at = y;
      }
      return slope;
    }
    double steepest_back(double from, double y, double off) {
      if (off <= 0.0) return 0.0;
      if (!(std::abs(y - back_slope_at) <= 0.5 * off)) {
        find_back(from);
        back_slope = steepest(there, true, y, off);
        back_slope_at = y;
      }
      return back_slope;
    }
  };
  struct Reading {
    double x = 0.0, slope = 0.0, squared = 0.0;  // inputs; of an output; uncertainty squared, of noise and turns
  };

  const DynamicsStep* passed_in(double seconds) const {
    if (!(seconds >= 0.0 && seconds <= std::numeric_limits<double>::max())) [[unlikely]]
      throw std::invalid_argument("compensator: a time is negative or not a finite number");
    return time_ ? &time_->after(seconds) : nullptr;
  }

  // An impossible output is a spike, unless it came from the nearby end or persists: then it counts as the loop's end.
  bool accepted_though_beyond(double& y) {
    const double end = y > top_ ? top_ : 0.0;
    const bool nearby = started_ && (y > top_ ? mean_ >= end - band_ : mean_ <= end + band_);
    if (std::isnan(y) || (!nearby && ++spikes_ <= options_.longest_spike)) return false;
    y = y > top_ ? std::max(end, mean_) : std::min(end, mean_);  // never back from the present mean
    return true;
  }

  Compensated hold(const DynamicsStep* passed, bool beyond) {
    if (passed != nullptr) advance(time_->dynamics, dynamics_, *passed, last_.pressure_psi - x_low_);
    Compensated result = last_;
    result.out_of_range = beyond;
    result.held = true;
    return result;
  }

  void follow(double y) {
    const double off = y - mean_, off2 = off * off;
    // A step's variance is noise2 (1 + weight); 1 - weight / 2 is close enough to the inverse and needs no division.
    const double step = off2 * per_noise2_ * (1.0 - 0.5 * weight_);
    const bool moving = steps_ > moving_;
    steps_ += (std::min(step, kStepCeiling) - steps_) * (1.0 / kStepWindow);
    if (moving || off2 > jump2_ * (1.0 + weight_)) {
      weight_ = 1.0;
      mean_ = y;
    } else {
      if (weight_ > least_weight_) weight_ = std::max(weight_ / (1.0 + weight_), least_weight_);
      mean_ += weight_ * off;
    }
  }

  // The highest of many means lies too high: the turn is reduced by the lead, which is 0 for a single sample.
  void take_extreme() {
    extreme_ = turn_ = mean_;
    extreme_weight_ = weight_;
    extreme_factor_ = last_factor_;
    if (!decided_ || weight_ == 1.0) return;
    const double lead = options_.lead_in_noises * noise_ * std::sqrt(weight_) * (1.0 - weight_);
    turn_ += ascending_ ? -lead : lead;
  }

  // A start whose direction is not known yet: the first mean is kept until the output has left it.
  void decide_when_beyond() {
    const double off = mean_ - extreme_;
    if (off * off > band2_ * std::max(weight_, extreme_weight_)) {
      (off > 0.0 ? high_ : low_).turn(extreme_);  // one of the two histories has just turned
      decided_ = true;
      ascending_ = off > 0.0;
      held_ = back_ = false;
      take_extreme();
    } else if (weight_ < extreme_weight_) {
      take_extreme();
    }
  }

  // Of the mean and the mean corrected for the creep since the extreme, the one nearer to the extreme: a movement by
  // creep alone is not a turn.
  [[nodiscard]] double nearer_mean() const {
    const double measured = mean_ * last_factor_ / extreme_factor_;
    return ascending_ ? std::max(mean_, measured) : std::min(mean_, measured);
  }
  [[nodiscard]] bool zone_is_unchanged() const {
    const double nearer = nearer_mean();
    return nearer >= nearer_from_ && nearer <= nearer_to_;
  }

  void turn_when_beyond() {
    const double ahead = ascending_ ? mean_ - extreme_ : extreme_ - mean_;
    const double nearer = nearer_mean(), behind = ascending_ ? turn_ - nearer : nearer - turn_;
    const double behind2 = behind > 0.0 ? behind * behind : 0.0;
    const double wider = std::max(weight_, extreme_weight_);
    held_ = ahead <= 0.0 || ahead * ahead <= hold2_ * wider;
    back_ = behind2 > hold2_ * wider;
    if (behind2 > band2_ * wider) [[unlikely]] {
      if (ascending_) observe_top();
      low_.turn(turn_);
      if (unknown_) high_.turn(turn_);
      ascending_ = !ascending_;
      held_ = back_ = false;
      take_extreme();
      return;
    }
    // The output came to rest so near that the extreme was noise.
    const bool rested = weight_ <= least_weight_ && extreme_weight_ > weight_ && behind2 <= rest2_;
    if (ahead < 0.0 && !rested) return;
    take_extreme();
    back_ = false;
  }

  // To be called at a turn from rising to falling, before it is stored.
  void observe_top() {
    const double measured = turn_ / scale_, share = options_.top_share;
    if (share <= 0.0 || measured < (1.0 - share) * top_) return;
    highest_ = std::max(measured, highest_ - options_.top_forget * (highest_ - measured));
    const double scale = std::clamp(top_ / highest_, 1.0 / (1.0 + 5.0 * share), 1.0 / (1.0 - share));
    const double change = scale / scale_;
    scale_ = scale;
    for (double* const own : {&mean_, &extreme_, &turn_, &last_y_}) *own *= change;
  }

  [[gnu::noinline]] Reading read_fully() {
    if (decided_)
      turn_when_beyond();
    else
      decide_when_beyond();
    if (decided_ && mean_ == extreme_) {
      low_.go(mean_);
      if (unknown_) high_.go(mean_);
    }
    Reading now = read(low_, noise2_);
    if (unknown_) settle(now);
    find_reusable_range();
    return now;
  }

  // `noise2`: the noise's part of the squared uncertainty.
  Reading read(Branch& branch, double& noise2) {
    branch.x(mean_);
    double steepest = branch.steepest_at(mean_, off_);
    if (decided_ && (back_ || held_)) {
      // The output may have turned already: then the way back shows how much input corresponds to the noise.
      steepest = std::max(steepest, branch.steepest_back(turn_, mean_, off_));
      if (back_) branch.x_back(turn_, mean_);
    }
    noise2 = stated_noise_ * stated_noise_ * weight_ * steepest * steepest;
    Reading now = read_again(branch, noise2);
    if (const double end = std::clamp(mean_, 0.0, top_), off = mean_ - end; std::abs(off) > band_) {
      // Drift, or an input beyond the range: the error is the input change that an equal change of output means inside
      // the range.
      CurvePiece at = branch.here;
      const double clamped = branch.read(at, false, end) - branch.read(at, false, end - off);
      now.squared += clamped * clamped;
    }
    return now;
  }

  // Reads on the pieces found last.
  Reading read_again(const Branch& branch, double noise2) const {
    const double u = branch.curve.place(mean_), x = branch.curve.input(branch.here.along(u));
    if (!back_) return {x, branch.here.slope * branch.curve.stretch(mean_), noise2};
    const double there = branch.curve.input(branch.there.along(u));
    const double doubt =
        (there - x) * (1.0 / 3.4641016151377544);  // turned or not: uniform distribution between the two, / sqrt(12)
    return {there, branch.there.slope * branch.curve.stretch(mean_), noise2 + doubt * doubt};
  }

  // The range of means for which a further reading finds the same pieces, slopes and zone.
  void find_reusable_range() {
    reusable_from_ = kNowhere;
    if (weight_ > least_weight_ || extreme_weight_ > weight_ || unknown_ || !(held_ || back_) ||
        std::isnan(low_.back_slope_at))
      return;
    const double way = ascending_ ? -1.0 : 1.0, hold = turn_ + way * std::sqrt(hold2_ * weight_);
    const double beyond = back_ ? turn_ + way * std::sqrt(band2_ * weight_) : -way * kNoNoise;
    nearer_from_ = std::min(hold, beyond);
    nearer_to_ = std::max(hold, beyond);
    reusable_from_ = back_ || ascending_ ? -kNoNoise : extreme_;
    reusable_to_ = back_ || !ascending_ ? kNoNoise : extreme_;
    const auto within = [&](double from, double to) {
      reusable_from_ = std::max(reusable_from_, from);
      reusable_to_ = std::min(reusable_to_, to);
    };
    for (const double at : {low_.slope_at, low_.back_slope_at}) within(at - 0.5 * off_, at + 0.5 * off_);
    within(low_.curve.output(low_.here.low), low_.curve.output(low_.here.high));
    if (back_) within(low_.curve.output(low_.there.low), low_.curve.output(low_.there.high));
    within(-band_, top_ + band_);
    const double little = 1e-6 * off_;  // larger than the rounding of these ends
    for (double* const from : {&reusable_from_, &nearer_from_}) *from += little;
    for (double* const to : {&reusable_to_, &nearer_to_}) *to -= little;
  }

  void settle(Reading& now) {
    double noise2 = 0.0;
    const Reading low = read(high_, noise2);
    const double apart = now.x - low.x;
    if (std::abs(apart) <= options_.known_share * span_) {
      unknown_ = false;
      if (!decided_) take_extreme();
      decided_ = true;
      return;
    }
    now.x = 0.5 * (now.x + low.x);
    noise2_ = std::max(noise2_, noise2);
    // Half the distance, because ELAM's inner curves may leave the area between the two.
    now.squared = std::max(now.squared, low.squared) + 0.25 * apart * apart;
  }

  [[nodiscard]] double squared_residual(double x) const {
    if (residual_.empty()) return 0.0;
    const std::size_t levels = residual_.size() / 2;
    const std::size_t at = interval_of(x / span_ * static_cast<double>(levels), levels);
    const double left = residual_[ascending_ ? at : levels + at], changed = top_doubt_ * (1.0 - scale_) * x;
    return left * left + changed * changed;
  }

  // Uncertain share of the output: creep that is still to come, or that had not happened when it was read.
  [[nodiscard]] double unsettled_share(double pressure) const {
    const double target = creep_target(time_->dynamics, pressure);
    double sum = 0.0;
    for (std::size_t j = 0; j < kCreepElements; ++j) sum += creep_doubt_[j] * std::abs(dynamics_.psi[j] - target);
    return sum;
  }

  // Members that each sample needs are adjacent and in order of use, because an array's state passes through the cache
  // in each frame.
  std::shared_ptr<PassedTime> time_;
  double creep_scale_, lag_share_;
  std::array<double, kCreepElements> creep_doubt_{};  // of each element's share of the output
  DynamicsState dynamics_;
  double last_x_ = 0.0, last_slope_ = 0.0, last_y_ = 0.0, last_factor_ = 1.0;  // x: above the lowest
  double steepest_guess_ = 0.0;
  double reusable_from_ = kNowhere, reusable_to_ = kNowhere, nearer_from_ = 0.0, nearer_to_ = 0.0;
  double noise2_ = 0.0;                              // of the last reading
  double zero_, per_gain_, scale_ = 1.0;             // scale: by the observed top
  double x_low_, span_, top_;                        // inputs; output
  double stated_noise_, band_ = 0.0, margin_ = 0.0;  // of a sample, of the model's output
  double per_noise2_ = 0.0, jump2_ = 0.0, band2_ = 0.0, hold2_ = 0.0, rest2_ = 0.0, off_ = 0.0, flat2_ = 0.0;
  double top_doubt_, moving_, least_weight_;
  bool unknown_ = false;
  bool started_ = true;  // false: no sample yet
  bool decided_ = true;  // false: rises or falls, not known yet
  bool ascending_ = true;
  bool held_ = true, back_ = false;   // held_: moved by no more than the noise; back_: behind the extreme by more
  int spikes_ = 0;                    // in a row
  double steps_ = 0.0;                // running mean square of the steps, in noises squared
  double mean_ = 0.0, weight_ = 1.0;  // weight_: of the last sample in the mean, 1 / number of samples
  double extreme_ = 0.0, extreme_weight_ = 1.0;  // furthest mean since the last turn
  double extreme_factor_ = 1.0;                  // creep factor there
  double turn_ = 0.0;                            // the extreme without its lead
  std::vector<double> residual_;
  Compensated last_;
  Branch low_, high_;  // high_: of an unknown history, the one that fell from the top
  CompensatorOptions options_;
  double noise_, worked_s_, highest_ = 0.0;  // of the observed top
};

}  // namespace tactbench::analysis
