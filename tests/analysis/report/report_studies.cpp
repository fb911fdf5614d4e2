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

TEST_CASE(
    "models compared: the least error is marked among models alike, and what is fixed by convention is no finding") {
  ReportInput input = full_input();
  input.more.models.taxels.resize(1);
  input.more.models.taxels[0].sequences.resize(1);
  ComparedSequence& sequence = input.more.models.taxels[0].sequences[0];
  sequence.name = "up";
  const auto row_of = [&](const char* title) {
    const std::string page = models_section(input).value;
    const std::size_t at = page.find(std::string("<th scope=\"row\">up</th><td>") + title);
    REQUIRE(at != std::string::npos);
    return page.substr(at + std::string("<th scope=\"row\">up</th><td>").size(),
                       page.find("</td>", at) - at - std::string("<th scope=\"row\">up</th><td>").size());
  };
  ComparedModel &gpi = sequence.models[0], &poly = sequence.models[2], &elam = sequence.models[3];
  gpi.mean_error_v = 0.03;
  poly.mean_error_v = 0.02;
  elam.mean_error_v = 0.01;
  CHECK(row_of("ELAM") == "ELAM (least mean error)");  // of one sequence all have a set of their own
  CHECK(row_of("POLY") == "POLY");
  elam.joint = true;
  CHECK(row_of("ELAM") == "ELAM (one set for all sequences)");
  CHECK(row_of("POLY") == "POLY (least mean error of the sets for this sequence alone)");
  CHECK(row_of("GPI") == "GPI");
  gpi.parameters = {{"a0", 2.0, "y", 0.0, 9.0}, {"a2", 0.0, "1", -9.0, 9.0, true}, {"rho", 1.0, "1", 1.0, 9.0, true}};
  const std::string page = models_section(input).value;
  CHECK(contains(page, "<td>a0</td>"));
  CHECK(contains(page, "<td>a2 (fixed)</td>"));
  CHECK(contains(page, "<td>rho (fixed)</td>"));
  CHECK(contains(page, "<th scope=\"row\">GPI</th><td class=\"n\">1</td>"));  // of three one is identified
  const auto data = nlohmann::json::parse(models_json(input));
  CHECK(data[0]["sequences"][0]["models"][3]["joint"] == true);
  CHECK(data[0]["sequences"][0]["models"][0]["parameters"][1]["fixed"] == true);
}

TEST_CASE("one measuring interval: by U in the section Uncertainty, the inverse's condition has another name") {
  const ReportInput input = full_input();
  const std::string single = compensation_section(input).value;
  REQUIRE(contains(single, "<h3>Condition of the inverse</h3>"));
  for (const char* title : {"<h2", "<h3>", "<caption>", "<title>", "<th scope=\"col\">"})
    for (std::size_t at = single.find(title); at != std::string::npos; at = single.find(title, at + 1))
      CHECK_FALSE(contains(single.substr(at, single.find("</", at) - at), "easuring interval"));
  CHECK(contains(single,
                 "the measuring interval, in which U of 95 % of the taxels is within a stated limit, stands in "
                 "the section Uncertainty"));
}

TEST_CASE("full scale of a model: its loop's end, in the table of the mean taxel and beside the models compared") {
  const ReportInput input = full_input();
  const std::string words =
      "the output at the end of the external loop where it is larger (of a rising sensor its highest pressure), mean "
      "of "
      "the sweeps there";
  CHECK(contains(model_section(input).value, "<td>of the mean taxel: " + words + "</td>"));
  CHECK(contains(models_section(input).value, "FS is 3.500 V, of this taxel’s external loop " + words));
  CHECK_FALSE(contains(render_report(input).html, "highest output of the external loop"));
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
