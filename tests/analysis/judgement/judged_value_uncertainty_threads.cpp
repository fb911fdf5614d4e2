// The uncertainty of judged figures against the same by hand.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/judgement/figure.h"
#include "tests/analysis/support/straight_array.h"

using namespace tactbench;
using namespace straight_array;  // and tactbench::analysis

namespace {

Figure figure_in(const std::vector<Figure>& all, Criterion criterion, const Scope& scope = {}) {
  for (const Figure& figure : all)
    if (figure.criterion == criterion && figure.scope == scope) return figure;
  FAIL("no such figure: " << to_string(criterion));
  return {};
}

ReferenceUncertainty certified(double expanded_psi) {
  ReferenceUncertainty reference;
  reference.reading_psi = {0.0, 60.0};
  reference.expanded_psi = {0.5 * expanded_psi, expanded_psi};
  reference.drift_missing = reference.resolution_missing = "not stated";
  return reference;
}

// Straight taxels; three repeats in which the first reads 25, 26 and 27 psi on its way down through 20 psi, and nothing
// else differs.
Dataset repeats_a_step_apart() {
  const std::vector<Sample> steps{{0, 0}, {20, 20}, {40, 41}, {60, 60}, {40, 40}, {20, 20}, {0, 0}};
  SequenceData sequence{"loop", {}};
  for (const double down : {25.0, 26.0, 27.0})
    sequence.repeats.push_back(repeat_of(steps, {{0, 20, 41, 60, 39, down, 0}, {0, 20, 41, 60, 43, 21, 0}}));
  return dataset_of({sequence});
}

}  // namespace

TEST_CASE("U of judged values: includes the reference in errors, the repeats in differences, and is 0 for a count") {
  // Three repeats, each with one full sweep up and down.
  const Dataset data = repeats_a_step_apart();
  const Evaluation evaluation = evaluate(data, straight_fit());
  const auto all = measured_figures(data, data, straight_fit(), evaluation, certified(0.2));
  REQUIRE(all.size() == 4 + 2 * 4);
  const auto known = [&](Criterion criterion, const Scope& scope = {}) { return figure_in(all, criterion, scope).u; };
  const double root3 = std::sqrt(3.0);
  // The first taxel's mean error rises by 1/7 psi per repeat, the second's not: pooled, s^2 = 1/98 psi^2, in equal
  // parts common (two degrees of freedom) and own (two): (1/98)^2 / (2 (1/196)^2 / 2) = 4 of them. Next to 0.1 psi of
  // the certificate: 4 (combined / u)^4, with u^2 = 1/294.
  const FigureUncertainty mean = known(Criterion::kMeanError), worst = known(Criterion::kWorstTaxelError);
  for (const FigureUncertainty& error : {mean, worst}) {
    CHECK(error.combined == Approx(std::hypot(0.1, 1.0 / 7.0 / std::sqrt(2.0) / root3)));
    CHECK(error.dof == Approx(4.0 * std::pow(1.0 + 0.01 * 294.0, 2)));
    CHECK(error.factor == Approx(2.04).margin(0.0055));  // Table G.2, between 50 and 100 degrees of freedom
    CHECK(error.expanded == Approx(error.factor * error.combined));
  }
  // Half a psi more of the mean at one of the three levels passed downward, of 60 psi; upward nothing moves. Pooled
  // over the levels: 0.5^2 / 3, of which a third is common; dof 2 / (1/9 + (4/9) / 2) = 6.
  const FigureUncertainty distance = known(Criterion::kDistanceOfMean);
  CHECK(distance.combined == Approx(0.5 / 60.0 / root3 / root3));
  CHECK(distance.dof == Approx(6.0));
  CHECK(distance.factor == Approx(2.52).margin(0.00501));  // six degrees of freedom
  // Two taxels 4, 5 and 6 psi apart: their standard deviation is that over sqrt 2.
  CHECK(known(Criterion::kMismatch, Scope::level(20, Direction::kDown)).combined ==
        Approx(1.0 / std::sqrt(2.0) / 60.0 / root3));
  CHECK(known(Criterion::kMismatch, Scope::level(20, Direction::kUp)).combined == Approx(0.0).margin(1e-12));
  CHECK(known(Criterion::kUnfitTaxels).expanded == 0.0);
  // The values are those of the evaluation.
  CHECK(figure_in(all, Criterion::kMeanError).value == evaluation.mean_error_psi);
  CHECK(figure_in(all, Criterion::kWorstTaxelError).value == evaluation.worst_taxel_mean_error_psi);
  CHECK(figure_in(all, Criterion::kDistanceOfMean).value == evaluation.comp_distance_of_mean);
  CHECK(figure_in(all, Criterion::kUnfitTaxels).value == 1.0);  // the dead one of three
  for (const LevelFigures& level : evaluation.levels) {
    CHECK(figure_in(all, Criterion::kMismatch, Scope::level(level.pressure_psi, Direction::kUp)).value ==
          level.comp_std_up);
    CHECK(figure_in(all, Criterion::kMismatch, Scope::level(level.pressure_psi, Direction::kDown)).value ==
          level.comp_std_down);
  }
}

TEST_CASE("U of judged values: input, zero and temperature of the reference enter errors, hysteresis distances too") {
  const Dataset data = repeats_a_step_apart();
  const Evaluation evaluation = evaluate(data, straight_fit());
  const auto combined = [&](const ReferenceUncertainty& reference, Criterion criterion) {
    return figure_in(measured_figures(data, data, straight_fit(), evaluation, reference), criterion).u.combined;
  };
  const ReferenceUncertainty bare = certified(0.02);
  for (const ReferencePart part :
       {ReferencePart::kVoltageInput, ReferencePart::kHysteresis, ReferencePart::kZero, ReferencePart::kTemperature}) {
    ReferenceUncertainty with = bare;
    with.limits[static_cast<std::size_t>(part)].half_width_psi = 0.3;
    CHECK(combined(with, Criterion::kMeanError) ==
          Approx(std::hypot(combined(bare, Criterion::kMeanError), 0.3 / std::sqrt(3.0))));
    // Too low going up and too high going down: twice the half-width, of 60 psi.
    const double apart = part == ReferencePart::kHysteresis ? 0.6 / 60.0 / std::sqrt(3.0) : 0.0;
    CHECK(combined(with, Criterion::kDistanceOfMean) ==
          Approx(std::hypot(combined(bare, Criterion::kDistanceOfMean), apart)));
  }
}

TEST_CASE("U of judged values: an error beyond the certificate has no U, a distance keeps its U") {
  const Dataset data = repeats_a_step_apart();
  ReferenceUncertainty reference = certified(0.02);
  reference.beyond = TraceabilityGap{.above = true};
  const auto all = measured_figures(data, data, straight_fit(), evaluate(data, straight_fit()), reference);
  for (const Criterion criterion : {Criterion::kMeanError, Criterion::kWorstTaxelError}) {
    CHECK(std::isnan(figure_in(all, criterion).u.expanded));
    CHECK_FALSE(figure_in(all, criterion).u.missing.empty());
  }
  CHECK(figure_in(all, Criterion::kDistanceOfMean).u.expanded > 0.0);
}

TEST_CASE("U of judged values: a drift beyond its stated limit never lowers it, even with few repeats") {
  // Three repeats as above: u^2 1/294 psi^2 with four degrees of freedom. With the drift's share taken as knowledge k
  // would fall while u grows.
  const Dataset data = repeats_a_step_apart();
  const Evaluation evaluation = evaluate(data, straight_fit());
  ReferenceUncertainty reference = certified(0.02);
  reference.drift_missing.clear();
  reference.drift_stated_psi = 0.05;
  double before = 0.0;
  for (const double growth : {1.0, 1.01, 1.2, 1.5, 2.0, 3.0, 4.0}) {
    INFO("growth " << growth);
    reference.drift_psi = growth * reference.drift_stated_psi;
    const auto all = measured_figures(data, data, straight_fit(), evaluation, reference);
    const FigureUncertainty mean = figure_in(all, Criterion::kMeanError).u;
    CHECK(mean.combined == Approx(std::sqrt(0.01 * 0.01 + std::pow(growth * 0.05, 2) / 3.0 + 1.0 / 294.0)));
    CHECK(mean.factor == Approx(2.52).margin(0.00501));  // six degrees of freedom, throughout
    CHECK(mean.expanded > before);
    before = mean.expanded;
  }
}

TEST_CASE("U of judged values: without a certificate an error has no U, a difference has U") {
  const Dataset data = repeats_a_step_apart();
  ReferenceUncertainty none;
  none.certificate_missing = "no certificate";
  const auto all = measured_figures(data, data, straight_fit(), evaluate(data, straight_fit()), none);
  CHECK(std::isnan(figure_in(all, Criterion::kMeanError).u.expanded));
  CHECK(figure_in(all, Criterion::kMeanError).u.missing == "no certificate");
  CHECK(figure_in(all, Criterion::kDistanceOfMean).u.expanded > 0.0);
}

namespace {

// One way; the first taxel reads `apart` more than the second, which reads the reference.
Repeat apart_by(const std::vector<double>& setpoints, const std::vector<double>& apart) {
  std::vector<Sample> steps;
  Readings readings;
  for (std::size_t i = 0; i < setpoints.size(); ++i) {
    steps.push_back({setpoints[i], setpoints[i]});
    readings.first_psi.push_back(setpoints[i] + apart[i]);
    readings.second_psi.push_back(setpoints[i]);
  }
  return repeat_of(steps, readings);
}
const std::vector<double> kWhole{0, 20, 40, 60, 40, 20, 0}, kCoarse{0, 40, 60, 40, 0};

std::vector<Figure> measured_of(const Dataset& judged, const Dataset& models) {
  return measured_figures(judged, models, straight_fit(), evaluate(judged, straight_fit(), 1), certified(0.2), 1);
}

FigureUncertainty level_up(const std::vector<Figure>& all, double psi) {
  return figure_in(all, Criterion::kMismatch, Scope::level(psi, Direction::kUp)).u;
}

}  // namespace

TEST_CASE("U of judged values: a level that not every sweep reaches uses the scatter of the common levels") {
  // At 40 psi upward the taxels are 2 and 4 psi apart: standard deviations of sqrt 2 and 2 sqrt 2, a variance of 1
  // between them; none at 0 and 60 psi. Pooled over three levels 1/3; in common 1/9; dof 1 / (1/9 + (4/9) / 2) = 3.
  const Dataset data =
      dataset_of({{"a", {apart_by(kWhole, {0, 5, 2, 0, 0, 0, 0})}}, {"b", {apart_by(kCoarse, {0, 4, 0, 0, 0})}}});
  const auto all = measured_of(data, data);
  const FigureUncertainty twenty = level_up(all, 20), forty = level_up(all, 40);
  CHECK(twenty.combined == Approx(std::sqrt(1.0 / 3.0 / 2.0) / 60.0));  // of two sweeps
  CHECK(twenty.dof == Approx(3.0));
  CHECK(forty.combined == Approx(std::sqrt(0.5) / 60.0));
  CHECK(forty.dof == 1.0);
}

TEST_CASE("U of judged values: one sweep uses the scatter of the models' run, and needs two sweeps there") {
  const Dataset one = dataset_of({{"a", {apart_by(kWhole, {0, 0, 3, 0, 0, 0, 0})}}});
  const Dataset two =
      dataset_of({{"a", {apart_by(kWhole, {0, 0, 2, 0, 0, 0, 0}), apart_by(kWhole, {0, 0, 4, 0, 0, 0, 0})}}});
  const auto all = measured_of(one, two);
  const FigureUncertainty forty = level_up(all, 40);
  CHECK(forty.combined == Approx(1.0 / 60.0));
  const FigureUncertainty distance = figure_in(all, Criterion::kDistanceOfMean).u;
  // The mean of both taxels 1 and 2 psi: a variance of 1/2 at one of four levels upward, pooled 1/8, in common 1/32.
  CHECK(distance.combined == Approx(std::sqrt(1.0 / 8.0) / 60.0));
  const auto nothing = measured_of(one, one);
  CHECK(std::isnan(level_up(nothing, 40).expanded));
  CHECK_FALSE(level_up(nothing, 40).missing.empty());
  CHECK_FALSE(figure_in(nothing, Criterion::kMeanError).u.missing.empty());
  CHECK(std::isnan(figure_in(nothing, Criterion::kDistanceOfMean).u.combined));
}

TEST_CASE("worst taxel: is the first of those with equal errors") {
  // Both read 10 psi too much at 40 psi upward: 2.5 and 5 V.
  const Evaluation e =
      evaluate(dataset_of({{"a",
                            {repeat_of({{0, 0}, {20, 20}, {40, 40}, {60, 60}, {40, 40}, {20, 20}, {0, 0}},
                                       {{0, 20, 50, 60, 40, 20, 0}, {0, 20, 50, 60, 40, 20, 0}})}}}),
               straight_fit(), 1);
  REQUIRE(e.taxel_mean_error_psi[0] == e.taxel_mean_error_psi[1]);
  CHECK(e.worst_taxel == 0);
  // The largest error of a run: whose it is, and at which pressure.
  const Evaluation known = evaluate(known_loop(), straight_fit(), 1);
  CHECK(known.max_error_taxel == 0);
  CHECK(known.max_error_at_psi == 20.0);
  CHECK((known.run == 2 && known.model_run == 1));
}
