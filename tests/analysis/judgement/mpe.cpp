// The maximum permissible error of a reading: judged to either side of the limit.
#include "analysis/judgement/mpe.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/judgement/judgement.h"
#include "analysis/statistics/numbers/moments.h"
#include "tests/analysis/support/straight_array.h"

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

// U of a reading: 0.5 psi of the first taxel and 1 psi of the second, going down at 20 psi 8 psi of the first.
Uncertainty readings() {
  ConditionUncertainty kind;
  kind.runs = {2};
  kind.pressure_psi = {20.0, 40.0, 20.0, 40.0};
  kind.up = {true, true, false, false};
  kind.expanded_psi = {0.5, 1.0, kNan, 0.5, 1.0, kNan, 8.0, 1.0, kNan, 1.0, 3.0, kNan};
  kind.error_psi.assign(12, 0.0);
  Uncertainty out;
  out.conditions = {kind};
  return out;
}

}  // namespace

TEST_CASE("mpe: conforms when |error| + U of the share of taxels lies inside, with words to either side of the limit") {
  using namespace straight_array;
  const Uncertainty known = readings();
  const auto judged_at = [&](double mpe_psi, DecisionRule rule, const Uncertainty* of_readings) {
    Limits limits;
    limits.rule = rule;
    limits.mpe = {{0.0, 60.0, mpe_psi, 0.95}};
    Evidence evidence;
    evidence.runs.resize(1);
    evidence.runs[0].figures = judged_mpe(mpe_figures(known_loop(), straight_fit(), of_readings, limits.mpe, 1));
    return std::string(to_string(judge(evidence, limits).figures.back().verdict));
  };
  const DecisionRule four = DecisionRule::kFourWay;
  CHECK(judged_at(8.001, four, &known) == "pass");
  CHECK(judged_at(7.999, four, &known) == "conditional pass");
  CHECK(judged_at(5.999, four, &known) == "conditional fail");
  CHECK(judged_at(3.999, four, &known) == "fail");
  CHECK(judged_at(7.999, DecisionRule::kGuarded, &known) == "fail");
  CHECK(judged_at(6.001, DecisionRule::kSimple, nullptr) == "pass");
  CHECK(judged_at(100.0, four, nullptr) == "inconclusive");
  // By default, too: no reading passes by its mean error alone, and one fails by it.
  CHECK(judged_at(100.0, DecisionRule::kDefault, nullptr) == "inconclusive");
  CHECK(judged_at(5.999, DecisionRule::kDefault, nullptr) == "fail");
  CHECK(judged_at(8.001, DecisionRule::kDefault, &known) == "pass");
}
