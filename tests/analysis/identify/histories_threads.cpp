#include "analysis/identify/histories.h"

#include <catch2/catch.hpp>

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

}  // namespace

TEST_CASE("histories of a run: averaged ones to fit, measured ones to score, a mean taxel beside them") {
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
