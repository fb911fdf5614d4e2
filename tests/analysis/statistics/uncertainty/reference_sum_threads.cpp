// The reference's own error is one sum, by hand: that of a budget, of a verdict and of ReferenceUncertainty itself.
#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/judgement/measured_figures.h"
#include "analysis/statistics/uncertainty/budget_maker.h"
#include "tests/analysis/support/straight_array.h"

using namespace tactbench;
using namespace straight_array;

namespace {

ReferenceUncertainty whole_chain() {
  ReferenceUncertainty reference;
  reference.reading_psi = {0.0, 60.0};
  reference.expanded_psi = {0.04, 0.16};  // 0.12 at 40 psi
  reference.drift_stated_psi = reference.drift_psi = 0.05;
  reference.resolution_psi = 0.02;
  for (std::size_t part = 0; part < kReferenceParts; ++part)
    reference.limits[part].half_width_psi = 0.1 * (1.0 + static_cast<double>(part));  // 0.1, 0.2, 0.3, 0.4
  return reference;
}

// Certificate's U / 2; then the squares of half-widths of rectangles.
double by_hand_psi(double certificate_psi, double rectangles) {
  return std::sqrt(certificate_psi * certificate_psi / 4.0 + rectangles / 3.0);
}

double of_reference(const ReferenceUncertainty& reference) {
  const Dataset dataset = known_loop();
  const SensorModel fit = straight_fit();
  const SweepErrors errors = sweep_errors(dataset, fit);
  const UncertaintyInputs none;
  const Budget budget = BudgetMaker(dataset, fit, errors, reference, 0.0, none, 1).budget(0, 2);
  REQUIRE(budget.pressure_psi == 40.0);
  double squares = 0.0;
  for (const Contribution& row : budget.contributions)
    if (row.source <= UncertaintySource::kReferenceTemperature)  // they come first
      squares += row.u_psi * row.u_psi;
  return std::sqrt(squares);
}

double of_verdict(const ReferenceUncertainty& reference) {
  const auto combined = [](const ReferenceUncertainty& of) {
    const Dataset dataset = known_loop();
    const auto all = measured_figures(dataset, dataset, straight_fit(), evaluate(dataset, straight_fit()), of);
    REQUIRE(all.front().criterion == Criterion::kMeanError);
    return all.front().u.combined;
  };
  ReferenceUncertainty none;
  none.drift_missing = none.resolution_missing = "none";
  return std::sqrt(std::pow(combined(reference), 2) - std::pow(combined(none), 2));
}

}  // namespace

TEST_CASE("the reference's error by hand: of a reading at 40 psi, of a verdict with the certificate's largest U") {
  ReferenceUncertainty reference = whole_chain();
  const auto check_sums = [&](double rectangles) {
    CHECK(reference.combined_u(40.0) == Approx(by_hand_psi(0.12, rectangles)));
    CHECK(of_reference(reference) == Approx(by_hand_psi(0.12, rectangles)));
    CHECK(of_verdict(reference) == Approx(by_hand_psi(0.16, rectangles)).epsilon(1e-6));
  };
  check_sums(0.05 * 0.05 + 0.01 * 0.01 + 0.01 + 0.04 + 0.09 + 0.16);  // drift, half a digit, the four limits
  // What is not stated is in none of the sums.
  reference.drift_missing = reference.resolution_missing = "not stated";
  reference.limits[1].half_width_psi = 0.0;
  check_sums(0.01 + 0.09 + 0.16);
}
