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
  double j, mean_error, max_error;
};

const std::vector<RecordedFit> kRecordedFits{
    {"poly", {}, 8.1488128014, 0.062095000394, 0.62152164862},
    {"poly", {.free_run = true}, 12.477653607, 0.076836844977, 0.74315452973},
    {"poly", {.linearise = true}, 5.0543841557, 0.047850701288, 0.5268534734},
    {"mpi", {}, 13.103442333, 0.10821914624, 0.365304881},
    {"mpi", {.linearise = true}, 7.433638396, 0.072101238643, 0.31056595311},
    {"preisach", {.cells = 5}, 3.5705506579, 0.046413436419, 0.35251157243},
    {"preisach", {.cells = 5, .by_input = true}, 4.2319553235, 0.051629889659, 0.39420089087},
    {"preisach", {.cells = 5, .linearise = true}, 4.3118479947, 0.050464425424, 0.3591031106},
    {"elam", {.free_run = true}, 2.229768944, 0.034197570607, 0.37589937555},
    {"elam", {.exact_outer = true}, 2.1720980686, 0.035631924654, 0.35316235227},
    {"elam", {.memory = true}, 2.4824920202, 0.036712781161, 0.35484820449},
    {"elam", {.splits = 2}, 2.415866617, 0.035877535611, 0.42013692815},
    {"elam", {.free_run = true, .splits = 3}, 2.1720990702, 0.034316081761, 0.3684038031},
    {"elam", {.memory = true, .splits = 2}, 2.4923571608, 0.037183204457, 0.34226738525},
};

}  // namespace

TEST_CASE("fits of each model and mode come to what they came to when they were recorded") {
  const FitData data = recorded_data();
  for (const RecordedFit& was : kRecordedFits) {
    const ModelFit fit = identify(was.model, data, was.options);
    const double epsilon = 1e-8;
    CAPTURE(was.model, was.options.free_run, was.options.memory, was.options.splits, was.options.linearise);
    CHECK(fit.samples == 780);
    CHECK(fit.j == Approx(was.j).epsilon(epsilon));
    CHECK(fit.mean_error == Approx(was.mean_error).epsilon(epsilon));
    CHECK(fit.max_error == Approx(was.max_error).epsilon(epsilon));
  }
}
