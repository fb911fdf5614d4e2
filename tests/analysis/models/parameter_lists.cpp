// Lists of the models' parameters, whole: names, values, units, bounds, and which are held by convention. And when a
// parameter counts as lying at its bound.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <limits>
#include <memory>
#include <string>

#include "analysis/models/elam.h"
#include "analysis/models/gpi.h"
#include "analysis/models/linearised.h"
#include "analysis/models/monotone.h"
#include "analysis/models/mpi.h"
#include "analysis/models/poly.h"
#include "analysis/models/preisach.h"

using namespace tactbench::analysis;

namespace {

constexpr double kNoBound = std::numeric_limits<double>::infinity();

std::string listed(const HysteresisModel& model) {
  std::string lines;
  for (const ModelParameter& p : model.parameters())
    lines += fmt::format("{} {:g} {} [{:g}, {:g}]{}\n", p.name, p.value, p.unit, p.low, p.high, p.fixed ? " held" : "");
  return lines;
}

PatternCurve bent_line(double middle) {
  const std::vector<double> x{10.0, 30.0, 60.0}, y{0.0, middle, 3.0};
  return {x, y, 0.0, 3.0};
}

}  // namespace

TEST_CASE("models: list their parameters with units and bounds") {
  const ElamModel elam{bent_line(1.0), bent_line(2.0), {0.1, 0.2, 0.015, 0.3, 0.4}, {}};
  CHECK(listed(ElamHysteresis(elam, false)) ==
        "alpha_d 0.1 1 [0, 1]\nbeta_d 0.2 1 [0, 1]\nalpha_a1 0.015 1/x [-0.02, 0.02]\nalpha_a0 0.3 1 [0, 1]\n"
        "beta_a 0.4 1 [0, 1]\n");
  CHECK(kMaxPieceLog == 2.0);
  CHECK(listed(ElamHysteresis(elam, true, {{0.5}, {-0.5, 0.25}, {1.0, -1.0}, {2.0}})) ==
        "alpha_d 0.1 1 [0, 1]\nbeta_d 0.2 1 [0, 1]\nalpha_a1 0.015 1/x [-0.02, 0.02]\nalpha_a0 0.3 1 [0, 1]\n"
        "beta_a 0.4 1 [0, 1]\nlog_d1 0.5 1 [-2, 2]\nlog_d2 -0.5 1 [-2, 2]\nlog_d3 0.25 1 [-2, 2]\n"
        "log_a1 1 1 [-2, 2]\nlog_a2 -1 1 [-2, 2]\nlog_a3 2 1 [-2, 2]\n");
  CHECK(listed(GpiModel({1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11}, 0.0, 60.0, 0.0)) ==
        "a0 1 y [0, inf]\na1 2 1/x [0, inf]\na2 3 1 [-inf, inf] held\na3 4 y [-inf, inf]\n"
        "b0 5 y [0, inf]\nb1 6 1/x [0, inf]\nb2 7 1 [-inf, inf] held\nb3 8 y [-inf, inf]\n"
        "alpha 9 y [0, inf]\nrho 10 1 [0, inf] held\ntau 11 1/y [-inf, inf]\n");
  CHECK(listed(MpiModel({0.1, 0.2, 0.3, 4, -0.5}, 0.0, 60.0, 0.0)) ==
        "a1 0.1 y/x [-inf, inf]\na2 0.2 y/x^2 [-inf, inf]\na3 0.3 y/x^3 [-inf, inf]\nrho 4 y [0, inf]\n"
        "tau -0.5 1 [-5, 5]\n");
  const PolyParameters poly{{1, 2, 3, 4, 5, 6, 7}, {8, 9, 10, 11, 12, 13, 14}};
  CHECK(listed(PolyModel(poly, 0.0, 1.0, 0.0, 3.0)) ==
        "a0 1 y/x^6 [-inf, inf]\na1 2 y/x^5 [-inf, inf]\na2 3 y/x^4 [-inf, inf]\na3 4 y/x^3 [-inf, inf]\n"
        "a4 5 y/x^2 [-inf, inf]\na5 6 y/x [-inf, inf]\na6 7 y [-inf, inf]\n"
        "b0 8 y/x^6 [-inf, inf]\nb1 9 y/x^5 [-inf, inf]\nb2 10 y/x^4 [-inf, inf]\nb3 11 y/x^3 [-inf, inf]\n"
        "b4 12 y/x^2 [-inf, inf]\nb5 13 y/x [-inf, inf]\nb6 14 y [-inf, inf]\n");
  // Weights that are 0 are none.
  const auto film = std::make_shared<PreisachModel>(0.0, 60.0, 0.0, std::vector<double>{1, 0, 2, 3, 0, 4});
  const std::string weights = "w(0,0) 1 y [0, inf]\nw(1,1) 2 y [0, inf]\nw(2,0) 3 y [0, inf]\nw(2,2) 4 y [0, inf]\n";
  CHECK(listed(*film) == weights);
  CHECK(listed(LinearisedModel({0.5, 0.1}, film)) == "c 0.1 1/y [0, inf]\n" + weights);
  CHECK(listed(LinearisedModel({0.5, 0.0}, film)) == "c 0 1/y [-inf, inf]\n" + weights);
  CHECK(listed(MonotoneModel(bent_line(1.0))) == "y0 0 y [-inf, inf]\ny1 1 y [-inf, inf]\ny2 3 y [-inf, inf]\n");
}

TEST_CASE("models: state their operations per sample, which increase with ELAM's pieces") {
  const ElamModel elam{bent_line(1.0), bent_line(2.0), {}, {}};
  CHECK(ElamHysteresis(elam, false).operations_per_sample() == 9);
  CHECK(ElamHysteresis(elam, false, {{0.1}, {}, {}, {0.1}}).operations_per_sample() == 13);
  CHECK(ElamHysteresis(elam, false, {{0.1}, {0.1}, {0.1}, {0.1}}).operations_per_sample() == 14);
  CHECK(GpiModel({}, 0.0, 60.0, 0.0).operations_per_sample() == 39);
  CHECK(MpiModel({}, 0.0, 60.0, 0.0).operations_per_sample() == 56);
  CHECK(PreisachModel(0.0, 60.0, 0.0, {1.0}).operations_per_sample() == 16);
  CHECK(PolyModel({{0, 0, 0, 0, 0, 1, 0}, {0, 0, 0, 0, 0, 1, 0}}, 0.0, 1.0, 0.0, 3.0).operations_per_sample() == 18);
  CHECK(MonotoneModel(bent_line(1.0)).operations_per_sample() == 3);
  const auto film = std::make_shared<PreisachModel>(0.0, 60.0, 0.0, std::vector<double>{1.0});
  CHECK(LinearisedModel({}, film).operations_per_sample() == 18);
}

TEST_CASE("model parameter: is at its bound within 1e-9 of the distance between both bounds, or of 1 if open") {
  const auto at = [](double value, double low, double high) {
    return ModelParameter{"p", value, "1", low, high}.at_bound();
  };
  CHECK(at(2.0, 2.0, 6.0));
  CHECK(at(2.0 + 3.9e-9, 2.0, 6.0));
  CHECK_FALSE(at(2.0 + 4.1e-9, 2.0, 6.0));
  CHECK(at(6.0 - 3.9e-9, 2.0, 6.0));
  CHECK_FALSE(at(6.0 - 4.1e-9, 2.0, 6.0));
  CHECK_FALSE(at(4.0, 2.0, 6.0));
  CHECK(at(0.99e-9, 0.0, kNoBound));
  CHECK_FALSE(at(1.01e-9, 0.0, kNoBound));
  CHECK(at(-0.99e-9, -kNoBound, 0.0));
  CHECK_FALSE(at(-1.01e-9, -kNoBound, 0.0));
  CHECK_FALSE(at(0.0, -kNoBound, kNoBound));
}
