// What judged figures scatter by where sweeps and repeats are few or unequal: by hand.
#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/judgement/judgement.h"
#include "analysis/statistics/numbers/moments.h"
#include "tests/analysis/support/straight_array.h"

using namespace tactbench;
using namespace straight_array;

namespace {

// One way; the first taxel reads `apart` more than the second, which reads the reference.
Repeat apart_by(const std::vector<double>& setpoints, const std::vector<double>& apart) {
  std::vector<Sample> steps;
  Readings readings;
  for (std::size_t i = 0; i < setpoints.size(); ++i) {
    steps.push_back({setpoints[i], setpoints[i]});
    readings.first_psi.push_back(setpoints[i] + apart[i]);
    readings.second_psi.push_back(setpoints[i]);
  }
  return repeat_of(steps, readings);
}
const std::vector<double> kWhole{0, 20, 40, 60, 40, 20, 0}, kCoarse{0, 40, 60, 40, 0};

ReferenceUncertainty with_parts(bool drift, bool digit, std::vector<std::size_t> parts = {}) {
  ReferenceUncertainty reference;
  reference.reading_psi = {0.0};
  reference.expanded_psi = {0.2};
  if (drift)
    reference.drift_psi = reference.drift_stated_psi = 0.1;
  else
    reference.drift_missing = "none";
  if (digit)
    reference.resolution_psi = 0.1;
  else
    reference.resolution_missing = "none";
  for (const std::size_t part : parts) reference.limits[part].half_width_psi = 0.1;
  return reference;
}

JudgedUncertainty found_in(const std::vector<JudgedUncertainty>& all, const char* criterion, const char* scope) {
  const JudgedUncertainty* const found = find_uncertainty(all, criterion, scope);
  REQUIRE(found != nullptr);
  return *found;
}

std::vector<JudgedUncertainty> judged_of(const Dataset& judged, const Dataset& models,
                                         const ReferenceUncertainty& reference = with_parts(false, false)) {
  return judged_uncertainties(judged, models, straight_fit(), evaluate(judged, straight_fit(), 1), reference, 1);
}

}  // namespace

TEST_CASE("scatter of a level that not every sweep passes: that of the levels they have in common, pooled") {
  // At 40 psi upward the taxels are 2 and 4 psi apart: standard deviations of sqrt 2 and 2 sqrt 2, a variance of 1
  // between them; none at 0 and 60 psi. Pooled over three levels 1/3; in common 1/9; dof 1 / (1/9 + (4/9) / 2) = 3.
  const Dataset data =
      dataset_of({{"a", {apart_by(kWhole, {0, 5, 2, 0, 0, 0, 0})}}, {"b", {apart_by(kCoarse, {0, 4, 0, 0, 0})}}});
  const auto all = judged_of(data, data);
  const JudgedUncertainty twenty = found_in(all, "mismatch", "20 psi up"),
                          forty = found_in(all, "mismatch", "40 psi up");
  CHECK(twenty.combined == Approx(std::sqrt(1.0 / 3.0 / 2.0) / 60.0));  // of two sweeps
  CHECK(twenty.dof == Approx(3.0));
  CHECK(forty.combined == Approx(std::sqrt(0.5) / 60.0));
  CHECK(forty.dof == 1.0);
  CHECK(forty.run == 2);
}

TEST_CASE("scatter of one sweep judged is that of the models' run, whole, without two sweeps there nothing is known") {
  const Dataset one = dataset_of({{"a", {apart_by(kWhole, {0, 0, 3, 0, 0, 0, 0})}}});
  const Dataset two =
      dataset_of({{"a", {apart_by(kWhole, {0, 0, 2, 0, 0, 0, 0}), apart_by(kWhole, {0, 0, 4, 0, 0, 0, 0})}}});
  const auto all = judged_of(one, two);
  const JudgedUncertainty forty = found_in(all, "mismatch", "40 psi up");
  CHECK(forty.combined == Approx(1.0 / 60.0));
  const JudgedUncertainty distance = found_in(all, "distance_of_mean", "array");
  // The mean of both taxels 1 and 2 psi: a variance of 1/2 at one of four levels upward, pooled 1/8, in common 1/32.
  CHECK(distance.combined == Approx(std::sqrt(1.0 / 8.0) / 60.0));
  const auto nothing = judged_of(one, one);
  CHECK(std::isnan(found_in(nothing, "mismatch", "40 psi up").expanded));
  CHECK_FALSE(found_in(nothing, "mismatch", "40 psi up").missing.empty());
  CHECK_FALSE(found_in(nothing, "mean_compensation_error", "array").missing.empty());
  CHECK(std::isnan(found_in(nothing, "distance_of_mean", "array").combined));
}

TEST_CASE("of taxels that err alike the first is the worst one") {
  // Both read 10 psi too much at 40 psi upward: 2.5 and 5 V.
  const Evaluation e =
      evaluate(dataset_of({{"a",
                            {repeat_of({{0, 0}, {20, 20}, {40, 40}, {60, 60}, {40, 40}, {20, 20}, {0, 0}},
                                       {{0, 20, 50, 60, 40, 20, 0}, {0, 20, 50, 60, 40, 20, 0}})}}}),
               straight_fit(), 1);
  REQUIRE(e.taxel_mean_error_psi[0] == e.taxel_mean_error_psi[1]);
  CHECK(e.worst_taxel == 0);
  // The largest error of a run: whose it is, and at which pressure.
  const Evaluation known = evaluate(known_loop(), straight_fit(), 1);
  CHECK(known.max_error_taxel == 0);
  CHECK(known.max_error_at_psi == 20.0);
  CHECK((known.run == 2 && known.model_run == 1));
}
