// The maximum permissible error of a reading: judged to either side of the limit.
#include <catch2/catch.hpp>
#include <cmath>
#include <tuple>
#include <utility>

#include "analysis/judgement/judgement.h"
#include "analysis/judgement/mpe.h"
#include "analysis/statistics/numbers/moments.h"
#include "tests/analysis/support/alike.h"
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

TEST_CASE("mpe: a reading conforms if error and U of the share of taxels are within the limit, by each rule") {
  using namespace straight_array;
  const Uncertainty known = readings();
  const auto judged_at = [&](double mpe_psi, DecisionRule rule, const Uncertainty* is_per_reading) {
    Limits limits;
    limits.rule = rule;
    limits.mpe = {{0.0, 60.0, mpe_psi, 0.95}};
    Evidence evidence;
    evidence.runs.resize(1);
    evidence.runs[0].figures = judged_mpe(mpe_figures(known_loop(), straight_fit(), is_per_reading, limits.mpe, 1));
    return std::string(to_string(judge(evidence, limits).figures.back().verdict));
  };
  struct Row {
    double mpe_psi;
    DecisionRule rule;
    const Uncertainty* known;
    const char* verdict;
  };
  using enum DecisionRule;
  const Row rows[] = {{8.001, kFourWay, &known, "pass"},
                      {7.999, kFourWay, &known, "conditional pass"},
                      {5.999, kFourWay, &known, "conditional fail"},
                      {3.999, kFourWay, &known, "fail"},
                      {7.999, kGuarded, &known, "fail"},
                      {6.001, kSimple, nullptr, "pass"},
                      {100.0, kFourWay, nullptr, "inconclusive"},
                      // By default, too: no reading passes by its mean error alone, and one fails by it.
                      {100.0, kDefault, nullptr, "inconclusive"},
                      {5.999, kDefault, nullptr, "fail"},
                      {8.001, kDefault, &known, "pass"}};
  for (const Row& row : rows) {
    CAPTURE(row.mpe_psi, to_string(row.rule), row.known != nullptr);
    CHECK(judged_at(row.mpe_psi, row.rule, row.known) == row.verdict);
  }
}

// U of a reading at levels beside and between those it is stated for, the worst of several kinds, and shares of taxels.

namespace mpe_levels {
namespace {

// Of each branch and level another U of the two taxels.
ConditionUncertainty kind_of(std::vector<double> expanded_psi, std::vector<std::int64_t> runs = {2}) {
  ConditionUncertainty out;
  out.name = "full sweeps";
  out.runs = std::move(runs);
  out.pressure_psi = {20, 40, 20, 40};
  out.up = {true, true, false, false};
  for (std::size_t level = 0; level < 4; ++level)
    out.expanded_psi.insert(out.expanded_psi.end(), {expanded_psi[2 * level], expanded_psi[2 * level + 1], kNan});
  out.error_psi.assign(12, 0.0);
  return out;
}

Uncertainty unequal() {
  Uncertainty out;
  out.conditions = {kind_of({1, 2, 3, 5, 7, 11, 13, 17})};
  return out;
}

MpeFigure figure_at(double low_psi, double high_psi, double share, const Uncertainty& known, const Dataset& data) {
  const Limits::Mpe list[] = {{low_psi, high_psi, 8.0, share}};
  const std::vector<MpeFigure> figures = mpe_figures(data, straight_array::straight_fit(), &known, list, 1);
  REQUIRE(figures.size() == 1);
  return figures.front();
}

void check_shares(double psi, const std::vector<double>& value_psi, const std::vector<double>& expanded_psi,
                  const Dataset& data = straight_array::known_loop()) {
  INFO("at " << psi << " psi");
  const Uncertainty known = unequal();
  for (const std::size_t taxels : {1U, 2U}) {
    const MpeFigure figure = figure_at(psi, psi, taxels == 1 ? 0.5 : 0.95, known, data);
    CHECK(figure.value_psi == Approx(value_psi[taxels - 1]));
    CHECK(figure.expanded_psi == Approx(expanded_psi[taxels - 1]));
  }
}

}  // namespace

TEST_CASE("mpe: U is linear between levels, constant beyond them, and the larger of both branches counts") {
  // Mean errors on the way down: 1 and 3 psi at 40 psi, 6 and 1 at 20 psi; U was counted with them in it.
  check_shares(20, {1, 6}, {7 - 1, 11 - 6});
  check_shares(40, {1, 3}, {13 - 1, 17 - 3});
  check_shares(0, {0, 0}, {7, 11});  // U at 20 psi, unloading
  check_shares(60, {0, 0}, {3, 5});  // the turn belongs to loading: U at 40 psi
  using namespace straight_array;
  const std::vector<Sample> steps{{0, 0}, {30, 30}, {60, 60}, {30, 30}, {0, 0}};
  check_shares(30, {1, 2}, {10 - 1, 14 - 2},
               dataset_of({{"loop", {repeat_of(steps, {{0, 30, 60, 32, 0}, {0, 30, 60, 31, 0}})}}}));
}

TEST_CASE("mpe: the worst valid kind of history that is based on the judged run counts, with its known error") {
  const Dataset data = straight_array::known_loop();  // run 2
  const auto with = [&](ConditionUncertainty other) {
    Uncertainty known = unequal();
    known.conditions.push_back(std::move(other));
    return figure_at(20, 20, 0.95, known, data).expanded_psi;
  };
  const ConditionUncertainty wide = kind_of({30, 30, 30, 30, 30, 30, 30, 30});
  CHECK(with(wide) == Approx(30 - 6));
  ConditionUncertainty shifted = wide;
  shifted.error_psi.assign(12, -2.0);
  CHECK(with(shifted) == Approx(32 - 6));
  ConditionUncertainty not_valid = wide, of_another_run = kind_of({30, 30, 30, 30, 30, 30, 30, 30}, {7});
  not_valid.not_valid = "two histories leave it open";
  CHECK(with(not_valid) == Approx(11 - 6));
  CHECK(with(of_another_run) == Approx(11 - 6));
  // Held pressures that were reached upward alone say nothing of the way down.
  CHECK(with(kind_of({30, 30, 30, 30, kNan, kNan, kNan, kNan})) == Approx(30 - 6));
  Uncertainty none;
  CHECK(std::isnan(figure_at(20, 20, 0.95, none, data).expanded_psi));
  none.conditions = {not_valid, of_another_run};
  const MpeFigure figure = figure_at(20, 20, 0.95, none, data);
  CHECK((std::isnan(figure.expanded_psi) && figure.value_psi == Approx(6.0)));
  CHECK(figure.not_known.find(not_valid.not_valid) != std::string::npos);
  // U that is less than what the judged frames err by in the mean counts as that.
  Uncertainty narrow;
  narrow.conditions = {kind_of({0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1})};
  CHECK(figure_at(20, 20, 0.95, narrow, data).expanded_psi == Approx(0.0).margin(1e-12));
}

TEST_CASE("mpe: errors are means of the signed frame errors per level and branch") {
  using namespace straight_array;
  // At 30 psi upward +4 and -2 of the first taxel: 1 in the mean; +1 and +2 of the second.
  const std::vector<Sample> steps{{0, 0}, {30, 30}, {60, 60}};
  const Dataset data = dataset_of(
      {{"up", {repeat_of(steps, {{0, 34, 60}, {0, 31, 60}}), repeat_of(steps, {{0, 28, 60}, {0, 32, 60}})}}});
  CHECK(figure_at(30, 30, 0.5, unequal(), data).value_psi == Approx(1.0));
  CHECK(figure_at(30, 30, 0.95, unequal(), data).value_psi == Approx(1.5));
  CHECK(figure_at(30, 30, 0.95, unequal(), data).levels == 1);
}

TEST_CASE("mpe: a taxel without U at a level has none, and neither has a share that needs it") {
  Uncertainty known = unequal();
  known.conditions[0].expanded_psi[3 * 2 + 1] = kNan;  // 20 psi down of the second
  const Dataset data = straight_array::known_loop();
  const MpeFigure first = figure_at(20, 20, 0.5, known, data);
  CHECK(first.value_psi == Approx(1.0));
  CHECK(first.expanded_psi == Approx(7 - 1));
  CHECK(std::isnan(figure_at(20, 20, 0.95, known, data).expanded_psi));
  CHECK(figure_at(20, 20, 0.95, known, data).value_psi == Approx(6.0));
  CHECK(std::isnan(figure_at(0, 60, 0.95, known, data).expanded_psi));
}

TEST_CASE("mpe: levels of a span are counted per branch, with both ends and 0.01 psi beyond") {
  const Dataset data = straight_array::known_loop();
  using Row = std::tuple<double, double, int, double>;  // span, levels in it, the value there
  const Row rows[] = {{0, 60, 7, 6.0},      {20, 40, 4, 6.0},         {20.009, 39.991, 4, 6.0}, {20.011, 40, 2, 3.0},
                      {20, 39.989, 2, 6.0}, {20.009, 20.009, 2, 6.0}, {25, 35, 0, kNan}};
  for (const auto& [low, high, levels, value_psi] : rows) {
    CAPTURE(low, high);
    const MpeFigure figure = figure_at(low, high, 0.95, unequal(), data);
    CHECK(figure.levels == levels);
    check_alike({figure.value_psi}, {value_psi});
  }
}

TEST_CASE("mpe: the smallest share is one taxel, and without uncertainty budgets there is no U") {
  CHECK(figure_at(20, 20, 0.0, unequal(), straight_array::known_loop()).value_psi == Approx(1.0));
  CHECK(figure_at(20, 20, 1.0, unequal(), straight_array::known_loop()).value_psi == Approx(6.0));
  CHECK(scope_of({2.5, 2.5, 1.0, 0.995}) == Scope::span(2.5, 2.5, 0.995));
  CHECK(scope_of({2.5, 7.25, 1.0, 1.0}).kind == Scope::Kind::kSpan);
  CHECK(mpe_figures(straight_array::known_loop(), straight_array::straight_fit(), nullptr, {}).empty());
  const Limits::Mpe whole[] = {{0.0, 60.0, 8.0, 0.95}};
  const auto without = mpe_figures(straight_array::known_loop(), straight_array::straight_fit(), nullptr, whole, 1);
  REQUIRE(without.size() == 1);
  CHECK(without[0].value_psi == Approx(6.0));
  CHECK(std::isnan(without[0].expanded_psi));
}

TEST_CASE("mpe: a judged value states U with half of it as combined and k = 2, or why U is unknown") {
  const Scope first = Scope::span(0, 40, 0.95), second = Scope::span(0, 60, 0.95);
  const MpeFigure figures[] = {{first, 3.0, 1.5, 2, "full sweeps", ""}, {second, 4.0, kNan, 0, "", "none valid"}};
  const std::vector<Figure> all = judged_mpe(figures);
  REQUIRE(all.size() == 2);
  CHECK((all[0].criterion == Criterion::kMpe && all[0].scope == first && all[0].value == 3.0));
  CHECK((all[0].u.expanded == 1.5 && all[0].u.combined == 0.75 && all[0].u.factor == 2.0));
  CHECK((all[0].u.missing.empty() && all[0].u.dof == kInfiniteDof));
  CHECK((all[1].scope == second && std::isnan(all[1].u.expanded) && all[1].u.missing == "none valid"));
}

}  // namespace mpe_levels
