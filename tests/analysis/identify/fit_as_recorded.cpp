// Fits of all models but GPI, whose evolutions carry the last bits far, and ELAM's paper mode to one set of data: what
// they came to when these were recorded. `verify` recomputes stored fits by later programs, which have to come to the
// same.
#include <catch2/catch.hpp>
#include <random>
#include <string>
#include <vector>

#include "analysis/identify/identifier.h"
#include "tests/analysis/support/fit_samples.h"

using namespace synthetic;

namespace {

// The paper's sequences with noise, and a way between random turns of another ELAM with more.
FitData recorded_data() {
  std::mt19937 random(21);
  FitData data = paper_both(0.02, 0.03);
  const std::vector<double> inputs = random_inputs(random, 30, 0.0, 60.0, 4);
  const ElamModel other = model_of(paper_loop(), {0.4, 0.7, 0.002, 0.3, 0.6}, true);
  data.histories.push_back(drive("random", inputs, Plant(other), 0.05, 3));
  return data;
}

struct RecordedFit {
  std::string model;
  IdentifyOptions options;
  double j;
};

const std::vector<RecordedFit> kRecordedFits{
    {"poly", {}, 8.1488128014},
    {"poly", {.free_run = true}, 12.477653607},
    {"poly", {.linearise = true}, 5.0543841557},
    {"mpi", {}, 13.103442333},
    {"mpi", {.linearise = true}, 7.433638396},
    {"preisach", {.cells = 5}, 3.5705506579},
    {"preisach", {.cells = 5, .by_input = true}, 4.2319553235},
    {"preisach", {.cells = 5, .linearise = true}, 4.3118479947},
    {"elam", {.free_run = true}, 2.229768944},
    {"elam", {.exact_outer = true}, 2.1720980686},
    {"elam", {.memory = true}, 2.4824920202},
    {"elam", {.splits = 2}, 2.415866617},
    {"elam", {.free_run = true, .splits = 3}, 2.1720990702},
    {"elam", {.memory = true, .splits = 2}, 2.4923571608},
};

}  // namespace

TEST_CASE("fits of each model and mode come to what they came to when they were recorded") {
  const FitData data = recorded_data();
  for (const RecordedFit& was : kRecordedFits) {
    const ModelFit fit = identify(was.model, data, was.options);
    CAPTURE(was.model, was.options.free_run, was.options.memory, was.options.splits, was.options.linearise);
    CHECK(fit.samples == 780);
    CHECK(fit.j == Approx(was.j).epsilon(1e-8));
  }
}
