// Each section of the report shows the figures that it is given: one value a section, by hand.
#include <catch2/catch.hpp>
#include <string>
#include <utility>
#include <vector>

#include "analysis/report/parts.h"
#include "analysis/report/sections/sections.h"
#include "tests/analysis/report/report_page.h"
#include "tests/analysis/support/judged_figures.h"
#include "tests/analysis/support/sensor_models.h"

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

// A page's own cells, without what is marked up in them.
bool has_cell(const html::Markup& section, const std::string& value) {
  return contains(section.value, ">" + value + "<");
}

std::string in_psi(double pressure, int digits) { return html::pressure(pressure, PressureUnit::kPsi, digits).value; }

LevelFigures shown_level() {
  LevelFigures level;
  level.pressure_psi = 20.0;
  level.raw_up_v = {0.5, 1.0};
  level.raw_down_v = {0.7, 1.8};
  level.comp_up_psi = {3.0, 4.0};
  level.comp_down_psi = {5.1, 6.0};
  level.raw_distance = 0.13334;
  level.comp_distance = 0.01334;
  level.flat_taxels = 1;
  return level;
}

// Two taxels with a model whose loops reach to 2.5 V, and the mean taxel.
ReportInput shown_input() {
  ReportInput input;
  input.unit = PressureUnit::kPsi;
  input.run.run = 12;
  input.run.origin = "hardware";
  input.fit.model = "elam";
  input.fit.rows = 1;
  input.fit.columns = 2;
  const std::vector<double> x = {0.0, 60.0}, y = {0.0, 2.5};
  const PatternCurve curve(x, y, 0.0, 2.5);
  ModelTaxel taxel = by_hand::elam_taxel(curve, curve, {0.12344, 0.22344, -0.00344, 0.32344, 0.1});
  taxel.fit.max_error = 0.15678;
  input.fit.taxels = {taxel, taxel};
  by_hand::finish(input.fit, taxel);
  Evaluation& e = input.evaluation;
  e.full_scale_v = 2.5;
  e.full_scale_psi = 60.0;
  e.mean_error_psi = 0.11114;
  e.taxel_mean_error_psi = {0.5, 1.25};
  e.comp_distance = 0.02334;
  e.levels = {shown_level()};
  e.traces = {{"descending", {0.0, 30.0, 60.0}, {0.0, 1.0, 2.0}, {0.1, 0.9, 2.0}, {1.0, 28.0, 60.0}}};
  return input;
}

}  // namespace

TEST_CASE("sections of a run and its models show what they are given") {
  ReportInput input = shown_input();
  CHECK(has_cell(levels_section(input), "13.33"));
  CHECK(has_cell(frames_section(input), "13.3"));
  CHECK(has_cell(loops_section(input), "0.0667"));  // 0.1, 0.1 and 0 V
  CHECK(has_cell(model_section(input), "0.1568"));
  CHECK(has_cell(model_section(input), in_psi(0.11114, 3)));
  input.held_out = {{"a later day", input.run, input.evaluation}};
  input.held_out[0].evaluation.comp_distance = 0.03334;
  CHECK(has_cell(held_out_section(input), "2.33"));
  CHECK(has_cell(held_out_section(input), "3.33"));
  input.more.previous = AsFound{"earlier.json", input.evaluation, 253, {}, ""};
  input.more.previous->evaluation.mean_error_psi = 0.1124;
  CHECK(contains(as_found_section(input).value, in_psi(0.1124, 3)));
  input.judgement =
      by_hand::judgement_of({by_hand::judged_figure(12, Criterion::kMeanError, 0.5213, 1.0, Verdict::kPass)});
  input.judgement.figures[0].u.expanded = 0.0344;
  CHECK(contains(verdict_section(input).value, "0.521\u00A0psi (3.59\u00A0kPa)"));
}

TEST_CASE("sections of the indication and the sensor's health show what they are given") {
  ReportInput input;
  input.unit = PressureUnit::kPsi;
  input.health.rows = 1;
  input.health.columns = 2;
  input.health.low_v = {0.1, 0.2};
  input.health.high_v = {2.1, 3.2};
  input.health.noise_v = {0.001, 0.002};
  input.health.median_noise_v = 0.001234;
  CHECK(contains(health_section(input).value, "1.23 mV"));
  Behaviour& b = input.behaviour;
  b.taxels = {0, 1};
  b.pressure_psi = {0.0, 60.0};
  b.full_scale_v = 2.5;
  RawLoop loop;
  loop.name = "mean";
  loop.taxel = -1;
  loop.full_scale_v = 2.5;
  loop.hysteresis_max = 0.2514;
  loop.up_v = loop.down_v = {0.0, 2.5};
  b.loops = {loop};
  b.gain = {0.9, 1.1};
  CHECK(has_cell(raw_section(input), "25.1"));
}

TEST_CASE("sections of further studies show what they are given") {
  ReportInput input;
  input.unit = PressureUnit::kPsi;
  input.fit.rows = 1;
  input.fit.columns = 2;
  Crosstalk& crosstalk = input.more.studies.crosstalk;
  crosstalk.not_assessed.clear();
  crosstalk.positions = 1;
  crosstalk.row = {0.012344, 0.002344, 0.032344, 61};
  crosstalk.distance_pitches = {0.0, 1.0, 2.0};
  crosstalk.along_row_share = crosstalk.along_column_share = {1.0, 0.5, 0.03};
  CHECK(has_cell(studies_section(input), "1.234"));

  ComparedModel model;
  model.model = "gpi";
  model.model_v = {0.1, 2.0};
  model.mean_error_v = 0.05124;
  ComparedTaxel mean{{kMeanTaxel, "mean taxel"}, 2.5, {}};
  mean.sequences = {{"up", {0.0, 60.0}, {0.0, 2.5}, {}}};
  for (const char* name : {"gpi", "mpi", "poly", "elam"}) {
    model.model = name;
    mean.sequences[0].models.push_back(model);
  }
  input.more.models.taxels = {mean};
  CHECK(has_cell(models_section(input), "2.05"));  // of 2.5 V

  UsableRange& range = input.more.usable;
  range.taxels = 2;
  range.pressure_psi = {0.0, 60.0};
  range.loading = {{0.5, 1.0}, {0.4, 0.9}, {3.0, 1.0}, {5.0, 1.5}, 30.0, 30.0, 2.04, 58.04};
  range.unloading = range.loading;
  CHECK(contains(usable_part(input).value, in_psi(2.04, 1) + " to " + in_psi(58.04, 1)));
}

TEST_CASE("objects: U of a budget in newton is twice the root of the sum of squares") {
  ReportInput input;
  ContactResult contact;
  contact.sequence = "ring";
  contact.positions = 2;
  contact.repeats = 3;
  ContactLevel level;
  level.rising = true;
  level.target_n = level.force_n = 1.0;
  level.raw.force_n = 1.5;
  level.compensated.force_n = 1.2;
  contact.levels = {level, level};
  contact.force_uncertainty.unit = "N";
  // 0.06 / 2 = 0.03 and 0.12345 / 3 = 0.04115 N: together 0.0509 N.
  contact.force_uncertainty.rows = {{"certificate", "rectangular", 0.06, 2.0, {}},
                                    {"drift", "rectangular", 0.12345, 3.0, {}}};
  input.more.contacts = {contact};
  CHECK(has_cell(objects_section(input), "0.030"));
  CHECK(has_cell(objects_section(input), "0.10"));
}

TEST_CASE("the section on uncertainty shows errors with U") {
  ReportInput input;
  input.unit = PressureUnit::kPsi;
  input.fit.rows = 1;
  input.fit.columns = 2;
  input.uncertainty.emplace();
  LevelUncertainty level;
  level.pressure_psi = 30.0;
  level.up = true;
  level.expanded_psi = {0.1, 0.2};
  level.median.error_psi = 0.1234;
  level.median.expanded_psi = 0.1;
  level.worst.taxel = 1;
  level.worst.error_psi = -0.2345;
  level.worst.expanded_psi = 0.2;
  input.uncertainty->levels = {level};
  CHECK(has_cell(uncertainty_section(input), "0.12 ± 0.10"));
  CHECK(has_cell(uncertainty_section(input), "−0.23 ± 0.20"));
}

TEST_CASE("page 1 shows error and U at four levels and at the worst one, and the largest error of all runs") {
  ReportInput input = shown_input();
  input.evaluation.max_error_taxel = 1;
  input.evaluation.max_error_psi = 3.456;
  Uncertainty& uncertainty = input.uncertainty.emplace();
  for (int i = 0; i < 7; ++i) {
    LevelUncertainty& level = uncertainty.levels.emplace_back();
    level.pressure_psi = 10.0 * i;
    level.up = true;
    level.expanded_psi = {0.25, i < 5 ? 1.0 : 1.5};  // 2 % of 60 psi are 1.2 psi
    level.median.error_psi = 0.1 * i;
    level.median.expanded_psi = 0.25;
    level.worst.error_psi = -0.1 * i;
    level.worst.expanded_psi = i == 3 ? 0.75 : 0.5;
  }
  for (const bool judged : {false, true}) {
    CAPTURE(judged);
    if (judged)
      input.judgement = by_hand::judgement_of({by_hand::judged_figure(12, Criterion::kMpe, 0.5, 1.0, Verdict::kPass)});
    const html::Markup page = verdict_section(input);
    for (const auto& [error, is_shown] : {std::pair{"0.00", true},
                                          {"0.10", false},
                                          {"0.20", true},
                                          {"0.30", true},
                                          {"0.40", true},
                                          {"0.50", false},
                                          {"0.60", true}})
      CHECK(has_cell(page, std::string(error) + " ± 0.25") == is_shown);
    CHECK(contains(page.value, "−0.30 ± 0.75"));
    CHECK(contains(page.value, in_psi(0.0, 1) + " to " + in_psi(40.0, 1)));
    CHECK(contains(page.value, in_psi(3.456, 2)));
  }
  input.held_out = {{"a later day", input.run, input.evaluation}};
  input.held_out[0].evaluation.max_error_psi = 5.678;
  CHECK(contains(verdict_section(input).value, in_psi(5.678, 2)));
  CHECK_FALSE(contains(verdict_section(input).value, in_psi(3.456, 2)));
}
