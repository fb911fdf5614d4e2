// Page 1 states what a corrected indication is worth, with limits or without: range of use, error and U at some levels,
// the largest error and its taxel. The figures are those of the section "Uncertainty".
#include <catch2/catch.hpp>
#include <string>

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
      for (const bool up : {true, false}) {
        const LevelUncertainty* const level = uncertainty.level(levels[i], up);
        if (level == nullptr) continue;
        CHECK_THAT(page, Catch::Contains(shown_error(level->median)));
        CHECK_THAT(page, Catch::Contains(shown_error(level->worst)));
      }
    }
    CHECK_THAT(page, Catch::Contains(shown_error(worst->worst)));
    CHECK_THAT(page, Catch::Contains(range_within(uncertainty, true, 0.02 * levels.back(), kPageUnit).value));
    CHECK_THAT(page, Catch::Contains(range_within(uncertainty, false, 0.02 * levels.back(), kPageUnit).value));
  }
}

TEST_CASE("the largest error is found with its taxel and pressure, and page 1 has it") {
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
  CHECK_THAT(statement_of(input), Catch::Contains(html::pressure(input.evaluation.max_error_psi, kPageUnit, 2).value));
  input.held_out.push_back(held_out);
  CHECK_THAT(statement_of(input), Catch::Contains(html::pressure(found.max_error_psi, kPageUnit, 2).value));
}
