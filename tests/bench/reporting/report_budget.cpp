// Re-mounting in the budgets: a sensor is calibrated in one mount and used in another. Truth: mounts drawn at random.
#include "bench/reporting/report_budget.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "analysis/statistics/studies/studies.h"

using namespace tactbench;

namespace {

constexpr std::size_t kMountedTaxels = 100;
constexpr double kCommonOfMounts = 0.01, kOwnOfMounts = 0.02;  // relative sensitivity, standard deviations over mounts

// Shares by which each taxel reads too much in one mount.
struct DrawnMount {
  double common = 0.0;
  std::vector<double> own;
  explicit DrawnMount(std::mt19937_64& random) {
    std::normal_distribution<double> normal;
    common = kCommonOfMounts * normal(random);
    for (std::size_t taxel = 0; taxel < kMountedTaxels; ++taxel) own.push_back(kOwnOfMounts * normal(random));
  }
};

analysis::MountedRun study_run(std::int64_t number, const DrawnMount& mount) {
  analysis::MountedRun run;
  run.run = number;
  run.estimates.pressure_psi = {20.0, 40.0};
  run.estimates.sweeps = 1;
  run.estimates.taxels = static_cast<int>(kMountedTaxels);
  for (const double level : run.estimates.pressure_psi)
    for (const double own : mount.own) run.estimates.psi.push_back(level * (1.0 + mount.common + own));
  return run;
}

}  // namespace

TEST_CASE("re-mounting: errors between two mounts are 1.42 times what one mount varies by, as the rows say") {
  std::mt19937_64 random(81);
  double given_common = 0.0, given_own = 0.0, seen_common = 0.0, seen_own = 0.0;
  constexpr int kTrials = 400, kMounts = 5;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<analysis::MountedRun> study;
    for (int mount = 0; mount < kMounts; ++mount) study.push_back(study_run(mount + 1, DrawnMount(random)));
    const analysis::Remount found = analysis::remount_of(study);
    analysis::UncertaintyInputs inputs;
    bench::add_mounts(found, inputs);
    REQUIRE((inputs.mounting && inputs.mounting_own));
    CHECK(inputs.mounting->share == Approx(std::sqrt(2.0) * found.common_share));
    CHECK(inputs.mounting_own->share == Approx(std::sqrt(2.0) * found.own_share));
    CHECK((inputs.mounting->dof == 4 && inputs.mounting_own->dof == 4 * 99));
    given_common += std::pow(inputs.mounting->share, 2) / kTrials;
    given_own += std::pow(inputs.mounting_own->share, 2) / kTrials;
    // The truth: calibrated in a mount of its own, used in another.
    const DrawnMount calibrated(random), used(random);
    seen_common += std::pow(used.common - calibrated.common, 2) / kTrials;
    for (std::size_t taxel = 0; taxel < kMountedTaxels; ++taxel)
      seen_own += std::pow(used.own[taxel] - calibrated.own[taxel], 2) / kTrials / double(kMountedTaxels);
  }
  CHECK(std::sqrt(given_common / seen_common) == Approx(1.0).margin(0.1));
  CHECK(std::sqrt(given_own / seen_own) == Approx(1.0).margin(0.02));
  // The audit's figure: 1.42 times the standard deviation of one mount.
  CHECK(std::sqrt(seen_own) / kOwnOfMounts == Approx(1.42).margin(0.02));
  CHECK(std::sqrt(given_own) / kOwnOfMounts == Approx(1.42).margin(0.02));
}

TEST_CASE("re-mounting: mounts that were not assessed give no row") {
  analysis::UncertaintyInputs inputs;
  bench::add_mounts({}, inputs);
  CHECK_FALSE(inputs.mounting);
  CHECK_FALSE(inputs.mounting_own);
}
