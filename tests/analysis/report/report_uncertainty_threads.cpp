// The sections on uncertainty and conformity: what they print is what the assessment says, and the page stays whole.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <tuple>

#include "analysis/report/page/gum_numbers.h"
#include "analysis/report/report.h"
#include "analysis/statistics/numbers/moments.h"
#include "tests/analysis/report/report_example.h"
#include "tests/analysis/report/report_page.h"
#include "tests/analysis/support/synthetic.h"

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

constexpr PressureUnit kSectionUnit = PressureUnit::kKilopascal;

nlohmann::json uncertainty_of(const std::string& page) {
  const std::string open = "id=\"report-data\">";
  const std::size_t from = page.find(open) + open.size();
  return nlohmann::json::parse(page.substr(from, page.find("</script>", from) - from))["sections"]["uncertainty"];
}

// The page's text from one place to another, without tags.
std::string text_between(const std::string& page, const std::string& from, const std::string& to) {
  const std::size_t start = page.find(from), end = page.find(to, start);
  REQUIRE(start != std::string::npos);
  REQUIRE(end != std::string::npos);
  std::string out;
  bool in_tag = false;
  for (const char c : page.substr(start, end - start)) {
    if (c == '<') out += in_tag ? "" : " ";
    in_tag = c == '<' || (in_tag && c != '>');
    if (!in_tag && c != '>') out += c;
  }
  return out;
}

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
  input.judged = judged_uncertainties(dataset, dataset, input.fit, input.evaluation, reference_uncertainty(input.run));
  Limits limits;
  limits.mean_compensation_error_psi = input.evaluation.mean_error_psi;  // within U of the limit
  limits.worst_taxel_error_psi = 60.0;
  limits.distance_of_mean_fs = 1e-6;
  limits.mismatch = {{40.0, 0.5}};
  input.verdicts = judge(input.evaluation, input.fit, limits, input.judged);
  return input;
}

}  // namespace

TEST_CASE("U has two significant digits and the value the same place") {
  const auto shown = [](double value, double expanded) { return gum_value(value, expanded).value; };
  CHECK(shown(1.23456, 0.3456) == "1.23 ± 0.35");
  CHECK(shown(-1.23456, 0.03456) == "−1.235 ± 0.035");
  CHECK(shown(1.23456, 0.0996) == "1.23 ± 0.10");
  CHECK(shown(12.3456, 1.04) == "12.3 ± 1.0");
  CHECK(shown(12.3456, 10.4) == "12 ± 10");
  CHECK(shown(12.3456, 9.96) == "12 ± 10");
  CHECK(shown(-6.2, 106.0) == "−10 ± 110");
  CHECK(shown(-6.2, 99.4) == "−6 ± 99");
  CHECK(gum_pressure(0.1, PressureUnit::kBar).value == "0.0069\u00A0bar (0.10\u00A0psi)");
  CHECK(gum_pressure_stated(0.9034, 0.13, PressureUnit::kKilopascal).value ==
        "6.23 ± 0.90\u00A0kPa (0.90 ± 0.13\u00A0psi)");
  CHECK(gum_decimals(0.1) == 2);
  CHECK(gum_decimals(0.0) == 3);
  CHECK(gum_uncertainty(std::nan("")).value == "not available");
  CHECK(gum_degrees(16.7).value == "16");
  CHECK(gum_degrees(16372.0).value == "&gt; 1000");
  CHECK(gum_degrees(kInfiniteDof).value == "∞");
}

TEST_CASE("the uncertainty section prints the assessment, and its data are the assessment") {
  const ReportInput input = assessed_input();
  const std::string page = render_report(input).html;
  require_well_formed(page);
  require_inert(page);
  const Uncertainty& uncertainty = *input.uncertainty;
  const auto data = uncertainty_of(page)["reading"];
  REQUIRE(data["levels"].size() == uncertainty.levels.size());
  for (std::size_t i = 0; i < uncertainty.levels.size(); ++i) {
    const LevelUncertainty& level = uncertainty.levels[i];
    const auto& json = data["levels"][i];
    CHECK(json["pressure_psi"] == level.pressure_psi);
    CHECK(json["branch"] == (level.up ? "up" : "down"));
    CHECK(json["median"]["expanded_psi"] == level.median.expanded_psi);
    CHECK(json["worst"]["taxel"] == level.worst.taxel);
    CHECK(json["worst"]["error_psi"] == level.worst.error_psi);
    CHECK(json["taxel_expanded_psi"].size() == 16);
    CHECK(json["taxel_factor"][5].get<double>() == Approx(level.factor[5]).epsilon(1e-3));
    CHECK(json["taxel_expanded_psi"][5].get<double>() == Approx(level.expanded_psi[5]).epsilon(6e-3));
    for (const Contribution& row : level.worst.contributions)
      CHECK(json["worst"]["u_psi"][static_cast<std::size_t>(row.source)] == row.u_psi);
  }
  const std::string table = text_between(page, "Error and U at every level", "</table>");
  for (const LevelUncertainty& level : uncertainty.levels)
    for (const Budget* budget : {&level.median, &level.worst})
      CHECK_THAT(table, Catch::Contains(gum_pressure(budget->error_psi, budget->expanded_psi, kSectionUnit).value));

  const LevelUncertainty& chosen = uncertainty.levels[uncertainty.chosen];
  CHECK(data["levels"][uncertainty.chosen]["worst"]["contributions"].size() == chosen.worst.contributions.size());
  const std::string budget = text_between(page, "Budget of the worst taxel", "</table>");
  for (const Contribution& row : chosen.worst.contributions) {
    CHECK_THAT(budget, Catch::Contains(gum_uncertainty(kSectionUnit.of(row.u_psi)).value));
    CHECK_THAT(budget, Catch::Contains(html::percent(std::pow(row.u_psi / chosen.worst.combined_psi, 2), 1).value));
  }
  CHECK_THAT(budget, Catch::Contains(gum_pressure(chosen.worst.expanded_psi, kSectionUnit).value));
  for (const char* quantity : {"short-term repeatability (noise)", "resolution of the ADC", "lack of fit, corrected",
                               "measurement standard: certificate", "zero deviation", "kPa/mV"})
    CHECK_THAT(budget, Catch::Contains(quantity));
  // x_i, behind name and type: what is taken off stands at the lack of fit, all other estimates are 0.
  const auto estimate_of = [&budget](const std::string& quantity) {
    std::istringstream behind(budget.substr(budget.find(quantity) + quantity.size()));
    std::string type, estimate;
    behind >> type >> estimate;
    return type + " " + estimate;
  };
  const auto in_table = [&chosen](double psi) {
    return "A " + html::fixed(kSectionUnit.of(psi), gum_decimals(kSectionUnit.of(chosen.worst.expanded_psi))).value;
  };
  REQUIRE(in_table(chosen.worst.error_psi) != in_table(0.0));
  CHECK(estimate_of("lack of fit, corrected") == in_table(chosen.worst.error_psi));
  CHECK(estimate_of("short-term repeatability (noise)") == in_table(0.0));
  CHECK_THAT(budget, Catch::Contains("U = " + html::fixed(chosen.worst.factor, 2).value + " u_c"));
  CHECK_THAT(budget, Catch::Contains("not assessed"));
  const std::string section = text_between(page, "id=\"uncertainty\"", "id=\"meaning\"");
  CHECK_THAT(section, Catch::Contains("0, 90, 180 and 270 degrees") && Catch::Contains("runs 3 to 6") &&
                          Catch::Contains("overdue when the run began") && Catch::Contains("creep-hold"));
  // The longest row of levels with at most 1 % of 60 psi.
  double low = 0.0, high = -1.0, begin = -1.0;
  for (const LevelUncertainty& level : uncertainty.levels) {
    if (!level.up) continue;
    if (quantile_of(finite_of(level.expanded_psi), 0.95) > 0.6) {
      begin = -1.0;
      continue;
    }
    if (begin < 0.0) begin = level.pressure_psi;
    if (level.pressure_psi - begin > high - low) std::tie(low, high) = std::pair(begin, level.pressure_psi);
  }
  CHECK_THAT(section, Catch::Contains(fmt::format("1.0 %: {}", html::pressure(0.6, kSectionUnit, 2).value)));
  CHECK_THAT(section, Catch::Contains(fmt::format("increasing: {} to {}", html::pressure(low, kSectionUnit, 1).value,
                                                  html::pressure(high, kSectionUnit, 1).value)));
  CHECK(data["not_assessed"].contains("chamber uniformity"));
  // The run does not say what its certificate covers, as runs of before the word was asked for.
  CHECK_THAT(data["not_assessed"]["reference, voltage input"].get<std::string>(),
             Catch::Contains("not recorded what the certificate covers"));
  CHECK(data["reference"]["certificate_covers"] == "not stated");
  CHECK_THAT(section, Catch::Contains("it covers: not stated"));
  CHECK_FALSE(data["not_assessed"].contains("re-mounting, common"));
  CHECK(data["not_assessed"].contains("re-mounting, a taxel's own"));
  const std::string first = text_between(page, "id=\"verdicts\"", "id=\"identification\"");
  for (const ConditionUncertainty& condition : uncertainty.conditions) {
    CHECK_THAT(first, Catch::Contains(name_of(condition.condition)));
    CHECK_THAT(section, Catch::Contains(name_of(condition.condition)));
    if (!condition.valid())
      CHECK_THAT(section, Catch::Contains("not valid for this: " + kSectionUnit.both_in_text(condition.not_valid)));
  }
  CHECK(data["conditions"].size() == uncertainty.conditions.size());
  CHECK(data["conditions"][2]["valid"] == false);
}

TEST_CASE("the verdicts name rule, U and how it is formed, with a sign and a word for each") {
  ReportInput input = assessed_input();
  const std::string page = render_report(input).html;
  const std::string section = text_between(page, "id=\"verdicts\"", "id=\"identification\"");
  CHECK_THAT(section,
             Catch::Contains("▲ simulated conditional pass") || Catch::Contains("▲  simulated conditional pass"));
  CHECK_THAT(section, Catch::Contains("simulated fail") && Catch::Contains("four-way") && Catch::Contains("2.5 %"));
  for (const char* criterion : {"mean_compensation_error", "distance_of_mean"})
    CHECK_THAT(
        section,
        Catch::Contains(
            html::Text(kSectionUnit.both_in_text(find_uncertainty(input.judged, criterion, "array")->basis)).value));
  const JudgedUncertainty* mean = find_uncertainty(input.judged, "mean_compensation_error", "array");
  CHECK_THAT(section, Catch::Contains(gum_pressure(mean->expanded, kSectionUnit).value));
  const auto data = uncertainty_of(page)["judged_figures"];
  REQUIRE(data.size() == input.judged.size());
  CHECK(data[0]["expanded"] == mean->expanded);

  for (db::VerdictRecord& verdict : input.verdicts) {
    verdict.rule = "report-only";
    verdict.verdict = "report only";
  }
  const std::string only = render_report(input).html;
  require_well_formed(only);
  CHECK_THAT(only, Catch::Contains("Conformity is not stated") && Catch::Contains("– no verdict"));
  CHECK_FALSE(contains(only, "All requirements together"));
}

TEST_CASE("a report without an assessment states that, and uncertainty is content") {
  ReportInput input = example::example_input();
  CHECK_THAT(render_report(input).html, Catch::Contains("Not assessed: the uncertainty rests on"));
  CHECK(uncertainty_of(render_report(input).html)["reading"].is_null());
  ReportInput assessed = assessed_input();
  const std::string number = render_report(assessed).number;
  assessed.uncertainty->levels[7].median.expanded_psi += 1.0;
  CHECK(render_report(assessed).number != number);
}
