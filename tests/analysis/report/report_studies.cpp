// Models compared, as found and as left, single taxels, studies and objects as parts of the document: well-formed,
// inert, every figure titled, nothing left empty, hostile names harmless.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>

#include "analysis/report/data/section_data.h"
#include "analysis/report/parts.h"
#include "analysis/report/sections/sections.h"
#include "tests/analysis/report/report_example_full.h"
#include "tests/analysis/report/report_page.h"

using namespace tactbench;
using namespace tactbench::analysis;
using example::full_input;

TEST_CASE("a report with all studies is well-formed, inert, and every figure and table has its title") {
  const ReportInput input = full_input();
  const Report report = render_report(input);
  CHECK(report.html == render_report(input).html);
  CHECK(report.html.size() < 2'000'000);
  require_well_formed(report.html);
  require_inert(report.html);
  CHECK_FALSE(contains(report.html, "<img"));
  CHECK(count(report.html, "<svg ") == count(report.html, "<svg role=\"img\""));
  CHECK(count(report.html, "<svg ") == count(report.html, "</title>") - 1);
  CHECK(count(report.html, "<table") == count(report.html, "<caption>"));
  CHECK_FALSE(contains(report.html, "not available, not available"));
  CHECK(contains(report.html, "MPI: not available, no such luck"));
  CHECK(contains(report.html, "worse than as found"));
  CHECK(contains(report.html, "Ghost rows"));
  CHECK(contains(report.html, "smaller: were the angles taken clockwise?"));
  CHECK(contains(report.html, "no registration of the stage to the taxels was given"));
  CHECK(contains(report.html, "Hysteresis of the corrected indication larger than that of the indication"));
  CHECK(contains(report.html, html::pressure(14.25, PressureUnit::kKilopascal, 2).value));
  CHECK(contains(report.html, "1.000e-09"));
}

TEST_CASE("models compared: errors as shares of each taxel's own full scale, parameters of the mean taxel alone") {
  ReportInput input = full_input();
  const std::size_t sequences = input.evaluation.traces.size();
  REQUIRE(sequences > 0);
  std::string mean_title;
  for (ComparedTaxel& taxel : input.more.models.taxels) {
    if (taxel.taxel.taxel == kMeanTaxel) mean_title = taxel.taxel.title;
    for (ComparedSequence& sequence : taxel.sequences) sequence.name = "up";
  }
  const std::string page = models_section(input).value;
  CHECK(count(page, "<caption>Parameters, ") == sequences);
  CHECK(count(page, "<caption>Parameters, " + mean_title + ", sequence up</caption>") == sequences);
  CHECK(contains(page, "mean error 0.57 % FS, maximum 2.86 % FS."));  // 0.02 and 0.1 V of 3.5 V
  CHECK(contains(page, "0.5000"));
}

TEST_CASE("swapped lines: the run compared with, both limits and each pair's correlations by the letter") {
  ReportInput input = full_input();
  input.health.swaps_assessed = true;
  input.health.options.swap_margin = 0.3;
  input.health.options.swap_correlation = 0.7;
  input.history.earlier_seating_run = 41;
  const std::string limits =
      "seating, of run 41; lines count as swapped when they fit at least 0.3 better in each other’s place, with a "
      "correlation of at least 0.7. Taxels";
  input.health.swaps.clear();
  const std::string none = health_section(input).value;
  CHECK(contains(none, "Swapped rows or columns: none found."));
  CHECK(contains(none, limits));
  CHECK_FALSE(contains(none, "No figure excludes swapped lines"));
  input.health.swaps = {{true, 3, 7, 0.1234, 0.9876}};
  const std::string one = health_section(input).value;
  CHECK(contains(one, "Swapped rows or columns: 1 pair found."));
  CHECK(contains(one, "rows 3 and 7 stand in each other’s place (correlation 0.99 exchanged, 0.12 as they are)"));
  CHECK(contains(one, "No figure excludes swapped lines"));
  input.health.swaps.push_back({false, 0, 15, 0.25, 0.75});
  const std::string two = health_section(input).value;
  CHECK(contains(two, "Swapped rows or columns: 2 pairs found."));
  CHECK(contains(two, "columns 0 and 15 stand"));
  input.health.swaps_assessed = false;
  CHECK(contains(health_section(input).value, "Swapped rows or columns: not assessed, "));
}

TEST_CASE("results without runs are not assessed, with the reason") {
  ReportInput input = example::example_input();
  const std::string page = studies_section(input).value + objects_section(input).value + as_found_section(input).value;
  CHECK(count(page, "not assessed: ") >= 5);
  CHECK(contains(page, "not assessed: no run with a point indenter was given"));
  CHECK(contains(page, "not assessed: no run of the recipes rate, rate-ramp or creep-hold was given"));
  CHECK(contains(page, "not assessed: no runs of this sensor mounted anew were given"));
  CHECK(contains(page, "not assessed: no runs of this sensor turned in the chamber were given"));
  CHECK(contains(page, "not assessed: no run with an object on the stage was given"));
  CHECK(contains(page, "As found: not assessed"));
  CHECK(nlohmann::json::parse(studies_json(input))["uniformity"].contains("not_assessed"));
}

TEST_CASE("report content excludes run numbers and the earlier models' name, and includes their figures") {
  ReportInput input = full_input();
  const std::string number = render_report(input).number;
  input.more.studies.remount.runs = {112, 113};
  input.more.contacts[0].run = 99;
  input.more.previous->model = "another.json";
  CHECK(render_report(input).number == number);
  input.more.studies.remount.between_psi[0] += 1e-6;
  CHECK(render_report(input).number != number);
}
