#include "analysis/identify/histories.h"

#include <catch2/catch.hpp>

#include "analysis/identify/identifier.h"
#include "tests/analysis/support/synthetic.h"

using namespace synthetic;

namespace {

Dataset small_run() {
  ArrayOptions options;
  options.rows = options.columns = 2;
  RunOptions run_options;
  run_options.repeats = 2;
  return run(Array(options), run_options);
}

TableSeries loop_table(double sign) {
  TableSeries series{"1", 0, {}, {}};
  for (const double x : {0.0, 1.0, 2.0, 3.0, 2.0, 1.0, 0.0}) {
    series.input.push_back(x);
    series.output.push_back(sign * (x + (series.input.size() > 4 ? 0.5 * x * (3 - x) : 0.0)));
  }
  return series;
}

std::string refusal(const std::vector<TableSeries>& series) {
  try {
    const Histories histories = histories_of(series, "t.csv");
    (void)prepare("elam", fit_data_of(histories.taxels.back(), {}));
  } catch (const AnalysisError& error) {
    return error.id();
  }
  return "accepted";
}

}  // namespace

TEST_CASE("a run gives averaged histories to fit, measured ones to score, and the mean taxel") {
  const Dataset dataset = small_run();
  const Histories histories = histories_of(dataset);
  REQUIRE(histories.taxels.size() == 5);
  CHECK(histories.sequences == std::vector<std::string>{"descending", "ascending"});
  const TaxelHistories& first = histories.taxels.front();
  CHECK((first.fit.size() == 2 && first.score.size() == 4 && first.usable()));
  CHECK(first.fit[0].x[3] == dataset.sequences[0].repeats[0].steps[3].setpoint_psi);
  CHECK(first.score[1].x[3] == dataset.sequences[0].repeats[1].steps[3].reference_psi);
  CHECK(first.score[1].y[3] == dataset.sequences[0].repeats[1].volts[3 * 4]);
  const TaxelHistories& mean = histories.taxels.back();
  CHECK(mean.taxel == kMeanTaxel);
  double sum = 0.0;
  for (std::size_t i = 0; i < 4; ++i) sum += histories.taxels[i].fit[0].y[7];
  CHECK(mean.fit[0].y[7] == Approx(sum / 4));
  CHECK(mean.noise == Approx(first.noise / 2));
}

TEST_CASE("[A20] outputs of a falling sensor are negated") {
  const Histories rising = histories_of({loop_table(1.0)}, "t.csv"),
                  falling = histories_of({loop_table(-1.0)}, "t.csv");
  CHECK_FALSE(rising.falling);
  CHECK(falling.falling);
  CHECK(falling.taxels[0].fit[0].y == rising.taxels[0].fit[0].y);
}

TEST_CASE("a wavering measured input is not a turn, a reversed one is") {
  TableSeries series = loop_table(1.0);
  series.input[2] = 0.999;  // 0.001 of a span of 3 back
  const Histories histories = histories_of({series}, "t.csv");
  REQUIRE(histories.taxels[0].fit[0].branches.size() == 2);
  CHECK(histories.taxels[0].fit[0].branches[0].last == 3);
  series.input[2] = 0.9;
  CHECK(histories_of({series}, "t.csv").taxels[0].fit[0].branches.size() == 4);
}

TEST_CASE("tables without a loop are refused, each with its reason") {
  CHECK(refusal({loop_table(1.0)}) == "accepted");
  CHECK(refusal({{"1", 0, {0, 1, 2}, {0, 1, 2}}}) == "TB-TABLE-SHORT");
  CHECK(refusal({{"1", 0, {1, 1, 1, 1}, {0, 1, 2, 3}}}) == "TB-TABLE-CONSTANT");
  CHECK(refusal({{"1", 0, {0, 1, 2, 1, 0}, {1, 1, 1, 1, 1}}}) == "TB-ANALYSIS-NO-TAXEL");
  CHECK(refusal({{"1", 0, {0, 1, 2, 3}, {0, 1, 2, 3}}}) == "TB-ANALYSIS-NO-LOOP");  // one branch
}

TEST_CASE("a missing sequence is refused, and the error lists the existing ones") {
  const Histories histories = histories_of(small_run());
  CHECK(fit_data_of(histories.taxels[0], {"ascending"}).histories.size() == 1);
  try {
    (void)fit_data_of(histories.taxels[0], {"sideways"});
    FAIL("accepted");
  } catch (const AnalysisError& error) {
    CHECK(error.id() == "TB-MODEL-SEQUENCE");
    CHECK_THAT(error.what(), Catch::Contains("\"descending\", \"ascending\""));
  }
}
