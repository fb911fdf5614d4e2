// Decision rules at the edges, and the uncertainty of judged figures against the same by hand.
#include "analysis/judgement/judgement.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "tests/analysis/support/straight_array.h"

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

const double not_known = std::numeric_limits<double>::quiet_NaN();

db::VerdictRecord verdict_on(const std::vector<db::VerdictRecord>& verdicts, const std::string& criterion) {
  const auto found = std::ranges::find(verdicts, criterion, &db::VerdictRecord::criterion);
  REQUIRE(found != verdicts.end());
  return *found;
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
  using namespace straight_array;
  const std::vector<Sample> steps{{0, 0}, {20, 20}, {40, 41}, {60, 60}, {40, 40}, {20, 20}, {0, 0}};
  SequenceData sequence{"loop", {}};
  for (const double down : {25.0, 26.0, 27.0})
    sequence.repeats.push_back(repeat_of(steps, {{0, 20, 41, 60, 39, down, 0}, {0, 20, 41, 60, 43, 21, 0}}));
  return dataset_of({sequence});
}

}  // namespace

TEST_CASE("decision rules at the limit and U to either side of it") {
  // Limit 2, U 0.25: both are exact in binary.
  const auto above = [](double value) { return std::nextafter(value, 9.0); };
  using enum DecisionRule;
  struct Case {
    DecisionRule rule;
    double value, expanded;
    Verdict verdict;
  };
  for (const Case& each : {Case{kFourWay, -1.0, 0.25, Verdict::kPass},
                           Case{kFourWay, 1.75, 0.25, Verdict::kPass},
                           Case{kFourWay, above(1.75), 0.25, Verdict::kConditionalPass},
                           Case{kFourWay, 2.0, 0.25, Verdict::kConditionalPass},
                           Case{kFourWay, above(2.0), 0.25, Verdict::kConditionalFail},
                           Case{kFourWay, 2.25, 0.25, Verdict::kConditionalFail},
                           Case{kFourWay, above(2.25), 0.25, Verdict::kFail},
                           Case{kFourWay, 2.0, 0.0, Verdict::kPass},
                           Case{kFourWay, above(2.0), 0.0, Verdict::kFail},
                           Case{kFourWay, 1.0, not_known, Verdict::kInconclusive},
                           Case{kFourWay, not_known, 0.25, Verdict::kInconclusive},
                           Case{kSimple, 2.0, 0.25, Verdict::kPass},
                           Case{kSimple, above(2.0), 0.25, Verdict::kFail},
                           Case{kSimple, 2.0, not_known, Verdict::kPass},
                           Case{kGuarded, 1.75, 0.25, Verdict::kPass},
                           Case{kGuarded, above(1.75), 0.25, Verdict::kFail},
                           Case{kGuarded, 1.0, not_known, Verdict::kInconclusive},
                           Case{kDefault, 2.0, 0.25, Verdict::kConditionalPass},
                           Case{kDefault, 2.0, not_known, Verdict::kPass},
                           Case{kReportOnly, 9.0, 0.25, Verdict::kReportOnly}}) {
    CAPTURE(to_string(each.rule), each.value, each.expanded);
    CHECK(verdict_of(each.rule, each.value, 2.0, each.expanded) == each.verdict);
  }
  CHECK(verdict_of(kDefault, 1.0, not_known, 0.1) == Verdict::kInconclusive);
}

TEST_CASE("decision rules by their names, which of them need U, and the probabilities that they state") {
  for (const char* name : {"default", "simple", "guarded", "four-way", "report-only"}) {
    const auto rule = decision_rule_from(name);
    REQUIRE(rule);
    CHECK(std::string(to_string(*rule)) == name);
    CHECK_THAT(rule_in_words(name), Catch::Contains("ILAC-G8:09/2019"));
  }
  CHECK_FALSE(decision_rule_from("strict"));
  CHECK(rule_in_words("strict") == "strict");
  CHECK_THAT(rule_in_words("simple"), Catch::Contains("50 %"));
  CHECK_THAT(rule_in_words("guarded"), Catch::Contains("2.5 %"));
  CHECK_THAT(rule_in_words("four-way"), Catch::Contains("2.5 %") && Catch::Contains("50 %"));
  CHECK(needs_uncertainty(DecisionRule::kDefault));
  CHECK_FALSE(needs_uncertainty(DecisionRule::kSimple));
  CHECK_FALSE(needs_uncertainty(DecisionRule::kReportOnly));
}

TEST_CASE(
    "U of judged figures by hand: the reference where it counts, the repeats where it cancels, none for a count") {
  // Three repeats, each with one full sweep up and down.
  using namespace straight_array;
  const Dataset data = repeats_a_step_apart();
  const Evaluation evaluation = evaluate(data, straight_fit());
  const auto all = judged_uncertainties(data, data, straight_fit(), evaluation, certified(0.2));
  REQUIRE(all.size() == 4 + 2 * 4);
  const auto known = [&](const char* criterion, const char* scope) {
    const JudgedUncertainty* found = find_uncertainty(all, criterion, scope);
    REQUIRE(found != nullptr);
    return *found;
  };
  const double root3 = std::sqrt(3.0);
  // The first taxel's mean error rises by 1/7 psi a repeat, the second's not: pooled, s^2 = 1/98 psi^2, in equal parts
  // common (two degrees of freedom) and own (two): (1/98)^2 / (2 (1/196)^2 / 2) = 4 of them. Beside 0.1 psi of the
  // certificate: 4 (combined / u)^4, with u^2 = 1/294.
  const JudgedUncertainty mean = known("mean_compensation_error", "array"), worst = known("worst_taxel_error", "array");
  for (const JudgedUncertainty& error : {mean, worst}) {
    CHECK(error.combined == Approx(std::hypot(0.1, 1.0 / 7.0 / std::sqrt(2.0) / root3)));
    CHECK(error.dof == Approx(4.0 * std::pow(1.0 + 0.01 * 294.0, 2)));
    CHECK(error.factor == Approx(2.04).margin(0.0055));  // Table G.2, between 50 and 100 degrees of freedom
    CHECK(error.expanded == Approx(error.factor * error.combined));
  }
  // Half a psi more of the mean at one of the three levels passed downward, of 60 psi; upward nothing moves. Pooled
  // over the levels: 0.5^2 / 3, of which a third is common; dof 2 / (1/9 + (4/9) / 2) = 6.
  const JudgedUncertainty distance = known("distance_of_mean", "array");
  CHECK(distance.combined == Approx(0.5 / 60.0 / root3 / root3));
  CHECK(distance.dof == Approx(6.0));
  CHECK(distance.factor == Approx(2.52).margin(0.00501));  // six degrees of freedom
  // Two taxels 4, 5 and 6 psi apart: their standard deviation is that over sqrt 2.
  CHECK(known("mismatch", "20 psi down").combined == Approx(1.0 / std::sqrt(2.0) / 60.0 / root3));
  CHECK(known("mismatch", "20 psi up").combined == Approx(0.0).margin(1e-12));
  CHECK(known("unfit_taxels", "array").expanded == 0.0);
  CHECK(find_uncertainty(all, "mismatch", "41 psi up") == nullptr);
}

TEST_CASE(
    "the reference's input, hysteresis, zero and temperature are in U of an error, its hysteresis in a distance") {
  using namespace straight_array;
  const Dataset data = repeats_a_step_apart();
  const Evaluation evaluation = evaluate(data, straight_fit());
  const auto combined = [&](const ReferenceUncertainty& reference, const char* criterion) {
    const auto all = judged_uncertainties(data, data, straight_fit(), evaluation, reference);
    return find_uncertainty(all, criterion, "array")->combined;
  };
  const ReferenceUncertainty bare = certified(0.02);
  for (const ReferencePart part :
       {ReferencePart::kVoltageInput, ReferencePart::kHysteresis, ReferencePart::kZero, ReferencePart::kTemperature}) {
    ReferenceUncertainty with = bare;
    with.limits[static_cast<std::size_t>(part)].half_width_psi = 0.3;
    CHECK(combined(with, "mean_compensation_error") ==
          Approx(std::hypot(combined(bare, "mean_compensation_error"), 0.3 / std::sqrt(3.0))));
    // Too low going up and too high going down: twice the half-width, of 60 psi.
    const double apart = part == ReferencePart::kHysteresis ? 0.6 / 60.0 / std::sqrt(3.0) : 0.0;
    CHECK(combined(with, "distance_of_mean") == Approx(std::hypot(combined(bare, "distance_of_mean"), apart)));
  }
}

TEST_CASE("U of an error is not known where the run goes beyond the certificate, a distance keeps its own") {
  using namespace straight_array;
  const Dataset data = repeats_a_step_apart();
  ReferenceUncertainty reference = certified(0.02);
  reference.beyond = "a part of the run";
  const auto all = judged_uncertainties(data, data, straight_fit(), evaluate(data, straight_fit()), reference);
  for (const char* criterion : {"mean_compensation_error", "worst_taxel_error"}) {
    CHECK(std::isnan(find_uncertainty(all, criterion, "array")->expanded));
    CHECK(find_uncertainty(all, criterion, "array")->missing == reference.beyond);
  }
  CHECK(find_uncertainty(all, "distance_of_mean", "array")->expanded > 0.0);
}

TEST_CASE("a drift that has outgrown what was stated never lowers U, though few repeats make k large") {
  // Three repeats as above: u^2 1/294 psi^2 with four degrees of freedom. With the drift's share taken as knowledge k
  // would fall while u grows.
  using namespace straight_array;
  const Dataset data = repeats_a_step_apart();
  const Evaluation evaluation = evaluate(data, straight_fit());
  ReferenceUncertainty reference = certified(0.02);
  reference.drift_missing.clear();
  reference.drift_stated_psi = 0.05;
  double before = 0.0;
  for (const double growth : {1.0, 1.01, 1.2, 1.5, 2.0, 3.0, 4.0}) {
    INFO("growth " << growth);
    reference.drift_psi = growth * reference.drift_stated_psi;
    const auto all = judged_uncertainties(data, data, straight_fit(), evaluation, reference);
    const JudgedUncertainty* mean = find_uncertainty(all, "mean_compensation_error", "array");
    CHECK(mean->combined == Approx(std::sqrt(0.01 * 0.01 + std::pow(growth * 0.05, 2) / 3.0 + 1.0 / 294.0)));
    CHECK(mean->factor == Approx(2.52).margin(0.00501));  // six degrees of freedom, throughout
    CHECK(mean->expanded > before);
    before = mean->expanded;
  }
}

TEST_CASE("without a certificate U of an error is not known, and only the default rule falls back to simple") {
  using namespace straight_array;
  const Dataset data = repeats_a_step_apart();
  const Evaluation evaluation = evaluate(data, straight_fit());
  ReferenceUncertainty none;
  none.certificate_missing = "no certificate";
  const auto all = judged_uncertainties(data, data, straight_fit(), evaluation, none);
  CHECK(std::isnan(find_uncertainty(all, "mean_compensation_error", "array")->expanded));
  CHECK(find_uncertainty(all, "mean_compensation_error", "array")->missing == "no certificate");
  CHECK(find_uncertainty(all, "distance_of_mean", "array")->expanded > 0.0);
  Limits limits;
  limits.mean_compensation_error_psi = limits.worst_taxel_error_psi = 60.0;
  limits.distance_of_mean_fs = 1.0;
  const auto row = [&](DecisionRule rule, const char* criterion) {
    limits.rule = rule;
    return verdict_on(judge(evaluation, straight_fit(), limits, all), criterion);
  };
  CHECK(row(DecisionRule::kDefault, "mean_compensation_error").rule == "simple");
  CHECK(row(DecisionRule::kDefault, "mean_compensation_error").verdict == "pass");
  CHECK(row(DecisionRule::kDefault, "distance_of_mean").rule == "four-way");
  CHECK(row(DecisionRule::kDefault, "unfit_taxels").rule == "four-way");
  CHECK(row(DecisionRule::kFourWay, "mean_compensation_error").verdict == "inconclusive");
  for (const char* criterion : {"mean_compensation_error", "worst_taxel_error", "distance_of_mean", "unfit_taxels"})
    CHECK(row(DecisionRule::kReportOnly, criterion).verdict == "report only");
}
