#include "analysis/identify/elam/genetic_module.h"

#include <algorithm>
#include <pagmo/algorithm.hpp>
#include <pagmo/algorithms/sga.hpp>
#include <pagmo/population.hpp>
#include <pagmo/problem.hpp>

using tactbench::analysis::GeneticTask;

namespace {

// pagmo copies it with its population: it holds no data itself. One thread.
struct Problem {
  const GeneticTask* task = nullptr;
  [[nodiscard]] std::vector<double> fitness(const std::vector<double>& genes) const {
    return {task->cost(task->context, genes.data())};
  }
  [[nodiscard]] std::pair<std::vector<double>, std::vector<double>> get_bounds() const {
    const std::size_t genes = task == nullptr ? 1 : task->genes;
    return {std::vector<double>(genes, 0.0), std::vector<double>(genes, 1.0)};
  }
};

}  // namespace

extern "C" __attribute__((visibility("default"))) bool tactbench_genetic_search(const GeneticTask& task, double* best) {
  try {
    const pagmo::population first{pagmo::problem{Problem{&task}}, task.individuals, task.seed};
    const pagmo::algorithm algorithm{pagmo::sga{task.generations, task.crossover, task.crossover_spread, task.mutation,
                                                task.mutation_spread, 2, "sbx", "gaussian", "tournament", task.seed}};
    const std::vector<double> champion = algorithm.evolve(first).champion_x();
    std::copy(champion.begin(), champion.end(), best);
    return true;
  } catch (const std::exception&) {
    return false;
  }
}
