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
  std::vector<double> parameters;
};

const std::vector<RecordedFit> kRecordedFits{
    {"poly",
     {},
     8.1488128014,
     0.062095000394,
     0.62152164862,
     {8.1758640815e-10, -1.7986233459e-07, 1.5105013013e-05, -0.00058886835941, 0.0090155538421, 0.069737384551, 0,
      1.5442208905e-09, -2.8398787386e-07, 1.8822181625e-05, -0.00049585198188, 0.0008224700013, 0.20799105111, 0}},
    {"poly",
     {.free_run = true},
     12.477653607,
     0.076836844977,
     0.74315452973,
     {8.2659660283e-10, -1.8311007457e-07, 1.5500710904e-05, -0.00061065815371, 0.0095718328483, 0.064417541966, 0,
      1.6579629298e-09, -3.0258704153e-07, 1.9946987478e-05, -0.00052615366891, 0.0011558685331, 0.20671455156, 0}},
    {"poly",
     {.linearise = true},
     5.0543841557,
     0.047850701288,
     0.5268534734,
     {0.17280705132, -1.251612792e-10, -3.7658841431e-08, 7.8982403867e-06, -0.00050495378741, 0.013052460651,
      0.060601263829, 0, 5.6003091804e-09, -1.0717554375e-06, 7.6968214116e-05, -0.0025338786974, 0.034115359965,
      0.13160871142, 0}},
    {"mpi",
     {},
     13.103442333,
     0.10821914624,
     0.365304881,
     {0.1475918449, -0.0044577665134, 3.4315578375e-05, 20.368886386, 0.91693859139}},
    {"mpi",
     {.linearise = true},
     7.433638396,
     0.072101238643,
     0.31056595311,
     {0.17280705132, 0.13720953963, -0.0030826951617, 1.2879619076e-05, 35.12215259, 0.28161915677}},
    {"preisach",
     {.cells = 5},
     3.5705506579,
     0.046413436419,
     0.35251157243,
     {1.4065845208, 0.80689276478, 0.32831736447, 0.023138691403, 0.30275629576, 0.16390043324, 0.084760375389,
      0.15127766867, 0.10160307523, 0.0023359744664, 0.12257455775, 0.01429221037}},
    {"preisach",
     {.cells = 5, .by_input = true},
     4.2319553235,
     0.051629889659,
     0.39420089087,
     {1.4822076533, 0.74013182641, 0.30945550806, 0.38003967891, 0.17229833672, 0.10137155984, 0.076776220679,
      0.11921271409, 0.11551940656}},
    {"preisach",
     {.cells = 5, .linearise = true},
     4.3118479947,
     0.050464425424,
     0.3591031106,
     {0.17280705132, 1.7560718866, 1.4327366883, 1.2251985158, 0.052814440123, 1.2156940864, 0.6719316271,
      0.36794694019, 0.76873906257, 0.56180298065, 0.75933892962, 0.099882832424}},
    {"elam",
     {.free_run = true},
     2.229768944,
     0.034197570607,
     0.37589937555,
     {0.86780507447, 1, -0.0078839713156, 0.67891097223, 0.40511391728}},
    {"elam",
     {.exact_outer = true},
     2.1720980686,
     0.035631924654,
     0.35316235227,
     {0.57123559565, 0.8784839062, -0.003979888033, 0.64742979949, 0.61968549062}},
    {"elam",
     {.memory = true},
     2.4824920202,
     0.036712781161,
     0.35484820449,
     {0.86653949412, 0.99958012975, -0.0076535941167, 0.71755115154, 0.51229452383}},
    {"elam",
     {.splits = 2},
     2.415866617,
     0.035877535611,
     0.42013692815,
     {0.85795766172, 1, -0.0076496393377, 0.71711934921, 0.51229454123, 0.035952885846, -0.0070819083578}},
    {"elam",
     {.free_run = true, .splits = 3},
     2.1720990702,
     0.034316081761,
     0.3684038031,
     {0.86126280049, 1, -0.0078130696736, 0.67749165975, 0.41170079225, 0.027563834261, 0, -0.085948503671,
      -0.034261758851}},
    {"elam",
     {.memory = true, .splits = 2},
     2.4923571608,
     0.037183204457,
     0.34226738525,
     {0.85795766172, 1, -0.0076496393377, 0.71711934921, 0.51229454123, 0.035952885846, -0.0070819083578}},
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
    const std::vector<ModelParameter> parameters = fit.model->parameters();
    REQUIRE(parameters.size() == was.parameters.size());
    for (std::size_t k = 0; k < parameters.size(); ++k) {
      CAPTURE(parameters[k].name);
      CHECK(parameters[k].value == Approx(was.parameters[k]).epsilon(100.0 * epsilon).margin(1e-13));
    }
  }
}
