// The paper's genetic algorithm compared with the exact method on the rebuilt paper taxel.
#include <catch2/catch.hpp>
#include <chrono>
#include <filesystem>
#include <vector>

#include "analysis/identify/elam/genetic.h"
#include "analysis/identify/elam/genetic_module.h"
#include "tests/analysis/support/fit_samples.h"
#include "tests/support/paths.h"

using namespace synthetic;

namespace {

std::vector<TaxelBranch> branches_of(const FitData& data) {
  std::vector<TaxelBranch> branches;
  for (const History& history : data.histories)
    for (const Branch& branch : history.branches)
      branches.push_back({branch.ascending,
                          {history.x.begin() + branch.first, history.x.begin() + branch.last + 1},
                          {history.y.begin() + branch.first, history.y.begin() + branch.last + 1}});
  return branches;
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

TEST_CASE("genetic algorithm: its J on the paper taxel with noise is never below the exact one's") {
  if (!has_genetic()) {
    WARN("this build has no genetic algorithm: nothing compared");
    return;
  }
  double worst = 0.0, mean = 0.0, exact_s = 0.0, genetic_s = 0.0;
  constexpr unsigned kSeeds = 6;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const FitData data = paper_both(0.032, 0.0205, seed);
    const std::vector<TaxelBranch> branches = branches_of(data);
    auto start = std::chrono::steady_clock::now();
    const ElamFit exact = identify_elam(data.ascending, data.descending, branches);
    exact_s += seconds_since(start) / kSeeds;
    start = std::chrono::steady_clock::now();
    const ElamFit genetic = identify_elam_ga(data.ascending, data.descending, branches, {}, seed);
    genetic_s += seconds_since(start) / kSeeds;
    INFO("seed " << seed << ": J " << exact.j_v2 << " and " << genetic.j_v2);
    CHECK(genetic.j_v2 >= exact.j_v2 * (1.0 - 1e-9));
    CHECK(genetic.j_v2 < 100.0 * exact.j_v2);  // it does search
    const ElamParameters& p = genetic.model.parameters;
    const double full = p.alpha_a1 * (genetic.model.xu() - genetic.model.x0()) + p.alpha_a0;
    for (const double value : {p.alpha_d, p.beta_d, p.alpha_a0, full, p.beta_a}) {
      CHECK(value >= -1e-12);
      CHECK(value <= 1.0 + 1e-12);
    }
    worst = std::max(worst, genetic.j_v2 / exact.j_v2);
    mean += genetic.j_v2 / exact.j_v2 / kSeeds;
  }
  WARN("genetic over exact: J " << mean << " in the mean, " << worst << " at most, time " << genetic_s << " s over "
                                << exact_s << " s = " << genetic_s / exact_s);
}

TEST_CASE("genetic algorithm: a range about 0 is searched as one that begins there") {
  if (!has_genetic()) {
    WARN("this build has no genetic algorithm: nothing compared");
    return;
  }
  const FitData data = paper_both(0.032, 0.0205, 1);
  const double middle = 0.5 * (data.ascending.x().front() + data.ascending.x().back());
  const auto moved = [&](const PatternCurve& curve) {
    std::vector<double> x(curve.x().begin(), curve.x().end());
    for (double& at : x) at -= middle;
    return PatternCurve(x, {curve.y().begin(), curve.y().end()}, curve.y().front(), curve.y().back());
  };
  std::vector<TaxelBranch> branches = branches_of(data);
  for (TaxelBranch& branch : branches)
    for (double& at : branch.pressure_psi) at -= middle;
  const PatternCurve up = moved(data.ascending), down = moved(data.descending);
  const ElamFit exact = identify_elam(up, down, branches), genetic = identify_elam_ga(up, down, branches, {}, 1);
  CHECK(genetic.j_v2 < 100.0 * exact.j_v2);
  const ElamParameters& p = genetic.model.parameters;
  const double full = p.alpha_a1 * (genetic.model.xu() - genetic.model.x0()) + p.alpha_a0;
  CHECK(full >= -1e-12);
  CHECK(full <= 1.0 + 1e-12);
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
  const auto branches = branches_of(data);
  const double once = identify_elam_ga(data.ascending, data.descending, branches).j_v2;
  CHECK(identify_elam_ga(data.ascending, data.descending, branches).j_v2 == once);
  CHECK(identify_elam_ga(data.ascending, data.descending, branches, {}, 2).j_v2 != once);
  CHECK(identify("elam", data, {.genetic = true}).j == Approx(once).epsilon(1e-9));
}
