// Fits of each model but GPI, and of ELAM's modes beside the paper's, to one set of data: none leaves more than these.
#include <catch2/catch.hpp>
#include <random>
#include <string>
#include <vector>

#include "analysis/identify/identifier.h"
#include "tests/analysis/support/fit_samples.h"

using namespace synthetic;

namespace {

// The paper's sequences with noise, and a way between random turns of another ELAM with more.
FitData bounded_data() {
  std::mt19937 random(21);
  FitData data = paper_both(0.02, 0.03);
  const std::vector<double> inputs = random_inputs(random, 30, 0.0, 60.0, 4);
  const ElamModel other = model_of(paper_loop(), {0.4, 0.7, 0.002, 0.3, 0.6}, true);
  data.histories.push_back(drive("random", inputs, Plant(other), 0.05, 3));
  return data;
}

struct BoundedFit {
  std::string model;
  IdentifyOptions options;
  double most_j;
};

const std::vector<BoundedFit> kBoundedFits{
    {"poly", {}, 8.157},
    {"poly", {.free_run = true}, 12.491},
    {"poly", {.linearise = true}, 5.06},
    {"mpi", {}, 13.117},
    {"mpi", {.linearise = true}, 7.442},
    {"preisach", {.cells = 5}, 3.575},
    {"preisach", {.cells = 5, .by_input = true}, 4.237},
    {"preisach", {.cells = 5, .linearise = true}, 4.317},
    {"elam", {.free_run = true}, 2.232},
    {"elam", {.exact_outer = true}, 2.175},
    {"elam", {.memory = true}, 2.485},
    {"elam", {.splits = 2}, 2.419},
    {"elam", {.free_run = true, .splits = 3}, 2.175},
    {"elam", {.memory = true, .splits = 2}, 2.495},
};

}  // namespace

TEST_CASE("fits of each model and mode leave no larger J than their bounds") {
  const FitData data = bounded_data();
  for (const auto& [model, options, most_j] : kBoundedFits) {
    CAPTURE(model, options.free_run, options.memory, options.splits, options.linearise);
    const ModelFit fit = identify(model, data, options);
    CHECK(fit.samples == 780);
    CHECK(fit.j <= most_j);
  }
}
