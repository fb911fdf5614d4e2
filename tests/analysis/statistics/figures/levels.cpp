// Every figure of the levels of a loop by hand: two taxels that count, one that does not, readings of which some are
// flat.
#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/statistics/figures/levels.h"
#include "analysis/statistics/figures/reading_errors.h"
#include "tests/analysis/support/alike.h"
#include "tests/analysis/support/straight_array.h"

using namespace straight_array;

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

struct KindOf {
  bool full, up;
  int branch;
};
void check_kinds(const std::vector<double>& setpoints, double low, double high, const std::vector<KindOf>& expected) {
  const std::vector<StepKind> kinds = step_kinds(set_points_alone(setpoints), low, high);
  REQUIRE(kinds.size() == expected.size());
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    INFO("step " << i);
    CHECK((kinds[i].full == expected[i].full && kinds[i].up == expected[i].up));
    CHECK(kinds[i].branch == expected[i].branch);
  }
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
  check_kinds({0, 20, 40, 60, 40, 20, 40, 0, 60}, 0, 60,
              {{true, true, 0},
               {true, true, 0},
               {true, true, 0},
               {true, true, 0},
               {false, false, 1},
               {false, false, 1},
               {false, true, 2},
               {false, false, 3},
               {true, true, 4}});
  check_kinds({60, 0, 0, 30}, 0, 60, {{true, false, 0}, {true, false, 0}, {true, false, 0}, {false, true, 1}});
  check_kinds({20, 20}, 0, 60, {{false, true, 0}, {false, true, 0}});  // no branch at all
  CHECK(step_kinds({"none", {}}, 0, 60).empty());
}

TEST_CASE("step kinds: a branch is full if both ends are within 1 % of the range, in either direction") {
  for (const bool turned : {false, true}) {
    const auto full = [turned](double bottom, double top, double low, double high) {
      return turned ? is_full(top, bottom, low, high) : is_full(bottom, top, low, high);
    };
    CHECK(full(0.59, 59.41, 0, 60));
    CHECK_FALSE(full(0.61, 60, 0, 60));
    CHECK_FALSE(full(0, 59.39, 0, 60));
    CHECK(full(10.49, 59.51, 10, 60));  // of a range of 50 psi
    CHECK_FALSE(full(10.51, 60, 10, 60));
    CHECK_FALSE(full(10, 59.49, 10, 60));
    CHECK(full(-5, 65, 0, 60));
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
  CHECK(readings_at(20.0) == 1);
  CHECK(readings_at(20.0 + 5e-7) == 1);
  CHECK(readings_at(20.0 - 5e-7) == 1);
  CHECK(readings_at(20.0 + 2e-6) == 0);
  CHECK(readings_at(20.0 - 2e-6) == 0);
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
  const auto sweeps_of = [](double from, double to) {
    try {
      return sweep_estimates(dataset_of({{"s", {one_way({from, 30, to}, {0, 0, 0})}}}), straight_fit(), 1).sweeps;
    } catch (const AnalysisError& error) {
      CHECK(error.id() == "TB-ANALYSIS-NO-LOOP");
      return 0;
    }
  };
  CHECK(sweeps_of(0.59, 59.41) == 1);
  CHECK(sweeps_of(60, 0) == 0);
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
