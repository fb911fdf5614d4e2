// Errors over histories and between dwell times, window by window, on straight taxels: by hand.
#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/statistics/figures/reading_errors.h"
#include "analysis/statistics/figures/time_effects.h"
#include "analysis/statistics/numbers/moments.h"
#include "tests/analysis/support/straight_array.h"

using namespace straight_array;

namespace {

const WindowErrors& window_of(const std::vector<WindowErrors>& windows, double pressure, bool up) {
  for (const WindowErrors& window : windows)
    if (window.pressure_psi == pressure && window.up == up) return window;
  throw std::runtime_error("no such window");
}

FrameHistory whole(const FrameErrors& run) {
  FrameHistory history{&run, {}};
  for (std::size_t i = 0; i < run.frames.size(); ++i) history.frames.push_back(i);
  return history;
}

std::vector<WindowErrors> pooled_of(const FrameErrors& one, const LevelCorrections& corrections = {}) {
  const FrameHistory history = whole(one);
  return pooled_errors({&history, 1}, straight_fit(), corrections);
}

// Full up, to 36 psi down, to 44 up and back to 0 down. The last frame but one at 30 psi is in no window.
const std::vector<double> kWandering{0, 20, 40, 60, 36, 44, 30, 0};

}  // namespace

TEST_CASE("frame errors: each frame is listed in time order with branch, direction and whether it is a full sweep") {
  const Dataset data =
      dataset_of({erring_way("a", kWandering, {{0, 1, 2, -3, 4, 5, 6, 1}}), erring_way("b", {0, 20, 0}, {{0, 7, 0}})});
  const FrameErrors errors = frame_errors(data, straight_fit(), 1);
  CHECK(errors.run == 2);
  REQUIRE(errors.frames.size() == 11);
  std::string shape;
  for (const FrameErrors::Frame& frame : errors.frames)
    shape += std::to_string(frame.branch) + (frame.up ? (frame.full ? "U " : "u ") : (frame.full ? "D " : "d "));
  CHECK(shape == "0U 0U 0U 0U 1d 2u 3d 3d 0u 0u 1d ");
  CHECK((errors.frames[9].sequence == 1 && errors.frames[9].step == 1 && errors.frames[9].setpoint_psi == 20.0));
  CHECK(errors.error_psi[3 * 4] == Approx(4.0));
  CHECK(errors.error_psi[3 * 5 + 1] == Approx(2.5));
  CHECK(errors.error_psi[3 * 9] == Approx(7.0));
  CHECK(std::isnan(errors.error_psi[2]));
}

TEST_CASE("error windows: cover 4 psi to each side including the edge, with frame counts and mean squares") {
  const FrameErrors all =
      frame_errors(dataset_of({erring_way("a", {0, 15.9, 16, 24, 24.1, 60}, {{0, 9, 1, 3, 9, 0}, {0, 9, 5, 3, 9, 0}})}),
                   straight_fit(), 1);
  CHECK(all.frames.size() == 2 * 6);
  const std::vector<WindowErrors> errors = pooled_of(all);
  REQUIRE(errors.size() == 8);
  CHECK(has_any_branch(errors));
  const WindowErrors& twenty = window_of(errors, 20, true);
  CHECK(twenty.frames == 4.0);    // 15.9 and 24.1 are in no window
  CHECK(twenty.branches == 1.0);  // the repeats go the same way
  CHECK(twenty.square_psi[0] == Approx((1.0 + 9.0 + 25.0 + 9.0) / 4));
  CHECK(twenty.square_psi[1] == Approx(11.0 / 4));
  CHECK(std::isnan(twenty.square_psi[2]));
  // The two taxels' mean errs by 3/4 of the first.
  CHECK(twenty.common_square_psi == Approx(11.0 * 0.5625));
  const WindowErrors& down = window_of(errors, 20, false);
  CHECK((down.frames == 0.0 && down.branches == 0.0));
  CHECK((std::isnan(down.square_psi[0]) && std::isnan(down.common_square_psi)));
  CHECK_FALSE(has_any_branch(pooled_errors({}, straight_fit())));
}

TEST_CASE("error windows: branches, sequences and runs add up, one run can be left out, errors can be corrected") {
  const Dataset data = dataset_of(
      {erring_way("a", {0, 20, 40, 20, 40, 0}, {{0, 1, 2, 1, 3, 0}}), erring_way("b", {0, 20, 0}, {{0, 5, 0}})});
  const FrameErrors run = frame_errors(data, straight_fit(), 1);
  const WindowErrors once = window_of(pooled_of(run), 20, true);
  CHECK((once.frames == 2.0 && once.branches == 2.0));  // the ways of a and of b
  const WindowErrors twice = window_of(pooled_of(run), 40, true);
  CHECK((twice.frames == 2.0 && twice.branches == 2.0));  // both of a
  const FrameErrors second = run;
  const std::vector<FrameHistory> histories{whole(run), whole(second)};
  const std::vector<WindowErrors> both = pooled_errors(histories, straight_fit());
  CHECK((window_of(both, 20, true).frames == 4.0 && window_of(both, 20, true).branches == 4.0));
  CHECK(window_of(pooled_errors(histories, straight_fit(), {}, 0), 20, true).frames == 2.0);
  // 0.5 psi less at 20 psi up of the first taxel: errors of 0.5 and 4.5.
  LevelCorrections corrections(2 * 4 * 3, 0.0);
  corrections[1 * 3] = 0.5;
  const WindowErrors less = window_of(pooled_of(run, corrections), 20, true);
  CHECK(less.square_psi[0] == Approx((0.25 + 20.25) / 2));
  CHECK(less.square_psi[1] == Approx((0.25 + 6.25) / 2));
}

TEST_CASE("corrections: are linear between levels of one direction, constant beyond, and 0 if there is none") {
  const SensorModel fit = straight_fit();
  CHECK(correction_at({}, fit, 0, 30.0, true) == 0.0);
  LevelCorrections corrections(2 * 4 * 3, 0.0);
  const auto set = [&](std::size_t row, double first, double second) {
    corrections[3 * row] = first;
    corrections[3 * row + 1] = second;
  };
  set(0, 1, 10);
  set(1, 2, 20);
  set(2, 6, 60);
  set(3, -2, kNan);  // up
  set(4, -1, 0);
  set(5, -5, 0);
  set(6, -7, 0);
  set(7, -9, 0);  // down
  const auto at = [&](double psi, bool up = true, std::size_t taxel = 0) {
    return correction_at(corrections, fit, taxel, psi, up);
  };
  CHECK(at(-3) == 1.0);
  CHECK(at(0) == 1.0);
  CHECK(at(5) == Approx(1.25));
  CHECK(at(20) == Approx(2.0));
  CHECK(at(30) == Approx(4.0));
  CHECK(at(55) == Approx(0.0).margin(1e-12));
  CHECK(at(60) == Approx(-2.0));
  CHECK(at(61) == -2.0);
  CHECK(at(kNan) == 1.0);
  CHECK(at(5, false) == Approx(-2.0));
  CHECK(at(61, false) == -9.0);
  CHECK(at(30, true, 1) == Approx(40.0));
  CHECK(at(50, true, 1) == Approx(30.0));  // half way to one that is not known
  CHECK(at(61, true, 1) == 0.0);
}

namespace {

const std::vector<double> kPacedLoop{0, 16, 20, 24, 60, 40, 0};

DwellEffect dwell_of(const Dataset& paced, double usual_s) {
  const Dataset calibration = dataset_of({erring_way("loop", {0, 20, 60}, {{0, 0, 0}}, {usual_s})});
  const Dataset* runs[] = {&paced};
  return dwell_effect_of(calibration, runs, straight_fit(), 1);
}

Dataset paced_at_dwells(const std::vector<double>& dwell_s) {
  std::vector<std::vector<double>> errors(dwell_s.size(), std::vector<double>(7, 0.0));
  return dataset_of({erring_way("rate", kPacedLoop, errors, dwell_s)});
}

}  // namespace

TEST_CASE("dwell effect: is the largest mean square of the repeats against the one with the nearest dwell") {
  // Dwell times of 1, 3 and 8 s; the calibration's 2 s are nearer to 3 s by factor. Against that the repeats differ by
  // (1, 2, 3) and (-2, -2, 0) psi at 16, 20, 24 psi upward: mean squares 14/3 and 8/3; at 40 psi downward by 0 and 1.
  const Dataset paced = dataset_of({erring_way(
      "rate", kPacedLoop, {{0, 1.5, 2.5, 3.5, 0, 0, 0}, {0, 0.5, 0.5, 0.5, 0, 0, 0}, {0, -1.5, -1.5, 0.5, 0, 1, 0}},
      {1, 3, 8})});
  const DwellEffect effect = dwell_of(paced, 2.0);
  REQUIRE(effect.assessed());
  CHECK(effect.run == 2);
  CHECK(effect.low_s == 1.0);
  CHECK(effect.high_s == 8.0);
  REQUIRE(effect.square_psi.size() == 2 * 4 * 3);
  const auto square = [&](std::size_t level, bool up, std::size_t taxel) {
    return effect.square_psi[((up ? 0 : 4) + level) * 3 + taxel];
  };
  CHECK(square(1, true, 0) == Approx(14.0 / 3));
  CHECK(square(1, true, 1) == Approx(14.0 / 12));
  CHECK(std::isnan(square(1, true, 2)));
  CHECK(square(3, true, 0) == Approx(0.0).margin(1e-12));
  CHECK(square(2, false, 0) == Approx(1.0));
  CHECK(std::isnan(square(2, true, 0)));   // no step within 4 psi of 40 psi on the way up
  CHECK(std::isnan(square(1, false, 0)));  // nor of 20 psi on the way down
  // 1.7 s are 1.7 times as long as 1 s and 1.76 times as short as 3 s, 5 s 1.6 and 1.67 times as 8 s and 3 s: the first
  // and the last repeat lie furthest apart.
  for (const auto& [usual_s, largest] : {std::pair{1.7, 34.0}, {1.8, 14.0}, {4.8, 14.0}, {5.0, 34.0}})
    CHECK(dwell_of(paced, usual_s).square_psi[3] == Approx(largest / 3));
}

TEST_CASE("dwell effect: dwells must differ by a factor of two, and each of at least two repeats must state one") {
  CHECK(dwell_of(paced_at_dwells({1, 2}), 1.0).assessed());
  CHECK_FALSE(dwell_of(paced_at_dwells({1, 1.99}), 1.0).assessed());
  CHECK_FALSE(dwell_of(paced_at_dwells({4}), 1.0).assessed());
  CHECK_FALSE(dwell_of(paced_at_dwells({1, 4, 0}), 1.0).assessed());
  CHECK_FALSE(dwell_of(paced_at_dwells({1, 4}), 0.0).assessed());
  CHECK_FALSE(dwell_of(paced_at_dwells({4}), 1.0).not_assessed.empty());
  // The first run, and in it the first sequence, that tells.
  Dataset first = paced_at_dwells({1, 1}), second = paced_at_dwells({1, 4}), third = paced_at_dwells({1, 9});
  second.sequences.insert(second.sequences.begin(), first.sequences.front());
  second.run = 8;
  const Dataset* runs[] = {&first, &second, &third};
  const DwellEffect effect = dwell_effect_of(second, runs, straight_fit(), 1);
  CHECK(effect.run == 8);
  CHECK(effect.high_s == 4.0);
}

TEST_CASE("median dwell: is the median over repeats of their medians, above 0.5 psi, where stated") {
  Dataset data = dataset_of({erring_way("a", {0, 0.5, 0.51, 20, 40}, {{0, 0, 0, 0, 0}}, {1})});
  std::vector<Sample>& steps = data.sequences[0].repeats[0].steps;
  for (std::size_t i = 0; i < 5; ++i) steps[i].held_s = 100.0 / static_cast<double>(i + 1);  // 100 50 33.3 25 20
  CHECK(median_dwell_s(data) == Approx(25.0));
  steps[4].held_s = 0.0;
  CHECK(median_dwell_s(data) == Approx((100.0 / 3 + 25.0) / 2));
  data.sequences.push_back(erring_way("b", {20, 40}, {{0, 0}, {0, 0}}, {7, 9}));
  CHECK(median_dwell_s(data) == 9.0);  // of 29.2, 7 and 9
  CHECK(std::isnan(median_dwell_s(dataset_of({erring_way("c", {0, 0.5}, {{0, 0}}, {3})}))));
}
