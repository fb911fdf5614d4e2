// A model file of a small array whose numbers are all given.
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "analysis/identify/stored/model_document.h"
#include "analysis/models/mpi.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/support/process.h"

namespace tactbench::tests {

using analysis::ModelTaxel;
using analysis::SensorModel;

inline ModelTaxel taxel_with(int number, const analysis::MpiParameters& parameters) {
  ModelTaxel taxel;
  taxel.taxel = number;
  taxel.status = analysis::TaxelStatus::kFitted;
  taxel.noise = 0.004;
  taxel.fit.model = std::make_unique<analysis::MpiModel>(parameters, 0.0, 60.0, 0.0);
  taxel.fit.j = 2.5;
  taxel.fit.mean_error = 0.02;
  taxel.fit.max_error = 0.06;
  taxel.fit.full_scale = 2.0;
  return taxel;
}

// Two taxels and the mean taxel; between them a dead one.
inline SensorModel known_model(double a1, double zero) {
  SensorModel document;
  document.model = "mpi";
  document.source = "me.csv";
  document.origin = "imported";
  document.content_sha256 = "0123";
  document.sequences = {"up", "down"};
  document.sensor_serial = "S-1";
  document.input_unit = "N";
  document.output_unit = "V";
  document.rows = 1;
  document.columns = 3;
  document.validity.input = analysis::Range{0.0, 60.0};
  document.validity.rate = analysis::Range{0.5, 2.0};
  document.validity.mount = "glued";
  document.taxels.push_back(taxel_with(0, {0.1, -0.001, 0.0, 3.0, 0.7}));
  document.taxels.emplace_back();
  document.taxels.back().taxel = 1;
  document.taxels.back().status = analysis::TaxelStatus::kDead;
  document.taxels.push_back(taxel_with(2, {a1, -0.001, 0.0, 3.0, 0.7}));
  document.taxels.back().zero = zero;
  document.taxels.push_back(taxel_with(analysis::kMeanTaxel, {0.1, -0.001, 0.0, 3.0, 5.0}));
  return document;
}

// Taxels without an external loop get the one that their models walk, at 31 inputs, as a fit leaves it; a straight one
// where a model's does not rise.
void write_model(const TemporaryFolder& folder, const std::string& name, const SensorModel& document);

// 0.125 V/N from 0 to 64 N: no play rubs.
inline std::unique_ptr<analysis::MpiModel> straight_line() {
  return std::make_unique<analysis::MpiModel>(analysis::MpiParameters{0.125, 0.0, 0.0, 0.0, 0.7}, 0.0, 64.0, 0.0);
}

// One taxel of that line, with its noise in V.
inline SensorModel straight_model(double noise = 0.0) {
  SensorModel document = known_model(0.1, 0.0);
  document.sensor_serial.clear();
  document.validity.input = analysis::Range{0.0, 64.0};
  document.taxels.resize(1);
  document.columns = 1;
  document.taxels[0].fit.model = straight_line();
  document.taxels[0].fit.full_scale = 8.0;
  document.taxels[0].noise = noise;
  return document;
}

// Runs the verbs on models within the test's process, with the files of one folder.

inline std::string without_folder(std::string text, const TemporaryFolder& folder) {
  const std::string path = folder.path() + "/";
  for (std::size_t at = text.find(path); at != std::string::npos; at = text.find(path, at)) text.erase(at, path.size());
  return text;
}

// fit, model, predict or compensate: words that end as names of files do are files of the folder, and so they stand in
// what is said. The store is the folder's runs.db.
inline Finished model_verb(const TemporaryFolder& folder, std::vector<std::string> words) {
  const std::string verb = words.front();
  for (std::string& word : words)
    for (const char* end : {".json", ".csv", ".toml"})
      if (word.ends_with(end) && !word.starts_with('/')) word = folder.path(word);
  words.insert(words.end(), {"--db", folder.path("runs.db")});
  Finished finished = verb_here(verb == "fit"       ? bench::add_fit
                                : verb == "compare" ? bench::add_compare
                                : verb == "model"   ? bench::add_model
                                                    : bench::add_predict,
                                std::move(words));
  finished.out = without_folder(finished.out, folder);
  finished.err = without_folder(finished.err, folder);
  return finished;
}

// Tables of a sensor with play for tests: y follows x through backlash, curved at the top.

struct PlaySample {
  int step = 0;
  double input = 0.0, output = 0.0;
};

// Through the turning points, `steps` from each to the next.
inline std::vector<PlaySample> play_samples(const std::vector<double>& turns, int steps = 40) {
  std::vector<PlaySample> samples;
  double play = 0.0;
  int step = 0;
  for (std::size_t t = 1; t < turns.size(); ++t)
    for (int k = t == 1 ? 0 : 1; k <= steps; ++k) {
      const double x = turns[t - 1] + (turns[t] - turns[t - 1]) * k / steps;
      play = std::clamp(play, x - 1.5, x);
      samples.push_back({step++, x, 0.5 * x + 0.4 * play + std::sqrt(std::max(x, 0.0))});
    }
  return samples;
}

}  // namespace tactbench::tests
