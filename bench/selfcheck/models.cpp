#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "analysis/identify/fit_data.h"
#include "analysis/models/elam_hysteresis.h"
#include "analysis/models/gpi.h"
#include "analysis/models/mpi.h"
#include "analysis/models/poly.h"
#include "bench/benchmarks/synthetic_array.h"
#include "bench/selfcheck/known_models.h"

namespace tactbench::bench {

namespace {

using namespace analysis;

constexpr double kKnownSpan = 60.0, kKnownTop = 3.49;  // psi, V

// Near the paper's sensor, but none of the points that a search starts from.
const GpiParameters known_gpi{.a0 = 0.62,
                              .a1 = 0.047,
                              .a2 = 1.05,
                              .a3 = 1.55,
                              .b0 = 11.0,
                              .b1 = 0.091,
                              .b2 = -1.8,
                              .b3 = 1.6,
                              .alpha = 0.33,
                              .rho = 1.6,
                              .tau = 3.9};
const MpiParameters known_mpi{.a1 = 0.1, .a2 = -0.001, .a3 = 5e-6, .rho = 3.0, .tau = 0.7};

PolyModel known_poly() {
  const std::array<double, 6> up{1.6, -1.0, 0.5, -0.2, 0.06, 0.04}, down{2.2, -1.9, 0.6, 0.2, -0.1, 0.0};
  PolyParameters parameters;
  for (std::size_t k = 0; k < kPolyOrder; ++k) {
    const double power = std::pow(kKnownSpan, static_cast<double>(k + 1));
    parameters.a[kPolyOrder - 1 - k] = kKnownTop * up[k] / power;
    parameters.b[kPolyOrder - 1 - k] = kKnownTop * down[k] / power;
  }
  return {parameters, 0.0, kKnownSpan, 0.0, kKnownTop};
}

ElamModel known_elam() {
  std::mt19937 random(11);
  return taxel_like_the_paper(random);
}

}  // namespace

std::vector<std::unique_ptr<HysteresisModel>> known_models() {
  std::vector<std::unique_ptr<HysteresisModel>> models;
  models.push_back(std::make_unique<ElamHysteresis>(known_elam()));
  models.push_back(std::make_unique<GpiModel>(known_gpi, 0.0, kKnownSpan, 0.0));
  models.push_back(std::make_unique<MpiModel>(known_mpi, 0.0, kKnownSpan, 0.3));
  models.push_back(std::make_unique<PolyModel>(known_poly()));
  return models;
}

FitData data_made_by(const HysteresisModel& model) {
  const std::vector<std::vector<double>> sequences = table_1_levels();
  std::vector<double> sweep;
  for (int i = 0; i <= 60; ++i) sweep.push_back(i <= 30 ? 2.0 * i : 120.0 - 2.0 * i);
  const std::vector<double> y = predict(model, sweep);
  const std::vector<double> grid(sweep.begin(), sweep.begin() + 31), up(y.begin(), y.begin() + 31);
  std::vector<double> down(y.rbegin(), y.rbegin() + 31);
  down.front() = up.front();
  FitData data{{}, PatternCurve(grid, up, up.front(), up.back()), PatternCurve(grid, down, up.front(), up.back())};
  if (const auto* elam = dynamic_cast<const ElamHysteresis*>(&model)) {
    data.ascending = elam->elam().ascending;
    data.descending = elam->elam().descending;
  } else if (model.name() == "gpi") {  // it does not end where it starts: its own loop would move its origin
    const std::vector<double> ends{0.0, kKnownSpan}, volts{0.0, kKnownTop};
    data.ascending = data.descending = PatternCurve(ends, volts, 0.0, kKnownTop);
  }
  for (const std::vector<double>& levels : sequences)
    data.histories.push_back({"known", levels, predict(model, levels), branches_along(levels), {}, {}});
  return data;
}

namespace {

std::vector<double> random_history(unsigned seed, double low, double high) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(low, high);
  std::vector<double> inputs{low};
  for (int turn = 0; turn < 10; ++turn) {
    const double from = inputs.back(), to = uniform(random);
    for (int k = 1; k <= 5; ++k) inputs.push_back(from + (to - from) * k / 5.0);
  }
  return inputs;
}

// Outputs of two models along histories that none was fitted on, as a share of the first one's span.
double largest_departure(const HysteresisModel& truth, const HysteresisModel& fitted) {
  const std::vector<double> ends{truth.x_low(), truth.x_high()};
  const std::vector<double> span = predict(truth, ends);
  double worst = 0.0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const std::vector<double> inputs = random_history(seed, truth.x_low(), truth.x_high());
    const std::vector<double> y = predict(truth, inputs), z = predict(fitted, inputs);
    for (std::size_t i = 0; i < y.size(); ++i) worst = std::max(worst, std::abs(y[i] - z[i]));
  }
  return worst / (span[1] - span[0]);
}

struct KnownTolerance {
  std::vector<std::size_t> parameters;  // those that data determine; others share a scale
  double of_parameters, of_outputs;
};
KnownTolerance tolerance_of(const std::string& model) {
  if (model == "elam") return {{0, 1, 2, 3, 4}, 1e-4, 1e-6};
  if (model == "gpi") return {{1, 5}, 1e-4, 1e-6};  // a1 and b1: 8 of 11 are independent [A16]
  if (model == "mpi") return {{0, 1, 2, 3, 4}, 1e-3, 1e-6};
  return {{}, 0.0, 1e-7};  // POLY: one function, many coefficients [A2]
}

// Outputs that can be reached, with turns at random: the largest |direct(inverse(y)) - y|, of the output's span.
double worst_round_trip(const HysteresisModel& model, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform;
  const auto state = model.state();
  const double bottom = state->output_at(model.x_low()), span = state->output_at(model.x_high()) - bottom;
  std::vector<double> outputs{bottom};
  for (int turn = 0; turn < 8; ++turn) {
    const double low = state->output_at(model.x_low()), high = state->output_at(model.x_high());
    const double from = outputs.back(), to = low + (high - low) * uniform(random);
    for (int k = 1; k <= 4; ++k) {
      outputs.push_back(from + (to - from) * k / 4.0);
      state->go(state->input_at(outputs.back()));
    }
  }
  const std::vector<double> again = predict(model, invert(model, outputs));
  double worst = 0.0;
  for (std::size_t i = 0; i < outputs.size(); ++i) worst = std::max(worst, std::abs(again[i] - outputs[i]));
  return worst / span;
}

}  // namespace

std::string expected_of_fit(const std::string& model) {
  const KnownTolerance tolerance = tolerance_of(model);
  const std::string parameters = tolerance.parameters.empty()
                                     ? std::string()
                                     : fmt::format("{} parameters within {:g} of their ranges or values, ",
                                                   tolerance.parameters.size(), tolerance.of_parameters);
  return fmt::format("{}outputs on 20 other histories within {:g} of full scale", parameters, tolerance.of_outputs);
}

SelfcheckAnswer judge_fit(const HysteresisModel& truth, const HysteresisModel& fitted) {
  const KnownTolerance tolerance = tolerance_of(truth.name());
  const std::vector<ModelParameter> known = truth.parameters(), got = fitted.parameters();
  double worst = 0.0;
  for (const std::size_t i : tolerance.parameters) {
    const double scale = std::max(std::abs(known.at(i).value), 1e-12);
    worst = std::max(worst, std::abs(got.at(i).value - known.at(i).value) / scale);
  }
  const double outputs = largest_departure(truth, fitted);
  return {worst <= tolerance.of_parameters && outputs <= tolerance.of_outputs,
          fmt::format("{}outputs within {:.2g}",
                      tolerance.parameters.empty() ? "" : fmt::format("parameters within {:.2g}, ", worst), outputs)};
}

SelfcheckAnswer judge_round_trips(const HysteresisModel& model) {
  double worst = 0.0;
  for (unsigned seed = 0; seed < 200; ++seed) worst = std::max(worst, worst_round_trip(model, seed));
  return {worst <= 1e-9, fmt::format("within {:.2g}", worst)};
}

SelfcheckLines check_known_fits() {
  SelfcheckLines lines;
  for (const auto& truth : known_models())
    lines.push_back(
        selfchecked("identification", fmt::format("{} from noiseless data of a known {}", truth->name(), truth->name()),
                    expected_of_fit(truth->name()),
                    [&] { return judge_fit(*truth, *identify(truth->name(), data_made_by(*truth)).model); }));
  return lines;
}

SelfcheckLines check_round_trips() {
  SelfcheckLines lines;
  for (const auto& model : known_models())
    lines.push_back(selfchecked("inverse", fmt::format("{}: direct of inverse on 200 random histories", model->name()),
                                "the output again, within 1e-09 of full scale",
                                [&] { return judge_round_trips(*model); }));
  return lines;
}

}  // namespace tactbench::bench
