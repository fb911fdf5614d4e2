// Page 1 states what a corrected indication is worth, with limits or without: range of use, error and U at some levels,
// the largest error and its taxel. The figures are those of the section "Uncertainty".
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "analysis/report/page/figure.h"
#include "analysis/report/page/gum_numbers.h"
#include "analysis/report/report.h"
#include "analysis/report/sections/sections.h"
#include "tests/analysis/report/report_example.h"
#include "tests/analysis/report/report_page.h"
#include "tests/analysis/support/synthetic.h"

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

constexpr PressureUnit kPageUnit = PressureUnit::kKilopascal;

struct MeasuredArray {
  Dataset dataset;
  ReportInput input;
};

MeasuredArray measured_array() {
  MeasuredArray made{synthetic::run(synthetic::Array({.rows = 4, .columns = 4, .sensor_seed = 4}),
                                    {.seed = 12, .noise_v = 0.004, .repeats = 3}),
                     example::example_input()};
  ReportInput& input = made.input;
  input.fit = fit_array(made.dataset);
  input.evaluation = evaluate(made.dataset, input.fit);
  input.held_out.clear();
  input.verdicts.clear();
  input.uncertainty = assess_uncertainty(made.dataset, input.fit, input.run);
  return made;
}

// Of page 1: what stands before the section "Identification".
std::string statement_of(const ReportInput& input) {
  const std::string page = render_report(input).html;
  require_well_formed(page);
  const std::size_t from = page.find("id=\"verdicts\""), end = page.find("id=\"identification\"");
  REQUIRE(from != std::string::npos);
  REQUIRE(end != std::string::npos);
  return page.substr(from, end - from);
}

std::string shown_error(const Budget& budget) {
  return gum_pressure(budget.error_psi, budget.expanded_psi, kPageUnit).value;
}

}  // namespace

TEST_CASE("page 1 has error and U at four levels and at the worst one, as the section on uncertainty has") {
  MeasuredArray made = measured_array();
  ReportInput& input = made.input;
  const Uncertainty& uncertainty = *input.uncertainty;
  const std::vector<double> levels = level_pressures(uncertainty);
  REQUIRE(levels.size() > 8);
  const LevelUncertainty* worst = &uncertainty.levels.front();
  for (const LevelUncertainty& level : uncertainty.levels)
    if (level.worst.expanded_psi > worst->worst.expanded_psi) worst = &level;

  for (const bool judged : {false, true}) {
    if (judged) {
      Limits limits;
      limits.worst_taxel_error_psi = 60.0;
      input.verdicts = judge(input.evaluation, input.fit, limits);
    }
    const std::string page = statement_of(input);
    const std::size_t n = levels.size() - 1;
    for (const std::size_t i : {std::size_t{0}, n / 3, 2 * n / 3, n}) {
      INFO(levels[i]);
      CHECK_THAT(page, Catch::Contains("<th scope=\"row\" class=\"n\">" + html::in_unit(levels[i], kPageUnit, 1).value +
                                       "</th>"));
      for (const bool up : {true, false}) {
        const LevelUncertainty* const level = uncertainty.level(levels[i], up);
        if (level == nullptr) continue;
        CHECK_THAT(page, Catch::Contains(shown_error(level->median)));
        CHECK_THAT(page, Catch::Contains(shown_error(level->worst)));
      }
    }
    CHECK_THAT(page, Catch::Contains("▲ " + shown_error(worst->worst)));
    CHECK_THAT(page, Catch::Contains(fmt::format("row {}, column {}", worst->worst.taxel / 4, worst->worst.taxel % 4)));
    CHECK_THAT(page, Catch::Contains(range_within(uncertainty, true, 0.02 * levels.back(), kPageUnit).value));
    CHECK_THAT(page, Catch::Contains(range_within(uncertainty, false, 0.02 * levels.back(), kPageUnit).value));
  }
}

TEST_CASE("the largest error is found with its taxel and pressure, and page 1 names both and the run") {
  MeasuredArray made = measured_array();
  ReportInput& input = made.input;
  Dataset spoilt = made.dataset;
  Repeat& repeat = spoilt.sequences.front().repeats[1];
  const std::size_t step = repeat.steps.size() / 3;
  repeat.volts[step * 16 + 9] += 1.5;
  HeldOut held_out{"held-out run", example::example_run(14), evaluate(spoilt, input.fit)};
  const Evaluation& found = held_out.evaluation;
  CHECK(found.max_error_taxel == 9);
  CHECK(found.max_error_at_psi == repeat.steps[step].reference_psi);
  CHECK(found.max_error_psi > 2.0 * input.evaluation.max_error_psi);

  const auto named = [](const Evaluation& e, const char* run) {
    return fmt::format("{}: taxel row {}, column {}, at {}, {}", html::pressure(e.max_error_psi, kPageUnit, 2).value,
                       e.max_error_taxel / 4, e.max_error_taxel % 4,
                       html::pressure(e.max_error_at_psi, kPageUnit, 1).value, run);
  };
  CHECK_THAT(statement_of(input), Catch::Contains(named(input.evaluation, "own run (calibration data)")));
  input.held_out.push_back(held_out);
  const std::string page = statement_of(input);
  CHECK_THAT(page, Catch::Contains(named(found, "held-out run")));
  CHECK_THAT(page, !Catch::Contains(named(input.evaluation, "own run (calibration data)")));
}

TEST_CASE("without an assessment page 1 says so, and still has the largest error") {
  ReportInput input = example::example_input();
  input.uncertainty.reset();
  const std::string page = statement_of(input);
  CHECK_THAT(page, Catch::Contains("U was not assessed"));
  CHECK_THAT(page, !Catch::Contains("error and U at some levels"));
  CHECK_THAT(page, Catch::Contains("taxel row 1, column 4, at 386.1"));
}

TEST_CASE(
    "hysteresis maps of indication and corrected indication each have a scale, up to the next 5 % of full scale") {
  ReportInput input = example::example_input();
  const double full_v = input.evaluation.full_scale_v, full_psi = input.evaluation.full_scale_psi;
  for (LevelFigures& level : input.evaluation.levels) {
    level.raw_up_v.assign(256, 1.0);
    level.raw_down_v.assign(256, 1.0);
    level.comp_up_psi.assign(256, 20.0);
    level.comp_down_psi.assign(256, 20.0);
    level.raw_down_v[9] += 0.62 * full_v;
    level.comp_down_psi[9] += 0.07 * full_psi;
  }
  const std::string page = frames_section(input).value;
  const auto high_end = [&page](const std::string& title) {
    const std::size_t from = page.find("</svg>", page.find("<title>" + title + "</title>")) + 7;
    return page.substr(from, page.find('<', from) - from);
  };
  CHECK(high_end("Colour scale of the hysteresis of the indication") == "65 % FS");
  CHECK(high_end("Colour scale of the hysteresis of the corrected indication") == "10 % FS");
  // The tenth cell of each hysteresis map: 62 of 65 %, 7 of 10 %. On one scale the second would be as blue as the rest.
  const auto colour_of_tenth = [&page](const std::string& what) {
    const std::size_t map = page.find("<title>" + what + ", hysteresis, "), cell = page.find("d=\"M9 0h", map);
    REQUIRE(page.find("</svg>", map) > cell);
    return page.substr(page.rfind("fill=\"", cell) + 6, 7);
  };
  const auto middle = [](double share) { return cividis((std::floor(32.0 * share) + 0.5) / 32.0); };  // of 32 colours
  CHECK(colour_of_tenth("Indication") == middle(0.62 / 0.65));
  CHECK(colour_of_tenth("Corrected indication") == middle(0.07 / 0.10));
}
