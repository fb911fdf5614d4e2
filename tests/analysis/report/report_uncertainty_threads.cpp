// The sections on uncertainty and conformity: what they print is what the assessment says, and the page stays whole.
#include <catch2/catch.hpp>

#include "analysis/judgement/measured_figures.h"
#include "analysis/report/page/gum_numbers.h"
#include "analysis/report/report.h"
#include "tests/analysis/report/report_example.h"
#include "tests/analysis/report/report_page.h"
#include "tests/analysis/support/synthetic.h"

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

constexpr PressureUnit kSectionUnit = PressureUnit::kKilopascal;

nlohmann::json uncertainty_of(const ReportInput& input) { return report_json(input)["sections"]["uncertainty"]; }

ReportInput assessed_input() {
  ReportInput input = example::example_input();
  const synthetic::Array array({.rows = 4, .columns = 4, .sensor_seed = 4});
  Dataset dataset = synthetic::run(array, {.seed = 12, .noise_v = 0.004, .repeats = 3});
  dataset.scans = 2;
  input.fit = fit_array(dataset);
  input.evaluation = evaluate(dataset, input.fit);
  input.held_out.clear();
  input.run.devices[1].calibration_json =
      R"({"independent":true,"certificate":"C-2024-17","due":"2024-05-01","correction":{"reading_psi":[0,60],)"
      R"("correction_psi":[0,0],"expanded_uncertainty_psi":[0.05,0.1],"coverage_factor":2}})";
  UncertaintyInputs inputs;
  inputs.mounting = GivenUncertainty{0.0, 0.002, 3.0, "runs 3 to 6"};
  input.uncertainty = assess_uncertainty(dataset, input.fit, input.run, inputs);
  Evidence evidence;
  EvidenceRun& own = evidence.runs.emplace_back();
  own.run = 12;
  own.figures = measured_figures(dataset, dataset, input.fit, input.evaluation, reference_uncertainty(input.run));
  Limits limits;
  limits.mean_compensation_error_psi = input.evaluation.mean_error_psi;  // within U of the limit
  limits.worst_taxel_error_psi = 60.0;
  limits.distance_of_mean_fs = 1e-6;
  limits.mismatch = {{40.0, 0.5}};
  input.judgement = judge(evidence, limits);
  return input;
}

}  // namespace

TEST_CASE("a report with an assessment is well-formed, prints its U, and has the assessment in its data") {
  const ReportInput input = assessed_input();
  const std::string page = render_report(input).html;
  require_well_formed(page);
  require_inert(page);
  const Uncertainty& uncertainty = *input.uncertainty;
  const auto data = uncertainty_of(input)["reading"];
  REQUIRE(data["levels"].size() == uncertainty.levels.size());
  const LevelUncertainty& chosen = uncertainty.levels[uncertainty.chosen];
  const auto& worst = data["levels"][uncertainty.chosen]["worst"];
  CHECK(worst["contributions"].size() == chosen.worst.contributions.size());
  CHECK((worst["taxel"] == chosen.worst.taxel && worst["expanded_psi"] == chosen.worst.expanded_psi));
  CHECK(contains(page, gum_pressure(chosen.worst.expanded_psi, kSectionUnit).value));
  CHECK(data["not_assessed"].contains("chamber uniformity"));
  CHECK(data["not_assessed"].contains("reference, voltage input"));
  CHECK_FALSE(data["not_assessed"].contains("re-mounting, common"));
  CHECK(data["conditions"].size() == uncertainty.conditions.size());
  CHECK(data["conditions"][2]["valid"] == false);
}

TEST_CASE("the report's verdicts rest on U of the judged figures, and report-only limits give none") {
  ReportInput input = assessed_input();
  const auto data = uncertainty_of(input)["judged_figures"];
  const JudgedFigure& mean = input.judgement.figures.front();
  REQUIRE(data.size() == input.judgement.figures.size());
  CHECK(data[0]["expanded"] == mean.u.expanded);
  CHECK(contains(render_report(input).html, gum_pressure(mean.u.expanded, kSectionUnit).value));
  const auto results = report_json(input)["results"];
  CHECK(results["verdicts"][0]["verdict"] == "conditional pass");  // within U of the limit
  CHECK(results["judgement"]["overall"] == "fail");
  for (JudgedFigure& figure : input.judgement.figures) {
    figure.rule = DecisionRule::kReportOnly;
    figure.verdict = Verdict::kReportOnly;
  }
  conclude(input.judgement);
  require_well_formed(render_report(input).html);
  CHECK(report_json(input)["results"]["judgement"]["overall"] == "report only");
}

TEST_CASE("a report without an assessment states that, and uncertainty is content") {
  ReportInput input = example::example_input();
  CHECK(uncertainty_of(input)["reading"].is_null());
  ReportInput assessed = assessed_input();
  const std::string number = render_report(assessed).number;
  assessed.uncertainty->levels[7].median.expanded_psi += 1.0;
  CHECK(render_report(assessed).number != number);
}
