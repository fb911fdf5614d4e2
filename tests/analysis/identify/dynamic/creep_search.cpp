// The creep of an array from held levels, on outputs that change within each hold as the formula has it: shares, half
// and the taxels' scales come out as they were put in.
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "analysis/identify/dynamic/dynamics_search.h"
#include "analysis/identify/dynamic/track.h"
#include "tests/analysis/support/dynamic_walk.h"

using namespace synthetic;

namespace {

constexpr double kSecondsAFrame = 2.0;
constexpr std::size_t kFrames = 40;  // a level; the first three are within 6 s of its beginning

double half_tried(int k) {
  double half = 1.0;
  for (int i = 0; i < k; ++i) half *= 1.2;
  return half;
}

// Frames of held levels.
Dataset held_levels(const std::vector<double>& levels, std::size_t taxels, std::size_t frames = kFrames) {
  Dataset data;
  data.rows = 1;
  data.columns = static_cast<int>(taxels);
  Repeat repeat;
  double now = 0.0;
  for (const double psi : levels)
    for (std::size_t f = 1; f <= frames; ++f) {
      now += kSecondsAFrame;
      repeat.steps.push_back({psi, psi, now, kSecondsAFrame * static_cast<double>(f)});
    }
  repeat.volts.assign(repeat.steps.size() * taxels, 0.0);
  data.sequences.push_back({"creep-levels", {std::move(repeat)}});
  return data;
}

// psi of each element at each frame, from rest, and its mean over the settled frames of each level.
struct Elements {
  std::vector<std::array<double, 3>> psi, mean;
};

Elements elements_along(const std::vector<double>& levels, const Dynamics& d, std::size_t frames = kFrames) {
  Elements all;
  std::array<double, 3> psi{};
  for (const double level : levels) {
    std::array<double, 3> sum{};
    for (std::size_t f = 1; f <= frames; ++f) {
      for (std::size_t j = 0; j < 3; ++j) {
        const double target = level / (level + d.creep_half);
        psi[j] = target + (psi[j] - target) * std::exp(-kSecondsAFrame / d.creep_s[j]);
        if (f > 3) sum[j] += psi[j] / static_cast<double>(frames - 3);
      }
      all.psi.push_back(psi);
    }
    all.mean.push_back(sum);
  }
  return all;
}

struct Truth {
  std::vector<double> levels{20, 40, 10};
  std::vector<double> volts{1.0, 1.6, 0.7};  // mean of each level above zero
  Dynamics d;
};

Truth any_truth(int half) {
  Truth truth;
  truth.d.creep_share = {0.03, 0.02, 0.05};
  truth.d.creep_half = half_tried(half);
  return truth;
}

// Relative change within each level by the creep's formula, `scale` times the array's.
void creep_taxel(Dataset& data, const Truth& truth, std::size_t taxel, double zero, double scale) {
  const Elements all = elements_along(truth.levels, truth.d);
  const auto width = static_cast<std::size_t>(data.columns);
  for (std::size_t i = 0; i < all.psi.size(); ++i) {
    const std::size_t level = i / kFrames;
    double change = 0.0;
    for (std::size_t j = 0; j < 3; ++j) change += truth.d.creep_share[j] * (all.psi[i][j] - all.mean[level][j]);
    data.sequences[0].repeats[0].volts[i * width + taxel] = zero + truth.volts[level] * (1.0 + scale * change);
  }
}

// The mean of 1 + sum k (psi - 1) over all settled frames.
double factor_of(const Truth& truth) {
  const Elements all = elements_along(truth.levels, truth.d);
  double factor = 0.0;
  for (const std::array<double, 3>& mean : all.mean) {
    double own = 1.0;
    for (std::size_t j = 0; j < 3; ++j) own += truth.d.creep_share[j] * (mean[j] - 1.0);
    factor += own / static_cast<double>(all.mean.size());
  }
  return factor;
}

int holds_in(const Dataset& data) {
  ArrayDynamics found = nothing_known(1);
  find_creep(data, {0.0}, {true}, found);
  return found.holds;
}

}  // namespace

TEST_CASE("creep: shares, half and the taxels' scales are those of the outputs", "[dynamic]") {
  for (const int half : {0, 9, 22}) {
    const Truth truth = any_truth(half);
    Dataset data = held_levels(truth.levels, 3);
    creep_taxel(data, truth, 0, 0.1, 0.8);
    creep_taxel(data, truth, 1, 0.4, 1.2);
    for (std::size_t i = 0; i < data.sequences[0].repeats[0].steps.size(); ++i)
      data.sequences[0].repeats[0].volts[i * 3 + 2] = 100.0 * static_cast<double>(i % 7);  // not usable
    ArrayDynamics found = nothing_known(3);
    find_creep(data, {0.1, 0.4, 0.0}, {true, true, false}, found);
    CAPTURE(half);
    CHECK(found.holds == 3);
    CHECK(found.shared.creep_half == truth.d.creep_half);
    const double factor = factor_of(truth);
    for (std::size_t j = 0; j < 3; ++j)
      CHECK(found.shared.creep_share[j] == Approx(truth.d.creep_share[j] * factor).epsilon(1e-4));
    CHECK(found.creep_scale[0] == Approx(0.8).epsilon(1e-5));
    CHECK(found.creep_scale[1] == Approx(1.2).epsilon(1e-5));
    CHECK(found.creep_scale[2] == 1.0);
  }
}

TEST_CASE("creep: of known creep the taxels' scales alone are found", "[dynamic]") {
  const Truth truth = any_truth(9);
  Dataset data = held_levels(truth.levels, 2);
  creep_taxel(data, truth, 0, 0.1, 0.7);
  creep_taxel(data, truth, 1, 0.4, 1.5);
  ArrayDynamics found = nothing_known(2);
  found.shared = truth.d;
  find_creep_scales(data, {0.1, 0.4}, {true, true}, found);
  CHECK(found.creep_scale[0] == Approx(0.7 / 1.1).epsilon(1e-6));  // over the median
  CHECK(found.creep_scale[1] == Approx(1.5 / 1.1).epsilon(1e-6));
  CHECK(found.shared.creep_share == truth.d.creep_share);
  // Without a held level they stay as they were.
  ArrayDynamics nothing = nothing_known(2);
  nothing.creep_scale = {0.3, 0.4};
  find_creep_scales(held_levels(truth.levels, 2, 5), {0.1, 0.4}, {true, true}, nothing);
  CHECK(nothing.creep_scale == std::vector<double>{0.3, 0.4});
}

TEST_CASE("creep: a taxel's scale is within 0 and what leaves a tenth of its output", "[dynamic]") {
  Truth truth = any_truth(9);
  Dataset data = held_levels(truth.levels, 5);
  const std::vector<double> zeros(5, 0.0), scales = {-2.0, 30.0, 2.0, 1.0, 1.0 / 3.0};
  const std::vector<bool> usable(5, true);
  for (std::size_t t = 0; t < scales.size(); ++t) creep_taxel(data, truth, t, 0.0, scales[t]);
  ArrayDynamics found = nothing_known(5);
  found.shared = truth.d;  // 0.1 of the output together: nine times that is the most
  find_creep_scales(data, zeros, usable, found);
  CHECK(found.creep_scale[0] == 0.0);
  CHECK(found.creep_scale[1] == Approx(9.0));
  for (std::size_t t = 2; t < scales.size(); ++t) CHECK(found.creep_scale[t] == Approx(scales[t]).epsilon(1e-6));
  // Of little creep ten times as much.
  truth.d.creep_share = {0.003, 0.002, 0.005};
  for (std::size_t t = 0; t < scales.size(); ++t) creep_taxel(data, truth, t, 0.0, scales[t]);
  found.shared = truth.d;
  find_creep_scales(data, zeros, usable, found);
  CHECK(found.creep_scale[1] == 10.0);
  // A taxel without output has no creep of its own.
  ArrayDynamics silent = nothing_known(1);
  silent.shared = truth.d;
  find_creep_scales(held_levels(truth.levels, 1), {0.0}, {true}, silent);
  CHECK(silent.creep_scale[0] == 1.0);
}

TEST_CASE("creep: a taxel's scale is drawn toward the array's by its doubt", "[dynamic]") {
  const Truth truth = any_truth(9);
  Dataset data = held_levels(truth.levels, 3);
  for (std::size_t t = 0; t < 3; ++t) creep_taxel(data, truth, t, 0.0, t == 0 ? 1.5 : 1.0);
  const Elements all = elements_along(truth.levels, truth.d);
  const double factor = factor_of(truth);
  const std::size_t rows = 3 * (kFrames - 3);
  // The column that the scale is of: the array's change of each settled frame, times the level's volts.
  std::vector<double> column;
  double squares = 0.0;
  for (std::size_t i = 0; i < all.psi.size(); ++i) {
    double change = 0.0;
    for (std::size_t j = 0; j < 3; ++j)
      change += truth.d.creep_share[j] * (all.psi[i][j] - all.mean[i / kFrames][j]) / factor;
    column.push_back(truth.volts[i / kFrames] * change);
    if (i % kFrames >= 3) squares += column.back() * column.back();
  }
  // Errors of three frames of the first level which change neither its mean nor the scale: across 1 and the column.
  const double a = column[5], b = column[15], c = column[35];
  const double errors[] = {c - b, a - c, b - a};
  double rest = 0.0;
  std::vector<double>& volts = data.sequences[0].repeats[0].volts;
  const std::size_t places[] = {5, 15, 35};
  for (std::size_t k = 0; k < 3; ++k) {
    volts[3 * places[k]] += 10.0 * errors[k];
    rest += 100.0 * errors[k] * errors[k];
  }
  ArrayDynamics found = nothing_known(3);
  found.shared = truth.d;
  find_creep_scales(data, {0.0, 0.0, 0.0}, {true, true, true}, found);
  const double doubt2 = rest / static_cast<double>(rows) / squares / (factor * factor),
               kept = 0.0625 / (0.0625 + doubt2);
  REQUIRE((kept > 0.1 && kept < 0.99));
  CHECK(found.creep_scale[0] == Approx(1.0 + 0.5 * kept).epsilon(1e-6));
}

TEST_CASE("creep: a level is held for ten settled frames within half a psi of its first one, above half a psi",
          "[dynamic]") {
  // Frames at 2, 4, 6 s and so on: the first three of a level are within 6 s of its first.
  CHECK(holds_in(held_levels({20}, 1, 13)) == 1);
  CHECK(holds_in(held_levels({20}, 1, 12)) == 0);
  CHECK(holds_in(held_levels({20, 40, 20}, 1, 13)) == 3);
  CHECK(holds_in(held_levels({0, 20, 0}, 1, 13)) == 1);
  CHECK(holds_in(held_levels({0.5}, 1, 13)) == 0);
  CHECK(holds_in(held_levels({0.5625}, 1, 13)) == 1);
  Dataset drifting = held_levels({20}, 1, 13);
  for (const auto& [off, holds] : {std::pair{0.4375, 1}, {0.5, 0}, {-0.4375, 1}, {-0.5, 0}}) {
    drifting.sequences[0].repeats[0].steps.back().reference_psi = 20.0 + off;
    CAPTURE(off);
    CHECK(holds_in(drifting) == holds);
  }
  CHECK(holds_in({}) == 0);
}

TEST_CASE("a track is a run's samples in their order, its span the highest set-point", "[dynamic]") {
  const Dataset data = walked_run({}, {{0.0, 0.1, 1.0, 0.0}, {0.5, 0.1, 1.0, 0.0}},
                                  {{"a", {{{0, 10}, 1.0}, {{5}, 2.0}}}, {"b", {{{30, 20}, 1.0, 20.0, 0.25}}}}, 30.0);
  const Track track = track_of(data);
  CHECK(track.time == std::vector<double>{1, 2, 4, 25, 26});
  CHECK(track.pressure == std::vector<double>{0, 10, 5, 30.25, 20.25});
  CHECK(track.span == 30.0);
  CHECK(track.sequence == std::vector<std::size_t>{0, 0, 0, 1, 1});
  CHECK(track.repeat == std::vector<std::size_t>{0, 0, 1, 0, 0});
  CHECK(track.step == std::vector<std::size_t>{0, 1, 0, 0, 1});
  CHECK(track.volts[3][1] == Approx(0.5 + 3.025));
  CHECK(track.samples[4]->setpoint_psi == 20.0);
  // psi along it, with 20 s of conditioning before the fourth: toward 1 - half / span ln(1 + span / half) meanwhile.
  Dynamics d;
  d.creep_half = 10.0;
  const auto psi = walk_creep(track, d);
  REQUIRE(psi.size() == 5);
  const double after = 0.5 * (1.0 - std::exp(-1.0 / 3.0));  // 10 / (10 + 10)
  CHECK(psi[0][0] == 0.0);
  CHECK(psi[1][0] == Approx(after));
  const double third = 1.0 / 3.0 + (after - 1.0 / 3.0) * std::exp(-2.0 / 3.0), mean = 1.0 - std::log(4.0) / 3.0;
  CHECK(psi[2][0] == Approx(third));
  const double worked = mean + (third - mean) * std::exp(-20.0 / 3.0), target = 30.25 / 40.25;
  CHECK(psi[3][0] == Approx(target + (worked - target) * std::exp(-1.0 / 3.0)));
}

TEST_CASE("time passed: what no command accounts for was conditioning, the first sample has what its command tells") {
  const auto passed = [](double time_s, double held_s, double before_s) {
    const TimePassed own = time_passed({0.0, 0.0, time_s, held_s}, before_s);
    return std::vector<double>{own.worked_s, own.step_s};
  };
  CHECK(passed(12.0, 2.0, 10.0) == std::vector<double>{0.0, 2.0});
  CHECK(passed(17.0, 2.0, 10.0) == std::vector<double>{0.0, 7.0});  // five seconds more than held: settling
  CHECK(passed(17.5, 2.0, 10.0) == std::vector<double>{5.5, 2.0});
  CHECK(passed(12.0, 30.0, 10.0) == std::vector<double>{0.0, 2.0});
  CHECK(passed(9.0, 2.0, 10.0) == std::vector<double>{0.0, 0.0});  // a clock that went back
  CHECK(passed(3.0, 1.0, -1.0) == std::vector<double>{0.0, 1.0});
  CHECK(passed(1.0, 3.0, -1.0) == std::vector<double>{0.0, 1.0});
  CHECK(passed(9.0, 3.0, -1.0) == std::vector<double>{6.0, 3.0});
  CHECK(passed(3.0, 1.0, 0.0) == std::vector<double>{0.0, 3.0});
}
