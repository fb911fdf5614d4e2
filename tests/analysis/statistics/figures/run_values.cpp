// Figures that are followed from run to run, the taxels a report shows, usable ranges and creep to their bounds: by
// hand.

#include <catch2/catch.hpp>

#include <cmath>
#include <stdexcept>

#include "analysis/identify/histories.h"
#include "analysis/statistics/figures/behaviour.h"
#include "analysis/statistics/figures/evaluation.h"
#include "analysis/statistics/figures/levels.h"
#include "analysis/statistics/figures/reading_errors.h"
#include "analysis/statistics/figures/time_effects.h"
#include "analysis/statistics/numbers/moments.h"
#include "tests/analysis/support/alike.h"
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

TEST_CASE("taxel gains: refer to the level nearest to two thirds of the range, the lower of two equally near") {
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

// Every figure of the levels of a loop by hand: two taxels that count, one that does not, readings of which some are
// flat.

namespace {

TaxelTable up_and_down(std::vector<double> values) {
  return {{0, 30, 60, 30, 0}, std::move(values), {{0, 2, true}, {2, 4, false}}};
}

// Up over three levels and down; of each step the first taxel, the second and the dead one.
CompensatedStreams three_levels() {
  CompensatedSequence own;
  own.raw = up_and_down({0, 0, 9, 1, 2, 9, 3, 5, 9, 2, 3, 9, 0.5, 0.1, 9});
  own.pressure = up_and_down({0, 0, 7, 30, 30, 7, 60, 60, 7, 33, 30.6, 7, 0, 1.2, 7});
  own.flat = up_and_down({0, 0, 0, 0, 0, 0, 0.5, 0, 0, 0.4, 0, 0, 1, 0, 0});
  own.reference_psi = {0.1, 30.2, 60.3, 29.8, 0.2};
  return {{own}, {}};
}

}  // namespace

TEST_CASE("level statistics: distances, spreads, flat taxels and worst taxels match hand-computed values") {
  Evaluation e;
  gather_levels(e, three_levels(), Fitted(straight_fit()));
  CHECK(e.full_scale_psi == 60.0);
  CHECK(e.full_scale_v == 4.0);  // of 3 and 5 V
  REQUIRE(e.levels.size() == 3);
  const LevelFigures &low = e.levels[0], &middle = e.levels[1], &high = e.levels[2];
  CHECK((low.pressure_psi == 0.0 && low.up_psi == 0.1 && low.down_psi == 0.2));
  CHECK((middle.pressure_psi == 30.0 && middle.up_psi == 30.2 && middle.down_psi == 29.8));
  check_alike(middle.raw_up_v, {1, 2, 9}, 1e-12);
  check_alike(middle.raw_down_v, {2, 3, 9}, 1e-12);
  check_alike(middle.comp_up_psi, {30, 30, kNan}, 1e-12);
  check_alike(middle.comp_down_psi, {33, 30.6, kNan}, 1e-12);
  // Of two values the standard deviation is their difference over the root of 2.
  CHECK(middle.raw_std_up == Approx(1.0 / std::sqrt(2.0) / 4.0));
  CHECK(low.raw_std_down == Approx(0.4 / std::sqrt(2.0) / 4.0));
  CHECK(middle.comp_std_up == Approx(0.0).margin(1e-12));
  CHECK(middle.comp_std_down == Approx(2.4 / std::sqrt(2.0) / 60.0));
  CHECK(middle.raw_mean_distance == Approx(1.0 / 4.0));
  CHECK(low.raw_mean_distance == Approx(0.3 / 4.0));
  CHECK(middle.comp_mean_distance == Approx(1.8 / 60.0));
  CHECK(middle.raw_distance == Approx(1.0 / 4.0));
  CHECK(middle.comp_distance == Approx(1.8 / 60.0));
  CHECK(low.comp_distance == Approx(0.6 / 60.0));
  CHECK(middle.worst_taxel_distance == Approx(3.0 / 60.0));
  CHECK(low.worst_taxel_distance == Approx(1.2 / 60.0));
  // Going down the first taxel is flat at 0 psi, and at 60, where half of the sweeps are.
  CHECK((low.flat_taxels == 1 && middle.flat_taxels == 0 && high.flat_taxels == 1));
  CHECK(low.comp_distance_observable == Approx(1.2 / 60.0));
  CHECK(middle.comp_distance_observable == Approx(1.8 / 60.0));
  CHECK(middle.worst_taxel_distance_observable == Approx(3.0 / 60.0));
  CHECK_FALSE((low.made_worse || middle.made_worse || high.made_worse));
  // Over the levels.
  CHECK(e.hysteresis_max_fs == Approx(1.0 / 4.0));
  CHECK(e.hysteresis_mean_fs == Approx(1.3 / 12.0));
  CHECK(e.raw_distance == Approx(1.3 / 12.0));
  CHECK(e.comp_distance_of_mean == Approx(2.4 / 180.0));
  CHECK(e.comp_distance == Approx(2.4 / 180.0));
  CHECK(e.flat_share == Approx(2.0 / 6.0));
  // The first taxel's 3 psi at one of three levels, the only one where it is not flat.
  CHECK(e.worst_taxel_distance == Approx(3.0 / 180.0));
  CHECK(e.worst_taxel_distance_observable == Approx(3.0 / 60.0));
  CHECK(e.comp_distance_observable == Approx((3.0 + 1.2 + 0.6) / 60.0 / 4.0));
}

TEST_CASE("level statistics: if all taxels are flat no distance is observable, and a worse result is marked") {
  CompensatedStreams streams = three_levels();
  streams.sequences[0].flat.values.assign(15, 1.0);
  streams.sequences[0].pressure.values[9] = 50.0;  // 20 psi against a quarter of full scale
  streams.sequences[0].pressure.values[10] = 45.0;
  Evaluation e;
  gather_levels(e, streams, Fitted(straight_fit()));
  CHECK(std::isnan(e.comp_distance_observable));
  CHECK(e.worst_taxel_distance_observable == 0.0);
  CHECK(e.flat_share == 1.0);
  CHECK(e.levels[1].comp_distance == Approx(17.5 / 60.0));
  CHECK(e.levels[1].made_worse);
  CHECK(e.levels[1].comp_distance_observable == 0.0);
  // Of one taxel at one level all that is observed is its distance.
  streams.sequences[0].flat.values[9] = 0.0;
  Evaluation one;
  gather_levels(one, streams, Fitted(straight_fit()));
  CHECK(one.comp_distance_observable == Approx(20.0 / 60.0));
  CHECK(one.worst_taxel_distance_observable == Approx(20.0 / 60.0));
  CHECK(one.flat_share == Approx(5.0 / 6.0));
}

TEST_CASE("level statistics: a single taxel has no spread") {
  SensorModel fit = straight_fit();
  fit.taxels[1].status = TaxelStatus::kDead;
  Evaluation e;
  gather_levels(e, three_levels(), Fitted(fit));
  CHECK(e.full_scale_v == 3.0);
  for (const LevelFigures& level : e.levels) {
    CHECK((level.raw_std_up == 0.0 && level.raw_std_down == 0.0));
    CHECK((level.comp_std_up == 0.0 && level.comp_std_down == 0.0));
  }
  CHECK(e.levels[1].comp_distance == Approx(3.0 / 60.0));
}

// Where steps stand in their history, and what full sweeps of straight taxels read at each level: by hand.

namespace {

SequenceData set_points_alone(const std::vector<double>& setpoints) {
  Repeat repeat;
  for (const double psi : setpoints) repeat.steps.push_back({psi, psi});
  return {"s", {repeat}};
}

// Of each step its branch and U or D, in lower case where the branch is not full.
std::string kinds_of(const std::vector<double>& setpoints, double low = 0.0, double high = 60.0) {
  std::string kinds;
  for (const StepKind& kind : step_kinds(set_points_alone(setpoints), low, high))
    kinds += std::to_string(kind.branch) + (kind.up ? (kind.full ? "U " : "u ") : (kind.full ? "D " : "d "));
  return kinds;
}

bool is_full(double from, double to, double low = 0.0, double high = 60.0) {
  return step_kinds(set_points_alone({from, to}), low, high)[1].full;
}

// One way along the set-points; the first taxel reads `error` more at each step than the reference, the second half of
// that, and the reference stands `off` over the set-point everywhere but at the range's ends.
Repeat one_way(const std::vector<double>& setpoints, const std::vector<double>& error, double off = 0.0) {
  std::vector<Sample> steps;
  Readings readings;
  for (std::size_t i = 0; i < setpoints.size(); ++i) {
    const bool end = setpoints[i] == 0.0 || setpoints[i] == kFullPsi;
    steps.push_back({setpoints[i], setpoints[i] + (end ? 0.0 : off)});
    readings.first_psi.push_back(steps.back().reference_psi + error[i]);
    readings.second_psi.push_back(steps.back().reference_psi + 0.5 * error[i]);
  }
  return repeat_of(steps, readings);
}

}  // namespace

TEST_CASE("step kinds: a turning point belongs to the branch that ends there, the first step to the first branch") {
  CHECK(kinds_of({0, 20, 40, 60, 40, 20, 40, 0, 60}) == "0U 0U 0U 0U 1d 1d 2u 3d 4U ");
  CHECK(kinds_of({60, 0, 0, 30}) == "0D 0D 0D 1u ");
  CHECK(kinds_of({20, 20}) == "0u 0u ");  // no branch at all
  CHECK(step_kinds({"none", {}}, 0, 60).empty());
}

TEST_CASE("step kinds: a branch, up or down, is full if it begins and ends within 1 % of the range's ends") {
  for (const bool turned : {false, true}) {
    const auto full = [turned](double bottom, double top, double low, double high) {
      return turned ? is_full(top, bottom, low, high) : is_full(bottom, top, low, high);
    };
    const std::initializer_list<std::tuple<double, double, double, bool>> rows = {
        {0.59, 59.41, 0, true}, {0.61, 60, 0, false},   {0, 59.39, 0, false}, {10.49, 59.51, 10, true},  // of 50 psi
        {10.51, 60, 10, false}, {10, 59.49, 10, false}, {-5, 65, 0, true}};
    for (const auto& [bottom, top, low, whole] : rows) CHECK(full(bottom, top, low, 60) == whole);
  }
}

TEST_CASE("sweep errors: readings of each level come in time order, with the group of their sweep") {
  const std::vector<double> loop{0, 20, 40, 60, 40, 20, 0}, rough{0, 20, 60, 20, 0}, inner{0, 20, 40, 20, 0};
  const Dataset data =
      dataset_of({{"inner", {one_way(inner, {0, 9, 9, 9, 0})}},
                  {"loop", {one_way(loop, {0, 1, 2, 0, 4, 5, 0}), one_way(loop, {0, 6, 7, 0, 8, 9, 0})}},
                  {"rough", {one_way(rough, {0, 3, 0, 2, 0})}}});
  const SweepErrors errors = sweep_errors(data, straight_fit(), 1);
  CHECK(errors.groups == 4);
  REQUIRE(errors.levels.size() == 8);
  struct Expected {
    std::vector<double> first;
    std::vector<int> group;
  };
  // Levels up, then down. The turn at 60 psi closes the way up.
  const std::vector<Expected> expected{
      {{0, 0, 0}, {0, 0, 2}}, {{1, 6, 3}, {0, 0, 2}}, {{2, 7}, {0, 0}}, {{0, 0, 0}, {0, 0, 2}},
      {{0, 0, 0}, {1, 1, 3}}, {{5, 9, 2}, {1, 1, 3}}, {{4, 8}, {1, 1}}, {{}, {}}};
  for (std::size_t at = 0; at < 8; ++at) {
    INFO("level " << at);
    const LevelReadings& level = errors.levels[at];
    CHECK(level.pressure_psi == straight_array::kLevels[at % 4]);
    CHECK(level.up == (at < 4));
    REQUIRE(level.readings == expected[at].first.size());
    CHECK(level.group == expected[at].group);
    REQUIRE(level.error_psi.size() == 3 * level.readings);
    for (std::size_t i = 0; i < level.readings; ++i) {
      CHECK(level.error_psi[3 * i] == Approx(expected[at].first[i]).margin(1e-9));
      CHECK(level.error_psi[3 * i + 1] == Approx(0.5 * expected[at].first[i]).margin(1e-9));
      CHECK(std::isnan(level.error_psi[3 * i + 2]));
    }
  }
  CHECK(errors.repeats_with_zero == 4);
}

TEST_CASE("sweep errors: a set-point matches a level within 1e-6 psi, and a zero return needs three steps") {
  const auto readings_at = [](double psi) {
    return sweep_errors(dataset_of({{"s", {one_way({0, psi, 60}, {0, 1, 0})}}}), straight_fit(), 1).levels[1].readings;
  };
  for (const auto& [off, readings] : {std::pair(0.0, 1U), {5e-7, 1U}, {-5e-7, 1U}, {2e-6, 0U}, {-2e-6, 0U}})
    CHECK(readings_at(20.0 + off) == readings);
  const auto zeros = [](const std::vector<double>& setpoints) {
    const Repeat repeat = one_way(setpoints, std::vector<double>(setpoints.size(), 0.0));
    return sweep_errors(dataset_of({{"s", {repeat}}}), straight_fit(), 1).repeats_with_zero;
  };
  CHECK(zeros({0, 20, 0}) == 1);
  CHECK(zeros({0, 0}) == 0);
  const SweepErrors once = sweep_errors(dataset_of({{"s", {one_way({0, 20, 0}, {0, 0, 2})}}}), straight_fit(), 1);
  CHECK(once.zero_return_v[0] == Approx(0.1));  // 2 psi of 20 psi a volt
  CHECK(once.zero_return_v[1] == Approx(0.1));  // 1 psi of 10
  CHECK(once.zero_return_s_v[0] == 0.0);
  CHECK(std::isnan(sweep_errors(dataset_of({{"s", {one_way({20, 40}, {0, 0})}}}), straight_fit(), 1).zero_return_v[0]));
}

TEST_CASE("sweep estimates: use equal full loading sweeps, moved to the set-points, and their mean") {
  // Twice up in a repeat, the second time right from the turn at 0 psi; another sequence has other levels.
  const std::vector<double> twice{0, 20, 40, 60, 0, 20, 40, 60};
  Dataset data = dataset_of(
      {{"down", {one_way({60, 40, 0}, {0, 9, 0})}},
       {"coarse", {one_way({5, 30, 60}, {0, 9, 0})}},
       {"twice", {one_way(twice, {0, 1, 2, 0, 0, 4, 5, 0}, 0.5), one_way(twice, {0, -1, -2, 0, 0, 7, 8, 0}, -0.25)}},
       {"other", {one_way({0, 30, 60}, {0, 9, 0})}}});
  const SweepEstimates found = sweep_estimates(data, straight_fit(), 1);
  CHECK(found.pressure_psi == straight_array::kLevels);
  CHECK(found.sweeps == 4);
  CHECK(found.taxels == 3);
  REQUIRE(found.psi.size() == 4 * 4 * 3);
  const double errors[4][4] = {{0, 1, 2, 0}, {0, 4, 5, 0}, {0, -1, -2, 0}, {0, 7, 8, 0}};
  for (std::size_t level = 0; level < 4; ++level) {
    double sum = 0.0;
    for (int sweep = 0; sweep < 4; ++sweep) {
      INFO("level " << level << ", sweep " << sweep);
      const double expected = straight_array::kLevels[level] + errors[sweep][level];
      CHECK(found.at(level, sweep, 0) == Approx(expected).margin(1e-9));
      CHECK(found.at(level, sweep, 1) ==
            Approx(straight_array::kLevels[level] + 0.5 * errors[sweep][level]).margin(1e-9));
      CHECK(std::isnan(found.at(level, sweep, 2)));
      sum += expected;
    }
    CHECK(found.mean(level, 0) == Approx(sum / 4).margin(1e-9));
  }
  // A sensor whose output falls reads the same.
  for (SequenceData& sequence : data.sequences)
    for (Repeat& repeat : sequence.repeats)
      for (double& volts : repeat.volts) volts = -volts;
  SensorModel falling = straight_fit();
  falling.falling = true;
  CHECK(sweep_estimates(data, falling, 1).mean(1, 0) == Approx(found.mean(1, 0)));
}

TEST_CASE("sweep estimates: a run without a full loading sweep is refused") {
  const auto estimates = [](double from, double to) {
    return sweep_estimates(dataset_of({{"s", {one_way({from, 30, to}, {0, 0, 0})}}}), straight_fit(), 1);
  };
  CHECK(estimates(0.59, 59.41).sweeps == 1);
  CHECK(id_of_refusal([&] { return estimates(60, 0); }) == "TB-ANALYSIS-NO-LOOP");
  Dataset other = dataset_of({{"s", {one_way({0, 30, 60}, {0, 0, 0})}}});
  other.sensor_serial = "T";
  CHECK_THROWS_AS(sweep_estimates(other, straight_fit(), 1), AnalysisError);
}

TEST_CASE("compensated streams: error sums, maxima and means of the repeats match hand-computed values") {
  const Dataset data =
      dataset_of({{"s", {one_way({0, 20, 40, 0}, {0, 1, -4, 0}, 0.5), one_way({0, 20, 40, 0}, {0, 3, 4, 0}, 0.5)}}});
  const CompensatedStreams streams = compensate_all(data, straight_fit(), 1);
  const TaxelErrors& first = streams.errors[0];
  CHECK(first.frames == 8);
  CHECK(first.observable == 8);
  CHECK(first.sum_psi == Approx(1 + 4 + 3 + 4));
  CHECK(first.max_psi == Approx(4.0));
  CHECK(first.max_at_psi == Approx(40.5));
  CHECK(first.max_observable_psi == Approx(4.0));
  CHECK(streams.errors[2].frames == 0);
  const CompensatedSequence& sequence = streams.sequences.front();
  CHECK(sequence.reference_psi[1] == Approx(20.5));
  CHECK(sequence.unmoved_psi[3] == Approx(22.5));      // 21.5 and 23.5
  CHECK(sequence.pressure.values[3] == Approx(22.0));  // moved by half a psi to the set-point
  CHECK(sequence.pressure.values[4] == Approx(21.0));
  CHECK(sequence.flat.values[3] == 0.0);
}
