// Histories for fitting models: the reconstructed taxel on the paper's sequences, and any inputs driven through any
// plant.
#pragma once

#include <random>
#include <string>

#include "analysis/identify/elam/elam.h"
#include "analysis/identify/fit_models.h"
#include "analysis/identify/sensor_model.h"
#include "tests/analysis/support/alike.h"
#include "tests/analysis/support/synthetic.h"

namespace synthetic {

// `plant` gives the output for each input in turn; white noise of `noise` on top.
template <class Plant>
History drive(const std::string& name, const std::vector<double>& inputs, Plant&& plant, double noise = 0.0,
              unsigned seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  History history{name, inputs, {}, branches_along(inputs), {}, {}};
  for (const double x : inputs) history.y.push_back(plant(x) + noise * normal(random));
  return history;
}

// One of the paper's sequences on its rebuilt taxel: external branches are the patterns.
inline FitData paper_data(const std::vector<double>& turns, double noise = 0.0, unsigned seed = 1) {
  const ElamModel truth = model_of(paper_loop(), kPrinted, true);
  return {{drive("paper", levels_of(turns), Plant(truth), noise, seed)}, truth.ascending, truth.descending};
}

// Both sequences, each from a virgin taxel.
inline FitData paper_both(double noise_descending = 0.0, double noise_ascending = 0.0, unsigned seed = 1) {
  FitData data = paper_data(kDescendingTurns, noise_descending, seed);
  data.histories.push_back(paper_data(kAscendingTurns, noise_ascending, seed + 100).histories.front());
  return data;
}

// Turning points at random within low..high, far enough apart, and the way between them in `steps` steps each.
inline std::vector<double> random_inputs(std::mt19937& random, int turns, double low, double high, int steps) {
  std::uniform_real_distribution<double> uniform(low, high);
  std::vector<double> inputs{low};
  bool up = true;
  for (int t = 0; t < turns; ++t, up = !up) {
    const double from = inputs.back();
    double to = uniform(random);
    for (int n = 0; n < 100 && (up ? to <= from : to >= from); ++n) to = uniform(random);
    if (up ? to <= from : to >= from) to = up ? high : low;
    for (int k = 1; k <= steps; ++k) inputs.push_back(k == steps ? to : from + (to - from) * k / steps);
  }
  return inputs;
}

// As ELAM's own identification takes them.
inline std::vector<TaxelBranch> elam_branches_of(const FitData& data) {
  std::vector<TaxelBranch> branches;
  for (const History& history : data.histories)
    for (const Branch& branch : history.branches)
      branches.push_back({branch.ascending,
                          {history.x.begin() + branch.first, history.x.begin() + branch.last + 1},
                          {history.y.begin() + branch.first, history.y.begin() + branch.last + 1}});
  return branches;
}

inline FitOptions fit_by(const std::string& model, const IdentifyOptions& identify = {}, int threads = 0) {
  FitOptions options;
  options.model = model;
  options.identify = identify;
  options.threads = threads;
  return options;
}

// Of a table; what is negative is found from its data.
inline HistoriesOptions table_options(double turn, double noise = -1.0, const std::vector<std::string>& fitted = {}) {
  HistoriesOptions options;
  options.turn = turn;
  options.noise = noise;
  options.fitted = fitted;
  return options;
}

}  // namespace synthetic
