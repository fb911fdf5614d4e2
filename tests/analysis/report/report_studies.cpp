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
#include "tests/analysis/report/report_example.h"
#include "tests/analysis/report/report_page.h"

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

const std::string kHostile = "</script><img src=x onerror=alert(1)> \" & \xE2\x80\xAE";

ContactFigures figures(double force) { return {force, 1.0, -2.0, -2.0 * force, -force, 98.0, 0.5}; }

ContactResult contact() {
  ContactResult out;
  out.run = 14;
  out.sequence = kHostile;
  out.positions = 1;
  out.repeats = 3;
  out.full_scale_v = example::kFullScaleV;
  out.full_scale_psi = example::kFullPsi;
  for (const bool rising : {true, false}) {
    for (const double target : {2.0, 6.0}) {
      if (!rising && target == 6.0) continue;
      ContactLevel level;
      level.target_n = target;
      level.rising = rising;
      level.frames = 3;
      level.force_n = target;
      level.raw = figures(2.0 * target);
      level.compensated = figures(1.1 * target);
      level.raw_place_error_mm = level.compensated_place_error_mm = std::numeric_limits<double>::quiet_NaN();
      level.raw_v.assign(256, 0.1 * target);
      level.compensated_psi.assign(256, target);
      level.compensated_psi[37] = std::numeric_limits<double>::quiet_NaN();
      out.levels.push_back(level);
    }
  }
  out.raw_distance = {0.1, std::numeric_limits<double>::quiet_NaN()};
  out.compensated_distance = {0.2, std::numeric_limits<double>::quiet_NaN()};
  return out;
}

ReportInput full_input() {
  ReportInput input = example::example_input();
  ReportResults& more = input.more;
  more.usable = usable_range(input.fit);
  more.straight = {14.25, 51.5, 30.125};
  for (const NamedTaxel& taxel : named_taxels({1, 2, 3}, 16)) {
    ComparedTaxel compared{taxel, 3.5, {}};
    for (const Trace& trace : input.evaluation.traces) {
      more.traces.push_back(
          {taxel, kHostile, trace.pressure_psi, trace.measured_v, trace.model_v, trace.compensated_psi});
      ComparedSequence sequence{kHostile, trace.pressure_psi, trace.measured_v, {}};
      for (const char* model : kComparedModels) {
        ComparedModel own;
        own.model = model;
        own.model_v = trace.model_v;
        own.j_v2 = 0.5;
        own.mean_error_v = 0.02;
        own.max_error_v = 0.1;
        own.operations_per_sample = 9;
        own.parameters = {{"alpha", 1e-9, "1", 0.0, 1.0}, {"beta", 0.5, "1", 0.0, 1.0}};
        sequence.models.push_back(own);
      }
      sequence.models[1] = {};
      sequence.models[1].model = "mpi";
      sequence.models[1].failed = "no such luck";
      compared.sequences.push_back(sequence);
    }
    more.models.taxels.push_back(compared);
  }
  more.previous = AsFound{kHostile, input.evaluation, 254, {}, kHostile};
  more.previous->evaluation.levels[10].comp_distance = 0.0;  // as left is worse there than as found
  more.contacts = {contact()};
  Studies& studies = more.studies;
  studies.uniformity.not_assessed.clear();
  studies.uniformity.runs = {12, 15};
  studies.uniformity.angles_deg = {0, 90};
  studies.uniformity.pressure_psi = {20.0, 40.0};
  studies.uniformity.u_psi = {0.1, 0.2};
  studies.uniformity.residual_psi = {0.01, 0.02};
  studies.uniformity.chamber_share.assign(256, 0.005);
  studies.uniformity.chamber_psi.assign(256, 0.0);
  studies.uniformity.sensor_share.assign(256, -0.01);
  studies.uniformity.residual_rms_psi = 0.02;
  studies.uniformity.residual_other_sense_psi = 0.01;
  studies.remount.not_assessed.clear();
  studies.remount.runs = {12, 13};
  studies.remount.pressure_psi = {20.0, 40.0};
  studies.remount.within_psi = studies.remount.between_psi = studies.remount.mean_between_psi = {0.1, 0.2};
  studies.remount.taxel_between_psi.assign(256, 0.1);
  studies.remount.degrees = 1;
  studies.crosstalk.not_assessed.clear();
  studies.crosstalk.positions = 25;
  studies.crosstalk.row = {0.01, 0.001, 0.02, 600};
  studies.crosstalk.ghost_rows = {{3, 0.01}};
  studies.crosstalk.distance_pitches = {0.0, 1.0, 2.0, 3.0};
  studies.crosstalk.along_row_share = studies.crosstalk.along_column_share = {1.0, 0.5, 0.01, 0.01};
  studies.rate_hold.not_assessed.clear();
  ErrorSum error;
  error.add(0.25);
  studies.rate_hold.runs = {{16, kHostile, error, {{1.0, 2.0, error}, {2.0, 5.0, error}}, {}, 0.1, 0.05}};
  return input;
}

}  // namespace

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
  CHECK(contains(report.html, "Distance larger after compensation than raw"));
  CHECK(contains(report.html, html::psi(14.25, 2).value));
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
  CHECK_FALSE(contains(none, "Swapped lines are left out"));
  input.health.swaps = {{true, 3, 7, 0.1234, 0.9876}};
  const std::string one = health_section(input).value;
  CHECK(contains(one, "Swapped rows or columns: 1 pair found."));
  CHECK(contains(one, "rows 3 and 7 stand in each other’s place (correlation 0.99 exchanged, 0.12 as they are)"));
  CHECK(contains(one, "Swapped lines are left out"));
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
