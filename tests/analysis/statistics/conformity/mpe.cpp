// The maximum permissible error of a reading: errors, U and shares of taxels that can be had on paper.
#include "analysis/statistics/conformity/mpe.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/statistics/numbers/moments.h"
#include "tests/analysis/support/straight_array.h"

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

// U of a reading: 0.5 psi of the first taxel and 1 psi of the second, going down at 20 psi 2 psi of the first.
Uncertainty readings() {
  Uncertainty out;
  for (const bool up : {true, false})
    for (const double pressure : {20.0, 40.0}) {
      LevelUncertainty level;
      level.pressure_psi = pressure;
      level.up = up;
      level.expanded_psi = {!up && pressure == 20.0 ? 2.0 : 0.5, 1.0, kNan};
      out.levels.push_back(level);
    }
  return out;
}

MpeFigure figure_of(const Limits::Mpe& mpe, const Uncertainty* known) {
  const Limits::Mpe list[] = {mpe};
  const std::vector<MpeFigure> figures =
      mpe_figures(straight_array::known_loop(), straight_array::straight_fit(), known, list, 1);
  REQUIRE(figures.size() == 1);
  return figures.front();
}

}  // namespace

TEST_CASE("mpe: the error that a share of the taxels does not exceed, at one level and over a span") {
  // Going down the taxels read -1 and 3 psi off at 40 psi, 6 (the mean of 5 and 7) and 1 at 20 psi; the third is dead.
  const Uncertainty known = readings();
  const MpeFigure span = figure_of({0.0, 60.0, 8.0, 0.95}, &known);
  CHECK(span.scope == "0-60 psi 95 %");
  CHECK(span.value_psi == Approx(6.0));
  CHECK(span.expanded_psi == Approx(2.0));
  // Half of the taxels: the second, 3 psi off at 40 psi and 4 with its U.
  const MpeFigure half = figure_of({0.0, 60.0, 8.0, 0.5}, &known);
  CHECK(half.value_psi == Approx(3.0));
  CHECK(half.expanded_psi == Approx(1.0));
  const MpeFigure level = figure_of({40.0, 40.0, 8.0, 0.95}, &known);
  CHECK(level.scope == "40 psi 95 %");
  CHECK(level.levels == 2);
  CHECK(level.value_psi == Approx(3.0));
  CHECK(level.expanded_psi == Approx(1.0));
  CHECK(std::isnan(figure_of({30.0, 30.0, 8.0, 0.95}, &known).value_psi));
  CHECK(std::isnan(figure_of({0.0, 60.0, 8.0, 0.95}, nullptr).expanded_psi));
}

TEST_CASE("mpe: conforms when |error| + U of the share of taxels lies inside, with words to either side of the limit") {
  using namespace straight_array;
  const Evaluation evaluation = evaluate(known_loop(), straight_fit(), 1);
  const Uncertainty known = readings();
  const auto judged_at = [&](double mpe_psi, DecisionRule rule, const Uncertainty* budgets) {
    Limits limits;
    limits.rule = rule;
    limits.mpe = {{0.0, 60.0, mpe_psi, 0.95}};
    const auto figures = mpe_figures(known_loop(), straight_fit(), budgets, limits.mpe, 1);
    const auto uncertainties = mpe_uncertainties(figures, evaluation.run);
    const auto rows = judge(evaluation, straight_fit(), limits, uncertainties, figures);
    CHECK(rows.back().criterion == "mpe");
    CHECK(rows.back().limit == mpe_psi);
    return rows.back().verdict;
  };
  const DecisionRule four = DecisionRule::kFourWay;
  CHECK(judged_at(8.001, four, &known) == "pass");
  CHECK(judged_at(7.999, four, &known) == "conditional pass");
  CHECK(judged_at(5.999, four, &known) == "conditional fail");
  CHECK(judged_at(3.999, four, &known) == "fail");
  CHECK(judged_at(7.999, DecisionRule::kGuarded, &known) == "fail");
  CHECK(judged_at(6.001, DecisionRule::kSimple, nullptr) == "pass");
  CHECK(judged_at(100.0, four, nullptr) == "inconclusive");
}
