// Figures that are followed from run to run, the taxels a report shows, usable ranges and creep to their bounds: by
// hand.
#include <catch2/catch.hpp>
#include <cmath>
#include <stdexcept>

#include "analysis/identify/histories.h"
#include "analysis/statistics/figures/behaviour.h"
#include "analysis/statistics/figures/evaluation.h"
#include "analysis/statistics/figures/time_effects.h"
#include "analysis/statistics/numbers/moments.h"
#include "tests/analysis/support/straight_array.h"

using namespace straight_array;

namespace {

// Frames at one set-point, `held_s` and two seconds more from frame to frame.
Repeat held_at(double psi, const std::vector<double>& volts, double held_s = 2.0) {
  Repeat repeat;
  for (std::size_t i = 0; i < volts.size(); ++i) {
    repeat.steps.push_back({psi, psi, 100.0 + 2.0 * static_cast<double>(i), held_s});
    repeat.volts.insert(repeat.volts.end(), {volts[i], volts[i], 9.0});
  }
  return repeat;
}

void append_to(Repeat& repeat, const Repeat& more) {
  repeat.steps.insert(repeat.steps.end(), more.steps.begin(), more.steps.end());
  repeat.volts.insert(repeat.volts.end(), more.volts.begin(), more.volts.end());
}

Dataset holding(const Repeat& repeat) { return dataset_of({{"creep-hold", {repeat}}}); }

}  // namespace

TEST_CASE("run values: percents, millivolts, means of fitted taxels and largest noise match hand-computed values") {
  SensorModel fit = straight_fit();
  fit.taxels[2].noise = 0.003;  // not fitted, and the noisiest
  const std::vector<double> ends{0.0, 60.0}, first_v{0.02, 3.0}, second_v{0.05, 3.0};
  const PatternCurve first(ends, first_v, 0.02, 3.0), second(ends, second_v, 0.05, 3.0);
  fit.taxels[0] = by_hand::elam_taxel(first, first, {0.7, 0.9, -0.004, 0.6, 0.3});
  fit.taxels[1] = by_hand::elam_taxel(second, second, {0.8, 0.95, -0.008, 0.5, 0.4});
  fit.taxels[0].noise = 0.002;
  Evaluation evaluation;
  evaluation.hysteresis_max_fs = 0.25;
  evaluation.hysteresis_mean_fs = 0.1;
  evaluation.mean_error_psi = 0.3;
  evaluation.max_error_psi = 2.5;
  evaluation.worst_taxel_mean_error_psi = 0.9;
  evaluation.comp_distance_of_mean = 0.012;
  evaluation.flat_share = 0.5;
  evaluation.full_scale_v = kNan;
  const std::map<std::string, double> f = figures_of(fit, evaluation);
  const std::map<std::string, double> expected{{"hysteresis_max_percent_fs", 25.0},
                                               {"hysteresis_mean_percent_fs", 10.0},
                                               {"mean_error_psi", 0.3},
                                               {"max_error_psi", 2.5},
                                               {"worst_taxel_error_psi", 0.9},
                                               {"distance_of_mean_percent_fs", 1.2},
                                               {"flat_percent", 50.0},
                                               {"noisiest_taxel_mv", 3.0},
                                               {"zero_mv", 35.0},
                                               {"elam_alpha_d", 0.75},
                                               {"elam_beta_d", 0.925},
                                               {"elam_alpha_a1_per_psi", -0.006},
                                               {"elam_alpha_a0", 0.55},
                                               {"elam_beta_a", 0.35},
                                               {"unfit_taxels", 1.0}};
  REQUIRE(f.size() == expected.size());  // what is no number is left out
  for (const auto& [name, value] : expected) {
    INFO(name);
    REQUIRE(f.contains(name));
    CHECK(f.at(name) == Approx(value));
  }
  for (std::size_t i = 0; i < 3; ++i) fit.taxels[i] = by_hand::left_out(TaxelStatus::kDead);
  const std::map<std::string, double> none = figures_of(fit, evaluation);
  CHECK(none.at("unfit_taxels") == 3.0);
  CHECK((none.count("zero_mv") == 0 && none.count("elam_alpha_d") == 0 && none.at("noisiest_taxel_mv") == 0.0));
}

TEST_CASE("taxel gains: are taken at the level nearest to two thirds of the range, the lower of two equally near") {
  const auto level_of = [](const std::vector<double>& rising) {
    std::vector<double> loop = rising;
    for (std::size_t i = rising.size() - 1; i-- > 0;) loop.push_back(rising[i]);
    Repeat repeat;
    for (const double psi : loop) {
      repeat.steps.push_back({psi, psi});
      repeat.volts.insert(repeat.volts.end(), {psi, 3 * psi, 9.0});
    }
    const Behaviour b = behaviour_of(dataset_of({{"loop", {repeat}}}), {0, 1});
    CHECK(b.gain[0] == Approx(0.5));
    CHECK(b.gain[1] == Approx(1.5));
    CHECK(b.full_scale_v == Approx(2 * rising.back()));
    return b.equilibration_psi;
  };
  CHECK(level_of({0, 20, 40, 60}) == 40.0);
  CHECK(level_of({30, 40, 50, 60, 90}) == 60.0);  // 70 psi
  CHECK(level_of({30, 69, 72, 90}) == 69.0);
  CHECK(level_of({30, 67, 72, 90}) == 72.0);
  CHECK(level_of({0, 39, 41, 60}) == 39.0);
}

TEST_CASE("raw loops: full scale and hysteresis of a taxel are right for either branch and sign") {
  // Outputs fall: -4 V is the full scale. Off by 1 and 0.5 V of it at 20 and 40 psi, by nothing at the ends.
  Repeat repeat;
  const std::vector<double> psi{0, 20, 40, 60, 40, 20, 0}, volts{0, -1, -2, -4, -2.5, -2, 0};
  for (std::size_t i = 0; i < psi.size(); ++i) {
    repeat.steps.push_back({psi[i], psi[i]});
    repeat.volts.insert(repeat.volts.end(), {volts[i], 2 * volts[i], 9.0});
  }
  const Behaviour b = behaviour_of(dataset_of({{"loop", {repeat}}}), {1, 0});
  CHECK(b.hysteresis_max[0] == Approx(0.25));
  CHECK(b.hysteresis_mean[0] == Approx((0.25 + 0.125) / 4));
  CHECK(b.loops[0].full_scale_v == Approx(6.0));
  CHECK(b.loops[1].name == "best");
  CHECK(b.loops[1].taxel == 1);  // alike: the first that counts
  CHECK(b.loops[2].taxel == 1);
  CHECK(b.loops[3].taxel == 0);
  CHECK((b.loops[2].name == "median" && b.loops[3].name == "worst"));
  CHECK((std::isnan(b.hysteresis_max[2]) && std::isnan(b.gain[2])));  // does not count
  CHECK((b.repeatability.empty() && b.creep.empty()));
  REQUIRE(b.traces.size() == 1);
  CHECK(b.traces[0].output_v[1] == Approx(-1.5));  // the mean taxel's
  CHECK_THROWS_AS(behaviour_of(dataset_of({{"loop", {repeat}}}), {}), std::invalid_argument);
}

TEST_CASE("repeatability: needs two repeats, and uses those that each sequence has") {
  const auto loop = [](double more) {
    Repeat repeat;
    for (const double psi : {0.0, 20.0, 60.0, 20.0, 0.0}) {
      repeat.steps.push_back({psi, psi});
      repeat.volts.insert(repeat.volts.end(), {psi + more, psi + more, 9.0});
    }
    return repeat;
  };
  // Three repeats of the first sequence, and one of the second, which counts in the first loop alone: 1, 2 and 6.
  const Behaviour b = behaviour_of(dataset_of({{"a", {loop(1), loop(2), loop(6)}}, {"b", {loop(1)}}}), {0, 1});
  CHECK(b.repeats == 3);
  CHECK(b.repeatability[1].mean_up_v == Approx(std::sqrt((4.0 + 1.0 + 9.0) / 2)));
  CHECK(b.repeatability[1].taxel_down_v == Approx(std::sqrt(7.0)));
  CHECK(behaviour_of(dataset_of({{"a", {loop(1)}}, {"b", {loop(2)}}}), {0}).repeatability.empty());
  CHECK(behaviour_of(dataset_of({{"a", {loop(1)}}, {"b", {loop(2)}}}), {0}).repeats == 1);
}

TEST_CASE("holds: need twenty frames at one set-point above 0.5 psi, one command, and times that increase") {
  const auto holds_in = [](const Repeat& repeat, std::size_t fewest = kMinHeldFrames) {
    return held_frames_of(holding(repeat), fewest);
  };
  const std::vector<double> twenty(20, 1.0);
  REQUIRE(holds_in(held_at(40, twenty)).size() == 1);
  CHECK(holds_in(held_at(40, std::vector<double>(19, 1.0))).empty());
  CHECK(holds_in(held_at(40, std::vector<double>(3, 1.0)), 3).size() == 1);
  CHECK(holds_in(held_at(0.5, twenty)).empty());
  CHECK(holds_in(held_at(0.51, twenty)).size() == 1);
  CHECK(holds_in(held_at(40, twenty, 0.0)).empty());
  Repeat still = held_at(40, twenty);
  for (Sample& step : still.steps) step.time_s = 7.0;
  CHECK(holds_in(still).empty());
  // From below, from above, and again after another level.
  Repeat several = held_at(0, {0.0});
  append_to(several, held_at(40, twenty));
  append_to(several, held_at(20, std::vector<double>(21, 1.0)));
  append_to(several, held_at(40, twenty));
  const std::vector<HeldFrames> holds = holds_in(several);
  REQUIRE(holds.size() == 3);
  CHECK((holds[0].first == 1 && holds[0].end == 21 && holds[0].rose));
  CHECK((holds[1].first == 21 && holds[1].end == 42 && !holds[1].rose));
  CHECK((holds[2].first == 42 && holds[2].end == 62 && holds[2].rose));
  CHECK(holds[1].held_s(several, 25) == Approx(10.0));  // 2 s and four frames of 2 s
}

TEST_CASE("creep: slope per decade and its uncertainty are relative to the first output") {
  // 2 V, and 1 mV more and less in turn about 20 mV a decade: what the line leaves is worked out by its normal
  // equations.
  std::vector<double> volts, x;
  for (int i = 0; i < 24; ++i) {
    x.push_back(std::log10(2.0 + 2.0 * i));
    volts.push_back(2.0 + 0.02 * (x.back() - x.front()) + (i == 0 ? 0.0 : i % 2 == 0 ? 0.001 : -0.001));
  }
  double sx = 0, sy = 0, sxx = 0, sxy = 0, rest = 0;
  for (std::size_t i = 0; i < 24; ++i) {
    sx += x[i];
    sy += volts[i];
    sxx += x[i] * x[i];
    sxy += x[i] * volts[i];
  }
  const double spread = sxx - sx * sx / 24, slope = (sxy - sx * sy / 24) / spread, at_zero = (sy - slope * sx) / 24;
  for (std::size_t i = 0; i < 24; ++i) rest += std::pow(volts[i] - at_zero - slope * x[i], 2);
  Repeat repeat = held_at(50, {3.0});
  append_to(repeat, held_at(40, volts));
  const std::vector<Creep> found = creep_of(holding(repeat), {0, 1});
  REQUIRE(found.size() == 1);
  CHECK((found[0].run == 2 && found[0].sequence == "creep-hold" && found[0].samples == 24));
  CHECK_FALSE(found[0].up);
  CHECK(found[0].per_decade == Approx(slope / 2.0));
  CHECK(found[0].per_decade_u == Approx(std::sqrt(rest / 22 / spread) / 2.0));
  CHECK((found[0].from_s == Approx(2.0) && found[0].to_s == Approx(48.0)));
  // Of a falling output the uncertainty is positive, and the share counts by its sign.
  for (double& own : volts) own = -own;
  const Creep turned = creep_of(holding(held_at(40, volts)), {0}).front();
  CHECK(turned.per_decade == Approx(slope / 2.0));
  CHECK(turned.per_decade_u == Approx(found[0].per_decade_u));
  CHECK(creep_of(holding(held_at(40, std::vector<double>(20, 0.0))), {0}).empty());  // a share of nothing
  // A run without a full sweep has creep, but no loop.
  const Behaviour b = behaviour_of(holding(held_at(40, volts)), {0});
  CHECK((b.loops.empty() && b.zero_returns.empty() && b.creep.size() == 1));
}
