// Models along histories by hand: what lies between branches, inputs that waver, measured turns; and a sensor's taxels.
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <vector>

#include "analysis/identify/sensor_model.h"
#include "analysis/models/poly.h"
#include "analysis/models/preisach.h"
#include "tests/analysis/support/alike.h"

using namespace tactbench::analysis;

namespace {

// Up 0, 1, 3 at 0, 30, 60; down 3, 2, 0 at 60, 30, 0.
const PreisachModel& small_film() {
  static const PreisachModel film(0.0, 60.0, 0.0, {1, 1, 1});
  return film;
}

std::vector<double> walked(const std::vector<double>& x, const std::vector<Branch>& branches) {
  return predict_history(small_film(), {"h", x, std::vector<double>(x.size(), 0.0), branches}, false);
}

// Up as the square of the share, down as twice the share less its square; 0 to 4.
std::shared_ptr<const PolyModel> bent_poly() {
  PolyParameters p;
  p.a[4] = 1.0;
  p.b[4] = -1.0;
  p.b[5] = 120.0;
  return std::make_shared<PolyModel>(p, 0.0, 60.0, 0.0, 4.0);
}

}  // namespace

TEST_CASE("histories are predicted branch by branch, and sample by sample where there is no branch") {
  check_alike(walked({0, 30, 60, 45, 30, 15}, {{0, 2, true}, {2, 5, false}}), {0, 1, 3, 2.5, 2, 1}, 1e-12);
  // A step back within a branch is no turn: from 45 to 30 it would be 1.5.
  check_alike(walked({0, 45, 30, 60, 30}, {{0, 3, true}, {3, 4, false}}), {0, 2, 1, 3, 2}, 1e-12);
  // Before the only branch, and after it, it is one.
  check_alike(walked({0, 45, 30, 15, 30, 60}, {{3, 5, true}}), {0, 2, 1.5, 1, 1.5, 3}, 1e-12);
  check_alike(walked({0, 45, 30, 15}, {{0, 1, true}}), {0, 2, 1.5, 1}, 1e-12);
  check_alike(walked({0, 45, 30, 15}, {}), {0, 2, 1.5, 1}, 1e-12);
  // A recording that begins to fall came from the top; one that falls later did not.
  check_alike(walked({30, 15}, {{0, 1, false}}), {2, 1}, 1e-12);
  check_alike(walked({30, 45, 15}, {{1, 2, false}}), {1, 2, 1}, 1e-12);
  CHECK(begins_falling({"h", {30, 15}, {}, {{0, 1, false}}}));
  CHECK_FALSE(begins_falling({"h", {30, 15}, {}, {{0, 1, true}}}));
  CHECK_FALSE(begins_falling({"h", {30, 45, 15}, {}, {{1, 2, false}}}));
  CHECK_FALSE(begins_falling({"h", {30, 15}, {}, {}}));
}

TEST_CASE("a measured turn is where the next branch begins, but of a free run, in the taxel's own outputs") {
  // Up to 30 the model has 1, where 2 was measured: down to 15, half of the way, three quarters of that.
  const History history{"h", {0, 30, 15}, {0, 2, 0}, {{0, 1, true}, {1, 2, false}}};
  check_alike(predict_history(*bent_poly(), history, false), {0, 1, 1.5}, 1e-12);
  check_alike(predict_history(*bent_poly(), history, true), {0, 1, 0.75}, 1e-12);
  ModelTaxel taxel;
  taxel.fit.model = bent_poly();
  taxel.zero = 0.5;
  taxel.gain = 2.0;
  History adjusted = history;
  for (double& y : adjusted.y) y = 0.5 + 2.0 * y;
  check_alike(taxel.predicted(adjusted, false), {0.5, 2.5, 3.5}, 1e-12);
  check_alike(taxel.predicted(adjusted, true), {0.5, 2.5, 2.0}, 1e-12);
}

TEST_CASE("a sensor's taxels by hand: the mean apart, those that are fitted, falling outputs, the external loop") {
  SensorModel model;
  model.source = "run 4";
  CHECK(model.array().empty());
  for (const int number : {3, 5, 7}) {
    ModelTaxel taxel;
    taxel.taxel = number;
    taxel.status = number == 5 ? TaxelStatus::kDead : TaxelStatus::kFitted;
    model.taxels.push_back(taxel);
  }
  CHECK(model.array().size() == 3);
  CHECK(model.fitted() == std::vector<std::size_t>{0, 2});
  CHECK(model.taxel(7).taxel == 7);
  CHECK_THROWS_WITH(model.taxel(4), Catch::Contains("4") && Catch::Contains("3"));
  model.taxels[2].taxel = kMeanTaxel;
  CHECK(model.array().size() == 2);
  CHECK(model.fitted() == std::vector<std::size_t>{0});
  ModelTaxel& taxel = model.taxels[0];
  taxel.zero = 0.5;
  taxel.gain = 2.0;
  CHECK(model.to_model(taxel, 4.5) == 2.0);
  CHECK(model.from_model(taxel, 2.0) == 4.5);
  model.falling = true;
  CHECK(model.to_model(taxel, -4.5) == 2.0);
  CHECK(model.from_model(taxel, 2.0) == -4.5);
  CHECK(taxel.full_scale() == 0.0);
  // As the model walks: 1 and 2 at 30, adjusted.
  taxel.fit.model = std::make_shared<PreisachModel>(small_film());
  set_loop(taxel, std::vector<double>{0, 30, 60});
  CHECK(taxel.ascending.y()[1] == Approx(2.5));
  CHECK(taxel.descending.y()[1] == Approx(4.5));
  CHECK(taxel.y0() == Approx(0.5));
  CHECK(taxel.yu() == Approx(6.5));
  CHECK(taxel.full_scale() == Approx(6.5));
  CHECK(ExternalBranch(taxel, true).output(30.0) == Approx(2.5));
  CHECK(ExternalBranch(taxel, false).output(30.0) == Approx(4.5));
  CHECK(ExternalBranch(taxel, true).input(4.5) == Approx(45.0));
  CHECK(ExternalBranch(taxel, false).input(4.5) == Approx(30.0));
  // As given, in the model's outputs.
  set_loop(taxel, std::vector<double>{0, 30, 60}, std::vector<double>{-9, 1, 2}, std::vector<double>{-9, 1.5, 2});
  CHECK(taxel.ascending.y()[1] == 2.5);
  CHECK(taxel.descending.y()[1] == 3.5);
  CHECK(taxel.full_scale() == 17.5);
}
