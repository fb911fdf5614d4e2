// The search of genetic.h by pagmo, in a library of its own that is loaded when it is asked for: libpagmo takes longer
// to load than all other libraries of the program together, at each start.
#pragma once

namespace tactbench::analysis {

struct GeneticTask {
  double (*cost)(void* context, const double* genes);  // what is minimized
  void* context;
  unsigned genes;  // each within 0 to 1
  unsigned individuals, generations;
  double crossover, crossover_spread, mutation, mutation_spread;
  unsigned seed;
};

// Writes the genes of the least cost; false where pagmo failed.
using GeneticSearch = bool(const GeneticTask& task, double* best);
inline constexpr const char* kGeneticModule = "tactbench_genetic.so";
inline constexpr const char* kGeneticSearch = "tactbench_genetic_search";

}  // namespace tactbench::analysis
