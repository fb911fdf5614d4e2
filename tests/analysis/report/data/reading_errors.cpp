// How wrong a reading is, by hand: 40 taxels whose |error| + U is 1, 2, ... of a unit.
#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/report/data/reading_figures.h"

using namespace tactbench::analysis;

namespace {

constexpr int kSome = 40;

void add_level(ConditionUncertainty& kind, double psi, bool up, double unit) {
  kind.pressure_psi.push_back(psi);
  kind.up.push_back(up);
  for (int i = 1; i <= kSome; ++i) {
    kind.error_psi.push_back(i % 2 == 0 ? 0.5 * unit * i : -0.5 * unit * i);
    kind.expanded_psi.push_back(0.5 * unit * i);
  }
}

ConditionUncertainty kind_of(UseCondition condition, double median_psi) {
  ConditionUncertainty kind;
  kind.condition = condition;
  kind.name = name_of(condition);
  kind.median_psi = median_psi;
  return kind;
}

// Within 2 % of 60 psi, 1.2 psi, 95 % of the taxels (|error| + U of 39 units) are where the unit is at most 0.0307 psi.
ReportInput read_at_levels() {
  ReportInput input;
  input.evaluation.full_scale_psi = 60.0;
  input.fit.taxels.resize(kSome);
  for (ModelTaxel& taxel : input.fit.taxels) taxel.status = TaxelStatus::kFitted;
  ConditionUncertainty worse = kind_of(UseCondition::kHeld, 1.0), better = kind_of(UseCondition::kFullSweeps, 0.5);
  for (const double psi : {0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0}) {
    add_level(worse, psi, true, psi == 20.0 ? 0.04 : 0.03);
    if (psi < 60.0) add_level(worse, psi, false, psi < 30.0 ? 0.03 : 0.05);
    add_level(better, psi, true, psi == 50.0 ? 0.2 : 0.001);
  }
  input.uncertainty.emplace();
  input.uncertainty->conditions = {better, worse};
  input.uncertainty->levels.resize(1);
  return input;
}

}  // namespace

TEST_CASE("reading errors: the worst kind of history is quoted, the worst taxel is over all kinds") {
  const ReadingFigures found = reading_figures(read_at_levels()).value();
  CHECK(found.kind == name_of(UseCondition::kHeld));
  REQUIRE(found.levels.size() == 13);
  const ReadingLevel& level = *found.level(20.0, true);
  CHECK(level.within_psi == Approx(0.04 * 39));  // place 38 of 0 to 39
  CHECK(level.median_expanded_psi == Approx(0.02 * 21));
  CHECK((level.worst == 39 && level.worst_psi == Approx(1.6)));
  CHECK(level.high_psi == Approx(0.04 * 40));  // of the even ones: error + U; place 39
  CHECK(level.low_psi == Approx(-0.04 * 37));  // of the odd ones: error - U; 39 is at place 0, 37 at place 1
  CHECK((found.worst.taxel == 39 && found.worst.pressure_psi == 50.0));
  CHECK(found.worst.kind == name_of(UseCondition::kFullSweeps));
}

TEST_CASE(
    "reading errors: the measuring interval is the longest unbroken sequence of levels, per direction and for both") {
  ReportInput input = read_at_levels();
  ReadingFigures found = reading_figures(input).value();
  CHECK((found.tolerance_psi == Approx(1.2) && !found.by_mpe));
  CHECK((found.span_up.any && found.span_up.low_psi == 30.0 && found.span_up.high_psi == 60.0));
  CHECK((found.span_down.any && found.span_down.low_psi == 0.0 && found.span_down.high_psi == 20.0));
  CHECK(found.headline_psi == Approx(3.0));  // 5 %: within 2 % both are from 0 to 10 psi alone
  CHECK((found.headline.low_psi == 0.0 && found.headline.high_psi == 60.0));
  JudgedFigure mpe;
  mpe.criterion = Criterion::kMpe;
  mpe.limit = 0.5;
  input.judgement.figures = {mpe};
  found = reading_figures(input).value();
  CHECK((found.by_mpe && found.tolerance_psi == 0.5 && !found.span_up.any && !found.headline.any));
}

TEST_CASE("reading errors: without a valid kind of history there is no U, without an assessment no result") {
  ReportInput input = read_at_levels();
  for (ConditionUncertainty& kind : input.uncertainty->conditions) kind.not_valid = "too few";
  input.uncertainty->levels[0].error_psi = {0.25, -0.5, std::nan("")};
  const ReadingFigures found = reading_figures(input).value();
  CHECK_FALSE(found.known());
  CHECK((found.levels.size() == 1 && found.levels[0].within_psi == 0.5 && found.levels[0].worst == 1));
  CHECK(std::isnan(found.levels[0].median_expanded_psi));
  CHECK_FALSE(found.headline.any);
  input.uncertainty.reset();
  CHECK_FALSE(reading_figures(input).has_value());
}
