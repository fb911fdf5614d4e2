// Four models side by side, by hand where the model is a straight line, and by their own definition where it was
// identified here.
#include "analysis/statistics/scoring/model_comparison.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/models/monotone.h"
#include "tests/analysis/support/alike.h"
#include "tests/analysis/support/straight_array.h"

using namespace straight_array;

namespace {

void check_values(const std::vector<double>& found, const std::vector<double>& wanted) {
  check_alike(found, wanted, 1e-9);
}

constexpr ChosenTaxels kChosen{1, 1, 0};  // best, median, worst

struct Errors {
  double j = 0.0, mean = 0.0, max = 0.0;
};
// Of the samples behind the turning points of known_loop(): 1 to 3 up, 4 to 6 down.
Errors errors_of(const std::vector<double>& model, const std::vector<double>& measured) {
  Errors errors;
  for (std::size_t i = 1; i < 7; ++i) {
    const double off = std::abs(model.at(i) - measured.at(i));
    errors.j += off * off;
    errors.mean += off / 6.0;
    errors.max = std::max(errors.max, off);
  }
  return errors;
}

}  // namespace

TEST_CASE("models side by side: the straight line's outputs and errors by hand, for the mean, best and worst taxel") {
  const ModelComparison found = compare_models(known_loop(), straight_fit(), kChosen, 1);
  REQUIRE(found.taxels.size() == 3);  // the median is the best again
  const ComparedTaxel &mean = found.taxels[0], &best = found.taxels[1], &worst = found.taxels[2];
  CHECK((mean.taxel.taxel == kMeanTaxel && best.taxel.taxel == 1 && worst.taxel.taxel == 0));
  CHECK(mean.full_scale_v == Approx(4.5));
  CHECK(best.full_scale_v == Approx(6.0));
  CHECK(worst.full_scale_v == Approx(3.0));
  for (const ComparedTaxel& taxel : found.taxels) {
    REQUIRE(taxel.sequences.size() == 1);
    CHECK(taxel.sequences[0].name == "loop");
    check_values(taxel.sequences[0].pressure_psi, {0, 20, 40, 60, 40, 20, 0});
    REQUIRE(taxel.sequences[0].models.size() == 4);
  }
  // Moved from 41 psi to the set-point. Down the first taxel reads 39 and 26 psi, the second 43 and 21.
  check_values(mean.sequences[0].measured_v, {0, 1.5, 3.0, 4.5, 3.125, 1.7, 0});
  check_values(best.sequences[0].measured_v, {0, 2, 4, 6, 4.3, 2.1, 0});
  check_values(worst.sequences[0].measured_v, {0, 1, 2, 3, 1.95, 1.3, 0});
  const ComparedModel& elam = mean.sequences[0].models[3];
  CHECK(elam.model == "elam");
  CHECK(elam.failed.empty());
  CHECK(elam.samples == 6);
  check_values(elam.model_v, {0, 1.5, 3.0, 4.5, 3.0, 1.5, 0});
  CHECK(elam.j_v2 == Approx(0.125 * 0.125 + 0.2 * 0.2));
  CHECK(elam.mean_error_v == Approx(0.325 / 6));
  CHECK(elam.max_error_v == Approx(0.2));
  CHECK(elam.mean_running_v == Approx(0.325 / 6));
  CHECK(elam.max_running_v == Approx(0.2));
  CHECK(elam.parameters.size() == 5);
  CHECK(elam.operations_per_sample == straight_fit().mean_taxel().fit.model->operations_per_sample());
  CHECK(worst.sequences[0].models[3].mean_error_v == Approx((0.05 + 0.3) / 6));
  CHECK(best.sequences[0].models[3].max_error_v == Approx(0.3));
}

TEST_CASE("models side by side: each identified model's errors are those of its own outputs, parameters of its own") {
  const ModelComparison found = compare_models(known_loop(), straight_fit(), kChosen, 1);
  for (const ComparedTaxel& taxel : found.taxels) {
    const ComparedSequence& sequence = taxel.sequences[0];
    for (std::size_t m = 0; m < 3; ++m) {
      const ComparedModel& model = sequence.models[m];
      INFO(taxel.taxel.title << ", " << kComparedModels[m]);
      CHECK(model.model == kComparedModels[m]);
      REQUIRE(model.failed.empty());
      const Errors errors = errors_of(model.model_v, sequence.measured_v);
      CHECK(model.samples == 6);
      CHECK(model.j_v2 == Approx(errors.j));
      CHECK(model.mean_error_v == Approx(errors.mean));
      CHECK(model.max_error_v == Approx(errors.max));
      CHECK(model.mean_running_v <= model.max_running_v);
      CHECK(model.operations_per_sample > 0);
      CHECK_FALSE(model.parameters.empty());
    }
  }
}

TEST_CASE(
    "models side by side: ELAM's set is of all sequences where there are two, GPI's conventions are no findings") {
  Dataset two = known_loop();
  two.sequences.push_back(two.sequences[0]);
  two.sequences[1].name = "again";
  for (const bool several : {false, true}) {
    const ModelComparison found = compare_models(several ? two : known_loop(), straight_fit(), kChosen, 1);
    for (const ComparedTaxel& taxel : found.taxels)
      for (const ComparedSequence& sequence : taxel.sequences)
        for (const ComparedModel& model : sequence.models) CHECK(model.joint == (several && model.model == "elam"));
    // a0 e^a2, b0 e^b2 and one common scale: 8 of 11 are independent.
    std::vector<std::string> fixed;
    for (const ModelParameter& parameter : found.taxels[0].sequences[0].models[0].parameters)
      if (parameter.fixed) {
        fixed.push_back(parameter.name);
        CHECK(parameter.value == (parameter.name == "rho" ? 1.0 : 0.0));
      }
    CHECK(fixed == std::vector<std::string>{"a2", "b2", "rho"});
    CHECK(found.taxels[0].sequences[0].models[0].parameters.size() == 11);
    for (const std::size_t other : {1U, 2U, 3U})
      for (const ModelParameter& parameter : found.taxels[0].sequences[0].models[other].parameters)
        CHECK_FALSE(parameter.fixed);
  }
}

TEST_CASE("models side by side: a falling sensor's outputs keep their sign, its errors are the same") {
  Dataset data = known_loop();
  for (Repeat& repeat : data.sequences[0].repeats)
    for (double& v : repeat.volts) v = -v;
  SensorModel fit = straight_fit();
  fit.falling = true;
  const ModelComparison found = compare_models(data, fit, kChosen, 1);
  const ComparedSequence& mean = found.taxels.at(0).sequences.at(0);
  check_values(mean.measured_v, {0, -1.5, -3.0, -4.5, -3.125, -1.7, 0});
  check_values(mean.models[3].model_v, {0, -1.5, -3.0, -4.5, -3.0, -1.5, 0});
  CHECK(mean.models[3].mean_error_v == Approx(0.325 / 6));
}

TEST_CASE("models side by side: what cannot be identified says why, a fit of another model has ELAM identified") {
  // Up only: no model that is made of the external loop.
  const std::vector<Sample> steps{{0, 0}, {20, 20}, {40, 40}, {60, 60}};
  const Dataset up = dataset_of({{"up", {repeat_of(steps, {{0, 20, 40, 60}, {0, 20, 40, 60}})}}});
  const ModelComparison found = compare_models(up, straight_fit(), kChosen, 1);
  const std::vector<ComparedModel>& models = found.taxels.at(0).sequences.at(0).models;
  CHECK_FALSE(models[2].failed.empty());
  CHECK(models[2].samples == 0);
  CHECK(models[3].samples == 3);
  CHECK(models[3].max_error_v == Approx(0.0).margin(1e-12));
  SensorModel lines = straight_fit();
  for (ModelTaxel& taxel : lines.taxels) {
    if (taxel.status != TaxelStatus::kFitted) continue;
    const std::vector<double> ends{0.0, kFullPsi}, volts{0.0, taxel.yu()};
    taxel.fit.model = std::make_shared<MonotoneModel>(PatternCurve(ends, volts, 0.0, taxel.yu()));
  }
  const ModelComparison other = compare_models(known_loop(), lines, kChosen, 1);
  const ComparedModel& elam = other.taxels.at(0).sequences.at(0).models.at(3);
  CHECK(elam.model == "elam");
  CHECK(elam.samples == 6);
  CHECK(elam.max_error_v < 0.2);  // its patterns are the loop itself
  SensorModel none = straight_fit();
  for (ModelTaxel& taxel : none.taxels) taxel.status = TaxelStatus::kDead;
  CHECK(compare_models(known_loop(), none, kChosen, 1).taxels.empty());
}
