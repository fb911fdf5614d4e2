// Cost of identification: ELAM in units of one plain J, an array from the store to its parameters, threads, growth, and
// the other models.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "analysis/identify/elam/identify.h"
#include "analysis/identify/sensor_model.h"
#include "bench/benchmarks/figure.h"
#include "bench/benchmarks/simulated_run.h"

namespace tactbench::bench {

// One taxel's J over its samples, written plainly: turning points, curves, residuals. The unit of the goals.
double plain_j(const analysis::ElamModel& model, std::span<const analysis::TaxelBranch> branches);

// What is identified of a taxel, and its branches.
struct TaxelToIdentify {
  analysis::FitData data;
  std::vector<analysis::TaxelBranch> branches;
};
// Of each taxel of the array, without the mean of them.
std::vector<TaxelToIdentify> taxels_to_identify(const analysis::Dataset& dataset);

// Seconds.
struct IdentifyTimes {
  int taxels = 0;
  double plain_j = 0.0;                                // one J of all taxels
  std::vector<std::pair<std::string, double>> levels;  // all taxels, by vector level
  // Of few taxels: by the genetic search and exactly, and what J each ends at. Empty: this build has no such search.
  double genetic = 0.0, exact = 0.0;
  std::vector<double> genetic_j, exact_j;
  double reading = 0.0, alone = 0.0, from_store = 0.0;  // all taxels
  double one_thread = 0.0, two_threads = 0.0;
  std::vector<std::pair<int, double>> growth;  // taxels a side, the smallest array first and the largest last
  struct Model {
    std::string name;
    double fit = 0.0, walk = 0.0;  // of as many taxels as `few` says
  };
  std::vector<Model> models;
  int few = 0;
  double dynamic = 0.0;
};
std::vector<Figure> figures_of(const IdentifyTimes& times);

struct IdentifySizes {
  int side = 16, repeats = 5;
  std::size_t few = 8;  // taxels for what takes milliseconds each
  std::vector<int> growth = {16, 32, 64};
};
// 256 synthetic taxels, 660 scored samples each; one thread where not said otherwise. Best of `rounds`. Writes to
// `folder`.
std::vector<Figure> benchmark_identify(int rounds, const std::string& folder, const IdentifySizes& sizes = {},
                                       const Simulate& simulate = simulate_run);

}  // namespace tactbench::bench
