#include "analysis/identify/elam/genetic.h"

#include <stdexcept>

#include "analysis/identify/elam/elam.h"
#include "analysis/identify/elam/genetic_module.h"
#include "analysis/module_symbol.h"

namespace tactbench::analysis {

namespace {

// The size is usual for five variables. Of seven settings of crossover and mutation this came nearest to the exact J on
// four noisy copies of the rebuilt paper taxel, where sga's own defaults end at twice that J; on others it is caught in
// local minima all the same.
constexpr unsigned kGenes = 5, kIndividuals = 50, kGeneticGenerations = 500;
constexpr double kCrossover = 0.8, kCrossoverSpread = 1.0, kMutation = 0.2, kMutationSpread = 0.05;

GeneticSearch* loaded() {
  static auto* const search = reinterpret_cast<GeneticSearch*>(module_symbol(kGeneticModule, kGeneticSearch));
  return search;
}

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

ElamParameters parameters_of(const double* genes, double length) {
  return {genes[0], genes[1], (genes[3] - genes[2]) / length, genes[2], genes[4]};
}

struct Searched {
  ElamModel& model;
  const ElamSamples& samples;
};

double cost(void* context, const double* genes) {
  const auto& [model, samples] = *static_cast<Searched*>(context);
  model.parameters = parameters_of(genes, model.xu() - model.x0());
  return j_of(model, samples.descending, false) + j_of(model, samples.ascending, true);
}

}  // namespace

bool has_genetic() { return loaded() != nullptr; }

ElamFit identify_elam_ga(const PatternCurve& ascending, const PatternCurve& descending,
                         std::span<const TaxelBranch> branches, const ElamOptions& options, unsigned seed) {
  if (!has_genetic()) throw std::invalid_argument(kNoGenetic);
  ElamModel model{ascending, descending, {}, options};
  const ElamSamples samples = searched_samples(model, branches);
  Searched searched{model, samples};
  double best[kGenes];
  if (!loaded()({cost, &searched, kGenes, kIndividuals, kGeneticGenerations, kCrossover, kCrossoverSpread, kMutation,
                 kMutationSpread, seed},
                best))
    throw std::runtime_error("pagmo's genetic algorithm failed");
  model.parameters = parameters_of(best, model.xu() - model.x0());
  ElamFit fit = scored(model, branches);
  // What it found stays, whatever the data leave open.
  fit.undetermined = settle_undetermined(model, samples.descending, samples.descending_constant, false) |
                     settle_undetermined(model, samples.ascending, samples.ascending_constant, true);
  return fit;
}

}  // namespace tactbench::analysis
