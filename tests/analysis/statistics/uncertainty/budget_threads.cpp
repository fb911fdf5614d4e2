// Each row of a budget that this run, its record and its studies tell, on taxels that are straight lines: by hand.
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "analysis/statistics/numbers/moments.h"
#include "tests/analysis/support/straight_array.h"
#include "tests/analysis/support/uncertainty_example.h"

using namespace tactbench;
using namespace straight_array;
using uncertainty_example::known_row;
using uncertainty_example::row_of;

namespace {

// Of the levels 0, 20, 40, 60 psi up, then down.
constexpr std::size_t kLowestUp = 0, kTwentyUp = 1, kFortyUp = 2, kHighestUp = 3, kFortyDown = 6;
const std::vector<double> kUpAndDown{0, 20, 40, 60, 40, 20, 0};

// Two repeats up and down that read the reference exactly, by a scanner of `scans` scans per frame.
StraightBudget exact_budget(int scans = 1) {
  std::vector<Sample> steps;
  for (const double level : kUpAndDown) steps.push_back({level, level, 0.0, 1.0});
  const Repeat repeat = repeat_of(steps, {kUpAndDown, kUpAndDown});
  StraightBudget made({{"loop", {repeat, repeat}}});
  made.calibration.scans = scans;
  made.errors.repeats_with_zero = 0;
  return made;
}

double u_of(const Budget& budget, UncertaintySource source) {
  const Contribution* const row = row_of(budget, source);
  return row == nullptr ? kNan : row->u_psi;
}

}  // namespace

TEST_CASE("noise row: is that of a frame's mean times the sensitivity, with degrees of freedom from the scans") {
  StraightBudget made = exact_budget(3);
  made.calibration.noise_v = {0.001, 0.004, 0.0};
  const BudgetMaker maker = made.maker();
  const Budget budget = maker.budget(0, kFortyUp);
  const Contribution& row = known_row(budget, UncertaintySource::kNoise);
  CHECK(row.width == 0.001);
  CHECK(row.divisor == 1.0);
  CHECK(row.sensitivity == Approx(20.0));
  CHECK(row.u_psi == Approx(0.02));
  CHECK(row.dof == 28.0);  // 14 frames, two of the three scans each
  CHECK(row.common == 0.0);
  CHECK(u_of(maker.budget(1, kFortyDown), UncertaintySource::kNoise) == Approx(0.04));
  CHECK(maker.missing()[static_cast<std::size_t>(UncertaintySource::kNoise)].empty());
  StraightBudget one = exact_budget(1);
  one.calibration.noise_v = {0.001, 0.004, 0.0};
  CHECK(std::isnan(u_of(one.maker().budget(0, kFortyUp), UncertaintySource::kNoise)));
  CHECK_FALSE(one.maker().missing()[static_cast<std::size_t>(UncertaintySource::kNoise)].empty());
}

TEST_CASE("converter row: is rectangular with half a count to each side") {
  const StraightBudget made = exact_budget();
  const BudgetMaker maker(made.calibration, made.fit, made.errors, made.reference, 0.004, made.inputs, 1);
  const Budget budget = maker.budget(0, kFortyUp);
  const Contribution& row = known_row(budget, UncertaintySource::kConverterStep);
  CHECK(row.width == 0.002);
  CHECK(row.divisor == Approx(std::sqrt(3.0)));
  CHECK(row.u_psi == Approx(0.04 / std::sqrt(3.0)));
  CHECK_FALSE(made.maker().missing()[static_cast<std::size_t>(UncertaintySource::kConverterStep)].empty());
}

TEST_CASE("zero return row: combines the mean return with its scatter, less the noise of the frames") {
  StraightBudget made = exact_budget();
  made.calibration.noise_v = {0.001, 0.001, 0.0};
  made.errors.repeats_with_zero = 4;
  made.errors.zero_return_v = {0.003, 0.0005, kNan};
  made.errors.zero_return_s_v = {0.002, 0.001, kNan};
  const BudgetMaker maker = made.maker();
  // mV^2. Two frames have a noise of 2: the first (9 - 2 / 4) / 3 + (4 - 2) / 4; the second has less than its noise.
  const Budget budget = maker.budget(0, kFortyUp);
  const Contribution& row = known_row(budget, UncertaintySource::kZeroReturn);
  CHECK(row.width == Approx(0.001 * std::sqrt(8.5 / 3.0 + 0.5)));
  CHECK(row.divisor == 1.0);
  CHECK(row.u_psi == Approx(0.02 * std::sqrt(8.5 / 3.0 + 0.5)));
  CHECK(row.dof == 3.0);
  CHECK(u_of(maker.budget(1, kFortyUp), UncertaintySource::kZeroReturn) == 0.0);
  made.errors.repeats_with_zero = 1;
  CHECK(row_of(made.maker().budget(0, kFortyUp), UncertaintySource::kZeroReturn)->dof == 1.0);
  CHECK(row_of(made.maker().budget(0, kFortyUp), UncertaintySource::kZeroReturn)->width ==
        Approx(0.001 * std::sqrt(7.0 / 3.0 + 2.0)));
}

TEST_CASE("creep row: half of the creep is a known error, positive up and negative down") {
  StraightBudget made = exact_budget();
  const HeldLevel held{.sequence = "hold", .pressure_psi = 40.0, .share = {0.1, 0.2, kNan}};
  made.inputs.creep.levels = {held};
  made.inputs.creep.not_assessed.clear();
  const BudgetMaker maker = made.maker();
  // A tenth of 2 V over the zero: 0.1 V to each side of 0.1 V, 2 psi.
  const Budget up = maker.budget(0, kFortyUp), down = maker.budget(0, kFortyDown);
  const Contribution& row = known_row(up, UncertaintySource::kCreep);
  CHECK(row.width == Approx(0.1));
  CHECK(row.u_psi == Approx(2.0 / std::sqrt(3.0)));
  CHECK(row.common == 1.0);
  CHECK(up.error_psi == Approx(2.0));
  CHECK(down.error_psi == Approx(-2.0));
  CHECK(maker.budget(1, kFortyUp).error_psi == Approx(4.0));  // 0.2 of 4 V: 0.4 V of 10 psi a volt, half of it
}

TEST_CASE("temperature row: is rectangular with the coefficient times half the range, in volts") {
  StraightBudget made = exact_budget();
  made.inputs.temperature.not_assessed.clear();
  made.inputs.temperature.per_kelvin = {0.001, 0.002};
  made.inputs.temperature.low_c = 20.0;
  made.inputs.temperature.high_c = 24.0;
  // 2 V over the zero: 1 + 4 mV a kelvin, for 2 K: 10 mV, 0.2 psi.
  const BudgetMaker maker = made.maker();
  const Budget budget = maker.budget(0, kFortyUp);
  const Contribution& row = known_row(budget, UncertaintySource::kTemperature);
  CHECK(row.width == Approx(0.01));
  CHECK(row.divisor == Approx(std::sqrt(3.0)));
  CHECK(row.sensitivity == Approx(20.0));
  CHECK(row.u_psi == Approx(0.2 / std::sqrt(3.0)));
  CHECK(row.common == 1.0);
  CHECK(row_of(made.maker().budget(0, kLowestUp), UncertaintySource::kTemperature)->width == Approx(0.002));
}

TEST_CASE("study rows: add psi and share, as a part common to all taxels or of each taxel") {
  StraightBudget made = exact_budget();
  made.inputs.uniformity = GivenUncertainty{0.3, 0.01, 27.0, "turned"};
  made.inputs.mounting = GivenUncertainty{0.0, 0.02, 3.0, "mounts"};
  made.inputs.mounting_per_taxel = GivenUncertainty{0.6, 0.0, 9.0, "mounts"};
  const BudgetMaker maker = made.maker();
  const Budget stated = maker.budget(0, kFortyUp);
  CHECK(u_of(stated, UncertaintySource::kUniformity) == Approx(0.5));  // 0.3 and 1 % of 40 psi
  CHECK(row_of(stated, UncertaintySource::kUniformity)->dof == 27.0);
  CHECK(row_of(stated, UncertaintySource::kUniformity)->common == 0.0);
  CHECK(u_of(stated, UncertaintySource::kMounting) == Approx(0.8));
  CHECK(row_of(stated, UncertaintySource::kMounting)->dof == 3.0);
  CHECK(row_of(stated, UncertaintySource::kMounting)->common == 1.0);
  CHECK(u_of(stated, UncertaintySource::kMountingPerTaxel) == Approx(0.6));
  CHECK(row_of(stated, UncertaintySource::kMountingPerTaxel)->dof == 9.0);
  CHECK(row_of(stated, UncertaintySource::kMountingPerTaxel)->common == 0.0);
  // 0.25 + 0.64 + 0.36 psi^2; degrees by Welch and Satterthwaite.
  CHECK(stated.combined_psi == Approx(std::sqrt(1.25)));
  CHECK(stated.dof == Approx(1.5625 / (0.0625 / 27 + 0.4096 / 3 + 0.1296 / 9)));
  CHECK(stated.factor == Approx(2.23).margin(0.07));  // ten degrees of freedom: 2.28 (GUM, Table G.2)
  CHECK(stated.expanded_psi == Approx(stated.factor * stated.combined_psi));
  CHECK((stated.taxel == 0 && stated.pressure_psi == 40.0 && stated.up && stated.readings == 2));
}

TEST_CASE("budget: is not linear at an end of the curve or a slope change by a quarter, if voltage matters") {
  StraightBudget made = exact_budget(2);
  made.calibration.noise_v = {0.001, 0.001, 0.0};
  CHECK(made.maker().budget(0, kFortyUp).linear);
  CHECK_FALSE(made.maker().budget(0, kLowestUp).linear);
  CHECK_FALSE(made.maker().budget(0, kHighestUp).linear);
  // Next to something else that has nine tenths of the variance the voltage does not count: 0.0004 psi^2 of it, beside
  // half as much of the mean of two readings and 0.0034 of the rest.
  made.inputs.uniformity = GivenUncertainty{0.0582, 0.0, kInfiniteDof, ""};
  CHECK_FALSE(made.maker().budget(0, kLowestUp).linear);
  made.inputs.uniformity->psi = 0.0584;
  CHECK(made.maker().budget(0, kLowestUp).linear);
  made.inputs.uniformity.reset();
  // 20 psi a volt below 40 psi, and above it 5 / 3 as much: a quarter of the middle to each side.
  const auto bent = [&](double times) {
    StraightBudget own = made;
    const std::vector<double> volts{0.0, 1.0, 2.0, 2.0 + 1.0 / times};
    const PatternCurve curve(straight_array::kLevels, volts, 0.0, volts.back());
    own.fit.taxels[0] = by_hand::elam_taxel(curve, curve);
    own.fit.taxels[0].taxel = 0;
    own.fit.taxels[0].fit.model = std::make_shared<ElamHysteresis>(ElamModel{curve, curve, {}, {true}});
    const Budget budget = own.maker().budget(0, kFortyUp);
    CHECK(row_of(budget, UncertaintySource::kNoise)->sensitivity == Approx(10.0 * (1.0 + times)));
    return budget.linear;
  };
  CHECK(bent(1.65));
  CHECK_FALSE(bent(1.68));
  CHECK(bent(0.61));
  CHECK_FALSE(bent(0.59));
}

TEST_CASE("budget: each source that a bare run does not provide is reported as missing") {
  StraightBudget made = exact_budget();
  made.calibration.sequences[0].repeats.resize(1);
  made.errors = sweep_errors(made.calibration, made.fit, 1);
  made.errors.repeats_with_zero = 0;
  made.errors.groups = 1;
  const BudgetMaker maker = made.maker();
  const auto missing = [&](UncertaintySource source) { return maker.missing()[static_cast<std::size_t>(source)]; };
  for (const UncertaintySource source :
       {UncertaintySource::kCertificate, UncertaintySource::kUniformity, UncertaintySource::kRepeatability,
        UncertaintySource::kZeroReturn, UncertaintySource::kTemperature, UncertaintySource::kMounting,
        UncertaintySource::kMountingPerTaxel, UncertaintySource::kConditioning, UncertaintySource::kDwell,
        UncertaintySource::kHistory, UncertaintySource::kCreep}) {
    CAPTURE(static_cast<int>(source));
    CHECK_FALSE(missing(source).empty());
  }
  made.calibration.temperatures_c = {23.0};
  CHECK_FALSE(made.maker().missing()[static_cast<std::size_t>(UncertaintySource::kTemperature)].empty());
  made.errors.groups = 2;
  CHECK(made.maker().missing()[static_cast<std::size_t>(UncertaintySource::kConditioning)].empty());
}

TEST_CASE("U of an array: common parts count in full, taxels' parts over their number, the centre by these alone") {
  StraightBudget made = exact_budget();
  made.inputs.mounting = GivenUncertainty{0.3, 0.0, kInfiniteDof, "five mounts"};
  made.inputs.mounting_per_taxel = GivenUncertainty{0.4, 0.0, kInfiniteDof, "five mounts"};
  const Uncertainty found = assess_uncertainty(made.calibration, made.fit, {}, made.inputs, 1);
  // Two of three taxels in a row: 0.09 + 2 x 0.16 / 4. Their places are half a pitch from the middle: 2 x 0.16 / 4
  // psi^2 pitches^2, over the 80 psi of both.
  const LevelUncertainty* const forty = found.level(40.0, true);
  REQUIRE(forty != nullptr);
  CHECK(forty->array.mean_u_psi == Approx(std::sqrt(0.17)));
  CHECK(forty->array.mean_expanded_psi == Approx(2.0 * std::sqrt(0.17)));
  CHECK(forty->array.centre_expanded == Approx(2.0 * std::sqrt(0.08) / 80.0));
  CHECK(std::isnan(found.level(0.0, true)->array.centre_expanded));
  CHECK(forty->expanded_psi[0] == Approx(1.0));
  CHECK(std::isnan(forty->expanded_psi[2]));
  CHECK(forty->factor[1] == Approx(2.0));
  // 0 to 60 psi, the turn on the way up: the middle is 30 psi, going down 20 comes first.
  REQUIRE(found.levels.size() == 7);
  CHECK(found.levels[found.chosen].pressure_psi == 20.0);
  CHECK_FALSE(found.levels[found.chosen].up);
  CHECK(found.level(40.0000005, true) == forty);
  CHECK(found.level(40.000002, true) == nullptr);
  CHECK(found.level(60.0, false) == nullptr);
  CHECK(found.from[static_cast<std::size_t>(UncertaintySource::kMounting)] == "five mounts");
  CHECK(found.from[static_cast<std::size_t>(UncertaintySource::kMountingPerTaxel)] == "five mounts");
  CHECK(found.from[static_cast<std::size_t>(UncertaintySource::kUniformity)].empty());
  SensorModel none = made.fit;
  for (ModelTaxel& taxel : none.taxels) taxel.status = TaxelStatus::kDead;
  CHECK_THROWS_AS(assess_uncertainty(made.calibration, none, {}, {}, 1), AnalysisError);
}

TEST_CASE("U of a column array: the centre moves along it, the median is the lower and the worst the higher taxel") {
  StraightBudget made = exact_budget(2);
  made.calibration.rows = made.fit.rows = 3;
  made.calibration.columns = made.fit.columns = 1;
  // 0.1 psi of 20 psi a volt, 0.02 psi of 10; and of two readings' mean.
  made.calibration.noise_v = {0.005, 0.002, 0.0};
  const Uncertainty found = assess_uncertainty(made.calibration, made.fit, {}, {}, 1);
  const LevelUncertainty* const forty = found.level(40.0, true);
  CHECK(forty->array.centre_expanded == Approx(2.0 * std::sqrt(1.5 * (0.01 + 0.0004) / 4.0) / 80.0));
  CHECK(forty->median.taxel == 1);
  CHECK(forty->worst.taxel == 0);
  CHECK(forty->not_linear == 0);
  CHECK(found.level(0.0, true)->not_linear == 2);
}

// What taxels have in common of the scatter of sweeps, of held-out errors, and what is left where nothing scatters: by
// hand, on taxels that are straight lines.

namespace {

// Two repeats: the taxels are so much off in the first one, and as much to the other side in the second.
StraightBudget two_sides(double first_off, double second_off) {
  return StraightBudget(
      {{"loop", {offset_way(kUpAndDown, first_off, second_off), offset_way(kUpAndDown, -first_off, -second_off)}}});
}

// Of the mean of six readings in two groups.
double of_mean_of(double within, double between) { return within / 6.0 + between / 2.0; }

double common_of(const Budget& budget, UncertaintySource source) {
  const Contribution* const row = row_of(budget, source);
  return row == nullptr ? kNan : row->common;
}

}  // namespace

TEST_CASE("common scatter: is the variance of the array's mean over the mean variance of the taxels") {
  struct Case {
    double first, second, common;
  };
  for (const Case& each : {Case{0.1, 0.1, 1.0},      // alike
                           Case{0.1, -0.1, 0.0},     // against each other: the mean stands still
                           Case{0.2, 0.1, 0.9},      // means 0.15: 0.0225 over (0.04 + 0.01) / 2
                           Case{0.2, 0.0, 0.5},      // means 0.1: 0.01 over 0.02
                           Case{0.3, -0.1, 0.2}}) {  // means 0.1: 0.01 over 0.05
    CAPTURE(each.first, each.second);
    const StraightBudget made = two_sides(each.first, each.second);
    const BudgetMaker maker = made.maker();
    for (const std::size_t level : {kTwentyUp, kFortyUp, kFortyDown})
      for (const std::size_t taxel : {0U, 1U}) {
        const Budget budget = maker.budget(taxel, level);
        CHECK(common_of(budget, UncertaintySource::kRepeatability) == Approx(each.common).margin(1e-9));
        CHECK(common_of(budget, UncertaintySource::kModel) == Approx(each.common).margin(1e-9));
      }
    // At the ends nothing scatters.
    CHECK(common_of(maker.budget(0, 0), UncertaintySource::kRepeatability) == 0.0);
  }
}

TEST_CASE("common scatter: counts for groups of sweeps, too") {
  // Two sequences of two repeats each: groups of sweeps that differ by 0.4 and 0.2 psi.
  StraightBudget made({{"low", {offset_way(kUpAndDown, 0.1, 0.1), offset_way(kUpAndDown, -0.1, -0.1)}},
                       {"high", {offset_way(kUpAndDown, 0.5, 0.3), offset_way(kUpAndDown, 0.3, 0.1)}}});
  const BudgetMaker maker = made.maker();
  const Budget budget = maker.budget(0, kFortyUp);
  // Means of the array 0.1 -0.1 0.4 0.2: squares 0.13 about 0.15. Of the taxels 0.1 -0.1 0.5 0.3: 0.20 about 0.2; 0.1
  // -0.1 0.3 0.1: 0.08 about 0.1.
  CHECK(common_of(budget, UncertaintySource::kConditioning) == Approx(0.13 / 0.14));
  CHECK(common_of(budget, UncertaintySource::kRepeatability) == Approx(0.13 / 0.14));
  // Within: 0.02 and 0.02 of two degrees; between: 2 x 2 x 0.04 = 0.16 of one, less 0.02 within, over two readings.
  CHECK(row_of(budget, UncertaintySource::kRepeatability)->u_psi == Approx(std::sqrt(0.02)));
  CHECK(row_of(budget, UncertaintySource::kRepeatability)->dof == 2.0);
  CHECK(row_of(budget, UncertaintySource::kConditioning)->u_psi == Approx(std::sqrt(0.07)));
  CHECK(row_of(budget, UncertaintySource::kConditioning)->dof == 1.0);
  // The mean of four readings in two groups.
  CHECK(row_of(budget, UncertaintySource::kModel)->u_psi == Approx(std::sqrt(0.02 / 4 + 0.07 / 2)));
}

TEST_CASE("grouped readings: scatter within, between and of the mean match hand-computed values, less noise") {
  StraightBudget made = two_sides(0.0, 0.0);
  // Group 0 reads 1 and 3, group 2 5, 5, 7 and 7; no reading is of group 1. The second taxel reads half of it.
  const std::vector<double> first{1, 5, 3, 7, 5, 7};
  made.errors.groups = 3;
  for (LevelReadings& level : made.errors.levels) {
    level.readings = 6;
    level.group = {0, 2, 0, 2, 2, 2};
    level.error_psi.clear();
    for (const double error : first) level.error_psi.insert(level.error_psi.end(), {error, 0.5 * error, kNan});
  }
  // Within: 2 and 4 of four degrees, 1.5. Means 2 and 6 about 28 / 6: 2 x 64 / 9 + 4 x 16 / 9 = 64 / 3 of one degree;
  // a group counts as (6 - (4 + 16) / 6) = 8 / 3 readings.
  const double within = 1.5, between = (64.0 / 3.0 - 1.5) / (8.0 / 3.0);
  for (const std::size_t taxel : {0U, 1U}) {
    const double half = taxel == 0 ? 1.0 : 0.5;
    const Budget budget = made.maker().budget(taxel, kFortyUp);
    CHECK(budget.error_psi == Approx(half * 28.0 / 6.0));
    CHECK(budget.readings == 6);
    const Contribution *repeats = row_of(budget, UncertaintySource::kRepeatability),
                       *groups = row_of(budget, UncertaintySource::kConditioning),
                       *model = row_of(budget, UncertaintySource::kModel);
    REQUIRE((repeats != nullptr && groups != nullptr && model != nullptr));
    CHECK(repeats->u_psi == Approx(half * std::sqrt(within)));
    CHECK(repeats->dof == 4.0);
    CHECK(groups->u_psi == Approx(half * std::sqrt(between)));
    CHECK(groups->dof == 1.0);
    const double of_mean = of_mean_of(within, between);
    CHECK(model->u_psi == Approx(half * std::sqrt(of_mean)));
    CHECK(model->dof == Approx(of_mean * of_mean / (std::pow(within / 6.0, 2) / 4.0 + std::pow(between / 2.0, 2))));
    for (const Contribution* row : {repeats, groups, model}) CHECK(row->common == Approx(0.9));
  }
  // Noise of 2 psi is more than the scatter within: nothing is left of it, and the mean is known from the noise.
  made.calibration.scans = 3;
  made.calibration.noise_v = {0.1, 0.1, 0.0};
  const Budget noisy = made.maker().budget(0, kFortyUp);
  CHECK(row_of(noisy, UncertaintySource::kNoise)->u_psi == Approx(2.0));
  CHECK(row_of(noisy, UncertaintySource::kRepeatability)->u_psi == 0.0);
  CHECK(row_of(noisy, UncertaintySource::kModel)->u_psi == Approx(std::sqrt(4.0 / 6.0 + between / 2.0)));
  // Of 1 psi a third of the variance is left.
  made.calibration.noise_v = {0.05, 0.1, 0.0};
  CHECK(row_of(made.maker().budget(0, kFortyUp), UncertaintySource::kRepeatability)->u_psi == Approx(std::sqrt(0.5)));
  CHECK(row_of(made.maker().budget(0, kFortyUp), UncertaintySource::kModel)->u_psi ==
        Approx(std::sqrt(of_mean_of(within, between))));
}

TEST_CASE("budget: a level counts as linear as long as the voltage +- 2 u stays within the inverted curve") {
  StraightBudget made = two_sides(0.0, 0.0);
  made.calibration.scans = 2;
  const auto linear = [&](double noise_v, std::size_t level) {
    made.calibration.noise_v = {noise_v, 0.001, 0.0};
    return made.maker().budget(0, level).linear;
  };
  // 20 psi are 1 V above the curve's begin, 40 psi 1 V below its end.
  CHECK(linear(0.5, kTwentyUp));
  CHECK_FALSE(linear(0.50001, kTwentyUp));
  CHECK(linear(0.5, kFortyUp));
  CHECK_FALSE(linear(0.50001, kFortyUp));
}

TEST_CASE("uncertainty: a run without a full sweep has no level with U") {
  const StraightBudget made({{"inner", {offset_way({0, 20, 40, 20, 0}, 0.1, 0.1)}}});
  const Uncertainty found = assess_uncertainty(made.calibration, made.fit, {}, {}, 1);
  CHECK(found.levels.empty());
  CHECK(found.chosen == 0);
  CHECK(found.level(40.0, true) == nullptr);
}
