// The paper's genetic algorithm compared with the exact method on the rebuilt paper taxel.
#include <catch2/catch.hpp>
#include <filesystem>
#include <vector>

#include "analysis/identify/elam/genetic.h"
#include "analysis/identify/elam/genetic_module.h"
#include "tests/analysis/support/fit_samples.h"
#include "tests/support/paths.h"

using namespace synthetic;

namespace {

// Splits of branches of either length within 0 and 1.
void check_in_box(const ElamModel& model) {
  const ElamParameters& p = model.parameters;
  const double full = p.alpha_a1 * (model.xu() - model.x0()) + p.alpha_a0;
  for (const double value : {p.alpha_d, p.beta_d, p.alpha_a0, full, p.beta_a}) {
    CHECK(value >= -1e-12);
    CHECK(value <= 1.0 + 1e-12);
  }
}

}  // namespace

TEST_CASE("genetic algorithm: its J on the paper taxel with noise is never below the exact one's") {
  if (!has_genetic()) return;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const FitData data = paper_both(0.032, 0.0205, seed);
    const std::vector<TaxelBranch> branches = elam_branches_of(data);
    const ElamFit exact = identify_elam(data.ascending, data.descending, branches);
    const ElamFit genetic = identify_elam_ga(data.ascending, data.descending, branches, {}, seed);
    INFO("seed " << seed << ": J " << exact.j_v2 << " and " << genetic.j_v2);
    CHECK(genetic.j_v2 >= exact.j_v2 * (1.0 - 1e-9));
    CHECK(genetic.j_v2 < 100.0 * exact.j_v2);  // it does search
    check_in_box(genetic.model);
  }
}

TEST_CASE("genetic algorithm: a range about 0 is searched as one that begins there") {
  if (!has_genetic()) return;
  const FitData data = paper_both(0.032, 0.0205, 1);
  const double middle = 0.5 * (data.ascending.x().front() + data.ascending.x().back());
  const auto moved = [&](const PatternCurve& curve) {
    std::vector<double> x(curve.x().begin(), curve.x().end());
    for (double& at : x) at -= middle;
    return PatternCurve(x, {curve.y().begin(), curve.y().end()}, curve.y().front(), curve.y().back());
  };
  std::vector<TaxelBranch> branches = elam_branches_of(data);
  for (TaxelBranch& branch : branches)
    for (double& at : branch.pressure_psi) at -= middle;
  const PatternCurve up = moved(data.ascending), down = moved(data.descending);
  const ElamFit exact = identify_elam(up, down, branches), genetic = identify_elam_ga(up, down, branches, {}, 1);
  CHECK(genetic.j_v2 < 100.0 * exact.j_v2);
  check_in_box(genetic.model);
}

TEST_CASE("genetic algorithm: it is found where it was built") {
  const auto built = std::filesystem::path(tactbench::tests::program_path()).replace_filename(kGeneticModule);
  CHECK(has_genetic() == std::filesystem::exists(built));
}

TEST_CASE("genetic algorithm: the same seed gives the same fit, and the fit option selects it") {
  const FitData data = paper_both(0.032, 0.0205, 1);
  if (!has_genetic()) {
    CHECK_THROWS_WITH(identify("elam", data, {.genetic = true}), Catch::Contains("libpagmo-dev"));
    return;
  }
  const auto branches = elam_branches_of(data);
  const double once = identify_elam_ga(data.ascending, data.descending, branches).j_v2;
  CHECK(identify_elam_ga(data.ascending, data.descending, branches).j_v2 == once);
  CHECK(identify_elam_ga(data.ascending, data.descending, branches, {}, 2).j_v2 != once);
  CHECK(identify("elam", data, {.genetic = true}).j == Approx(once).epsilon(1e-9));
}
