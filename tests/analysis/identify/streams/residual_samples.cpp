// Which samples a residual is made of: unknown starts do not count, nor does what comes after so many.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "analysis/identify/residuals.h"
#include "analysis/models/preisach.h"

using namespace tactbench::analysis;

namespace {

// Up 0, 1, 3 at 0, 30, 60; down 3, 2, 0 at 60, 30, 0. Its loop is taken as straight, so that all levels weigh the same.
SensorModel film_alone(double loop_low = 0.0) {
  SensorModel model;
  model.model = "preisach";
  ModelTaxel& taxel = model.taxels.emplace_back();
  taxel.taxel = 0;
  taxel.status = TaxelStatus::kFitted;
  taxel.fit.model = std::make_shared<PreisachModel>(0.0, 60.0, 0.0, std::vector<double>{1, 1, 1});
  taxel.fit.full_scale = 3.0;
  taxel.loop_low = loop_low;
  const std::vector<double> x{0.0, 60.0}, y{0.0, 3.0};
  taxel.ascending = taxel.descending = PatternCurve(x, y, 0.0, 3.0);
  return model;
}

// Mean square of what counts, by a recording that errs by 3 psi throughout; no inner branch is there.
double counted2(const SensorModel& model, std::size_t taxel) {
  const double residual = model.taxels[taxel].residual_psi, known = between_external_branches(model.taxels[taxel]);
  Histories three;
  three.taxels.resize(1);
  three.taxels[0].score = {{"a", {57, 57}, {3, 3}, {}, {}, {}}};
  SensorModel like = model;
  like.taxels = {model.taxels[taxel]};
  find_residuals(three, {}, 1, like);
  const double factor2 = like.taxels[0].residual_psi * like.taxels[0].residual_psi / (9.0 + known);
  return residual > 0.0 ? residual * residual / factor2 - known : 0.0;
}

double counted_of(SensorModel model, const std::vector<History>& scored) {
  Histories histories;
  TaxelHistories& own = histories.taxels.emplace_back();
  own.taxel = 0;
  own.score = scored;
  find_residuals(histories, {}, 1, model);
  return counted2(model, 0);
}

}  // namespace

TEST_CASE("residual samples: of a recording that begins in mid-branch those count whose history is known") {
  // 1 V is 30 psi of a rise and 15 of a fall; from the top on 2 V are 30 psi: 6 psi off.
  const History middle{"a", {99, 60, 36}, {1, 3, 2}, {}, {}, {}};
  CHECK(counted_of(film_alone(), {middle}) == Approx(36.0 / 2.0));
  // A hundredth of the full scale is at rest: of three samples, the first 9.4 psi off.
  const History rest{"a", {10, 60, 36}, {0.02, 3, 2}, {}, {}, {}};
  CHECK(counted_of(film_alone(), {rest}) == Approx((9.4 * 9.4 + 36.0) / 3.0));
  // Each recording begins anew; one without samples is passed over.
  const History none{"b", {}, {}, {}, {}, {}};
  CHECK(counted_of(film_alone(), {middle, none, middle}) == Approx(36.0 / 2.0));
  CHECK(counted_of(film_alone(), {none}) == 0.0);
  CHECK(counted_of(film_alone(), {}) == 0.0);
}

TEST_CASE("residual samples: the first 20,000 of a taxel count, of all its recordings") {
  History first{"a", {}, {}, {}, {}, {}};
  for (int i = 0; i < 19'999; ++i) {
    first.x.push_back(i % 2 == 0 ? 2.0 : 60.0);  // 2 psi off at the lowest output
    first.y.push_back(i % 2 == 0 ? 0.0 : 3.0);
  }
  const History second{"b", {9, 90, 90}, {0, 3, 3}, {}, {}, {}};
  CHECK(counted_of(film_alone(), {first, second}) == Approx((10'000 * 4.0 + 81.0) / 20'000));
}

TEST_CASE("residual samples: a stream that has no answer leaves nothing known, and other taxels their own") {
  SensorModel model = film_alone();
  model.taxels.push_back(model.taxels[0]);
  Histories histories;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double last : {nan, 3.0}) {
    TaxelHistories& own = histories.taxels.emplace_back();
    own.score = {{"a", {0, 57}, {0, last}, {}, {}, {}}};
  }
  find_residuals(histories, {}, 1, model);
  CHECK(counted2(model, 0) == Approx(0.0).margin(1e-9));
  CHECK(counted2(model, 1) == Approx(9.0 / 2.0));
  // More taxels than there are histories of: nothing is known of any.
  histories.taxels.pop_back();
  model.taxels[1].residual_psi = 5.0;
  find_residuals(histories, {}, 1, model);
  CHECK(model.taxels[1].residual_psi == 5.0);
}
