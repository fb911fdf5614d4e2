#include "analysis/identify/elam/genetic.h"

#ifdef TACTBENCH_HAVE_PAGMO
#include <pagmo/algorithm.hpp>
#include <pagmo/algorithms/sga.hpp>
#include <pagmo/population.hpp>
#include <pagmo/problem.hpp>

#include "analysis/identify/elam/elam_samples.h"
#else
#include <stdexcept>
#endif

namespace tactbench::analysis {

#ifdef TACTBENCH_HAVE_PAGMO

namespace {

// The size is usual for five variables. Of seven settings of crossover and mutation this came nearest to the exact J on
// four noisy copies of the rebuilt paper taxel, where sga's own defaults end at twice that J; on others it is caught in
// local minima all the same.
constexpr unsigned kIndividuals = 50, kGenerations = 500;
constexpr double kCrossover = 0.8, kCrossoverSpread = 1.0, kMutation = 0.2, kMutationSpread = 0.05;

double j_of(const ElamModel& model, std::span<const CurveSamples> curves, bool ascending) {
  double j = 0.0;
  for (const CurveSamples& own : curves) {
    const ElamCurve curve(model, ascending, own.x_turn, own.y_turn);
    for (std::size_t i = 0; i < own.x.size(); ++i) {
      const double error = curve.output(own.x[i]) - own.y[i];
      j += own.weight[i] * error * error;
    }
  }
  return j;
}

ElamParameters parameters_of(const std::vector<double>& genes, double length) {
  return {genes[0], genes[1], (genes[3] - genes[2]) / length, genes[2], genes[4]};
}

// pagmo copies it with its population: it holds no data itself. One thread.
struct Problem {
  ElamModel* model = nullptr;
  const ElamSamples* samples = nullptr;
  [[nodiscard]] std::vector<double> fitness(const std::vector<double>& genes) const {
    model->parameters = parameters_of(genes, model->xu() - model->x0());
    return {j_of(*model, samples->descending, false) + j_of(*model, samples->ascending, true)};
  }
  [[nodiscard]] static std::pair<std::vector<double>, std::vector<double>> get_bounds() {
    return {std::vector<double>(5, 0.0), std::vector<double>(5, 1.0)};
  }
};

}  // namespace

bool has_genetic() { return true; }

ElamFit identify_elam_ga(const PatternCurve& ascending, const PatternCurve& descending,
                         std::span<const TaxelBranch> branches, const ElamOptions& options, unsigned seed) {
  ElamModel model{ascending, descending, {}, options};
  const ElamSamples samples = searched_samples(model, branches);
  const pagmo::population first{pagmo::problem{Problem{&model, &samples}}, kIndividuals, seed};
  const pagmo::algorithm algorithm{pagmo::sga{kGenerations, kCrossover, kCrossoverSpread, kMutation, kMutationSpread, 2,
                                              "sbx", "gaussian", "tournament", seed}};
  const pagmo::population last = algorithm.evolve(first);
  model.parameters = parameters_of(last.champion_x(), model.xu() - model.x0());
  return scored(model, branches);
}

#else

bool has_genetic() { return false; }

ElamFit identify_elam_ga(const PatternCurve&, const PatternCurve&, std::span<const TaxelBranch>, const ElamOptions&,
                         unsigned) {
  throw std::invalid_argument(kNoGenetic);
}

#endif

}  // namespace tactbench::analysis
