// Identification of the models other than ELAM: what generated the data comes out again, and data that cannot carry a
// model are refused.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "analysis/identify/fit_models.h"
#include "analysis/identify/histories.h"
#include "analysis/identify/rivals/nnls.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/models/model_json.h"
#include "analysis/models/poly.h"
#include "analysis/models/preisach.h"
#include "tests/analysis/support/alike.h"
#include "tests/analysis/support/fit_samples.h"
#include "tests/analysis/support/models.h"

using namespace synthetic;

namespace {

constexpr std::array<const char*, 5> kOthers = {"gpi", "mpi", "poly", "preisach", "monotone"};

// The external loop and the paper's two sequences as `model` gives them.
FitData data_from(const HysteresisModel& model, const std::vector<std::vector<double>>& turns) {
  const double low = model.x_low();
  std::vector<double> x = levels_of({0, 60, 0});
  for (double& at : x) at += low;
  std::vector<double> y = predict(model, x);
  const std::vector<double> grid(x.begin(), x.begin() + 31), up(y.begin(), y.begin() + 31);
  std::vector<double> down(y.rbegin(), y.rbegin() + 31);
  down.front() = up.front();
  FitData data{{}, PatternCurve(grid, up, up.front(), up.back()), PatternCurve(grid, down, up.front(), up.back())};
  for (const auto& sequence : turns) {
    std::vector<double> inputs = levels_of(sequence);
    for (double& at : inputs) at += low;
    History history{"made", inputs, predict(model, inputs), branches_along(inputs), {}, {}};
    data.histories.push_back(std::move(history));
  }
  return data;
}

double largest_difference(const HysteresisModel& a, const HysteresisModel& b) {
  std::mt19937 random(5);
  double worst = 0.0;
  for (int n = 0; n < 20; ++n) {
    const std::vector<double> inputs = random_inputs(random, 10, a.x_low(), a.x_high(), 5);
    const std::vector<double> y = predict(a, inputs), z = predict(b, inputs);
    for (std::size_t i = 0; i < y.size(); ++i) worst = std::max(worst, std::abs(y[i] - z[i]));
  }
  return worst;
}

}  // namespace

TEST_CASE("identification: noiseless data return the model that made them") {
  SECTION("MPI") {
    for (const double low : {0.0, 5.0}) {
      const MpiModel truth({.a1 = 0.1, .a2 = -0.001, .a3 = 5e-6, .rho = 3.0, .tau = 0.7}, low, low + 60.0, 0.3);
      const ModelFit fit = identify("mpi", data_from(truth, {kDescendingTurns, kAscendingTurns}), {});
      CHECK(fit.j < 1e-12);
      CHECK(fit.model->parameters()[4].value == Approx(0.7).epsilon(1e-4));
      CHECK(fit.model->parameters()[3].value == Approx(3.0).epsilon(1e-4));
      CHECK(fit.samples == 660);
      CHECK(largest_difference(truth, *fit.model) < 1e-6);
    }
  }
  SECTION("POLY") {
    for (const bool free_run : {false, true}) {
      const PolyModel truth = rising_poly();
      const ModelFit fit =
          identify("poly", data_from(truth, {kDescendingTurns, kAscendingTurns}), {.free_run = free_run});
      CHECK(fit.j < 1e-16);
      CHECK(largest_difference(truth, *fit.model) < 1e-8);
    }
  }
  SECTION("Preisach") {
    const PreisachModel truth = random_preisach();
    FitData data = data_from(truth, {kDescendingTurns, kAscendingTurns});
    std::mt19937 random(3);
    for (int n = 0; n < 12; ++n) {  // inputs that distinguish all cells
      const std::vector<double> inputs = random_inputs(random, 40, 0.0, 60.0, 4);
      data.histories.push_back({"random", inputs, predict(truth, inputs), branches_along(inputs), {}, {}});
    }
    const ModelFit fit = identify("preisach", data, {});
    CHECK(fit.max_error < 1e-5);
    CHECK(largest_difference(truth, *fit.model) < 1e-3);
  }
  SECTION("GPI") {
    const GpiModel truth(kGpiTable2, 0.0, 60.0, 0.0);
    FitData data = data_from(truth, {kDescendingTurns});
    // The printed model does not start where its loop ends: its own loop as the pattern would move its origin.
    const PatternCurve pattern({std::vector<double>{0, 60}}, {std::vector<double>{0, 3.49}}, 0.0, 3.49);
    data.ascending = data.descending = pattern;
    const ModelFit fit = identify("gpi", data, {});
    CHECK(fit.j < 1e-6);
    CHECK(fit.starts == 16);
    CHECK(fit.model->parameters()[1].value == Approx(0.0524).epsilon(0.02));  // the same whatever the scale
    CHECK(fit.model->parameters()[5].value == Approx(0.0825).epsilon(0.02));
  }
  SECTION("monotone") {
    const MonotoneModel truth(PatternCurve(std::vector<double>{0, 20, 60}, std::vector<double>{0, 2, 3}, 0.0, 3.0));
    const ModelFit fit = identify("monotone", data_from(truth, {kDescendingTurns}), {});
    CHECK(fit.j < 1e-20);
    CHECK(largest_difference(truth, *fit.model) < 1e-12);
  }
}

TEST_CASE("identification: reported errors equal those of the model evaluated along the data") {
  for (const bool free_run : {false, true}) {
    const FitData data = paper_both(0.032, 0.0205);
    for (const char* name : kOthers) {
      const ModelFit fit = identify(name, data, {.free_run = free_run});
      double j = 0.0, sum = 0.0, largest = 0.0;
      int samples = 0;
      for (const History& history : data.histories) {
        const std::vector<double> y = predict_history(*fit.model, history, free_run);
        for (std::size_t i = 1; i < y.size(); ++i, ++samples) {
          const double off = std::abs(y[i] - history.y[i]);
          j += off * off;
          sum += off;
          largest = std::max(largest, off);
        }
      }
      INFO(name << (free_run ? ", free run" : ""));
      CHECK(fit.samples == samples);
      CHECK(fit.j == Approx(j).epsilon(1e-9));
      CHECK(fit.mean_error == Approx(sum / samples).epsilon(1e-9));
      CHECK(fit.max_error == Approx(largest).epsilon(1e-9));
      CHECK(fit.full_scale == 3.49);
      CHECK(fit.model->name() == name);
    }
  }
}

TEST_CASE("identification: changing any fitted parameter by 0.1 % does not reduce the error") {
  const FitData data = paper_both(0.032, 0.0205);
  for (const char* name : {"gpi", "mpi", "poly"}) {
    const ModelFit fit = identify(name, data);
    const nlohmann::ordered_json best = model_json(*fit.model);
    const auto j_of = [&](const nlohmann::ordered_json& json) {
      const auto model = model_from_json(json);
      double j = 0.0;
      for (const History& history : data.histories) {
        const std::vector<double> y = predict_history(*model, history, false);
        for (std::size_t i = 1; i < y.size(); ++i) j += (y[i] - history.y[i]) * (y[i] - history.y[i]);
      }
      return j;
    };
    const nlohmann::ordered_json flat = best.flatten();
    for (const auto& [member, value] : flat.items()) {
      // POLY: its last coefficient is a constant that cancels. A range is data, not a parameter.
      if (!value.is_number() || member == "/x_low" || member == "/x_high" || member.starts_with("/y_")) continue;
      for (const double factor : {0.999, 1.001}) {
        nlohmann::ordered_json moved = best;
        moved[nlohmann::ordered_json::json_pointer(member)] = value.get<double>() * factor;
        INFO(name << member);
        CHECK(j_of(moved) >= fit.j * (1.0 - 1e-9));
      }
    }
  }
}

// Measured inputs: off the grid, wavering within a branch, branches of unequal length, a range that does not begin at
// 0, a history that starts in the middle.
TEST_CASE("identification: measured inputs, unequal branches and an offset origin are fitted within error limits") {
  std::mt19937 random(11);
  std::normal_distribution<double> normal;
  const ElamModel truth = model_of(paper_loop(), kPrinted, true);
  const auto moved = [](const PatternCurve& curve) {
    std::vector<double> x(curve.x().begin(), curve.x().end()), y(curve.y().begin(), curve.y().end());
    for (double& at : x) at += 100.0;
    for (double& at : y) at += 1.0;
    return PatternCurve(x, y, y.front(), y.back());
  };
  FitData data{{}, moved(truth.ascending), moved(truth.descending)};
  for (const std::vector<double>& turns : {kDescendingTurns, std::vector<double>{30, 60, 7, 44, 13, 60, 0}}) {
    const std::vector<double> levels = levels_of(turns);
    Plant plant(truth);
    History history{"measured", {}, {}, branches_along(levels), {}, {}};
    if (turns.front() > 0.0) plant(turns.front());
    for (const double level : levels) {
      const double real = std::clamp(level + 0.4 * normal(random), 0.0, 60.0);
      history.x.push_back(100.0 + real);
      history.y.push_back(1.0 + plant(level) + (level < 50 ? 0.05 * (real - level) : 0.0) + 0.003 * normal(random));
    }
    data.histories.push_back(std::move(history));
  }
  const double limits[] = {2.5, 4.0, 3.5, 1.0, 7.0};
  for (std::size_t n = 0; n < kOthers.size(); ++n) {
    const ModelFit fit = identify(kOthers[n], data);
    INFO(kOthers[n] << " " << 100.0 * fit.mean_error / 3.49);
    CHECK(100.0 * fit.mean_error / 3.49 < limits[n]);
    CHECK(fit.model->x_low() == 100.0);
    CHECK(fit.full_scale == Approx(3.49));
    CHECK(fit.model->state()->output_at(100.0) == Approx(1.0).margin(0.4));
  }
}

TEST_CASE("identification: errors of a long history are over all its samples, though the regressions thin it") {
  std::mt19937 random(2);
  const std::vector<double> inputs = random_inputs(random, 12000, 0.0, 60.0, 4);
  const PolyModel truth = rising_poly();
  FitData data = data_from(truth, {kDescendingTurns});
  data.histories.push_back({"long", inputs, predict(truth, inputs), branches_along(inputs), {}, {}});
  for (const char* name : {"mpi", "poly", "monotone"}) {
    // Free run: a random turn within 1 % of an end is not an external one.
    const ModelFit fit = identify(name, data, {.free_run = true});
    CHECK(fit.samples == 210 + static_cast<int>(inputs.size()) - 1);
    if (std::string(name) == "poly") CHECK(fit.j < 1e-8);
  }
}

// Fits of each model except GPI, and of ELAM's modes other than the paper's, to one set of data: none leaves more than
// these.

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

TEST_CASE("identification: each model and mode reaches a J no larger than its bound") {
  const FitData data = bounded_data();
  for (const auto& [model, options, most_j] : kBoundedFits) {
    CAPTURE(model, options.free_run, options.memory, options.splits, options.linearise);
    const ModelFit fit = identify(model, data, options);
    CHECK(fit.samples == 780);
    CHECK(fit.j <= most_j);
  }
}

// Taxels of a table whose inputs differ are fitted each by its own, and their mean where they are one.

namespace {

// A loop with one inner turn at `turn`: up x^2 / 100, down further above it by what was turned from.
TableSeries inner_loop(int taxel, double turn, double gain) {
  TableSeries series{"a", taxel, {}, {}};
  const std::vector<double> turns{0, 10, turn, 10, 0};
  double x = 0.0;
  for (std::size_t i = 0; i < turns.size(); ++i)
    for (bool first = true; first || x != turns[i]; first = false) {
      if (x != turns[i]) x += turns[i] > x ? 1.0 : -1.0;
      const bool up = i == 0 || turns[i] > turns[i - 1];
      series.input.push_back(x);
      series.output.push_back(gain * (x + (up ? 0.0 : 0.1 * x * (10.0 - x) / 10.0)));
    }
  return series;
}

}  // namespace

TEST_CASE("fit_models: taxels with different inner inputs are fitted separately, without a mean taxel") {
  const auto fitted = [&](const std::string& model, double other_turn) {
    const Histories histories =
        histories_of({inner_loop(0, 4.0, 1.0), inner_loop(1, other_turn, 2.0)}, "t", table_options(0.5, 0.0));
    return fit_models(model, histories, {}, {}, 1);
  };
  for (const std::string model : {"poly", "preisach", "mpi", "monotone"}) {
    CAPTURE(model);
    const SensorModel unlike = fitted(model, 6.0), alike = fitted(model, 4.0);
    REQUIRE(unlike.taxels.size() == 2);  // no mean of inputs that differ
    REQUIRE(alike.taxels.size() == 3);
    for (const std::size_t i : {0U, 1U}) {
      CHECK(unlike.taxels[i].reason.empty());
      CHECK(unlike.taxels[i].fitted());
      CHECK(alike.taxels[i].fitted());
    }
    CHECK(alike.taxels[2].taxel == kMeanTaxel);
    CHECK(alike.taxels[2].fit.full_scale == Approx(15.0));
    // The first taxel's fit does not depend on the second's.
    CHECK(unlike.taxels[0].fit.j == Approx(alike.taxels[0].fit.j).epsilon(1e-9).margin(1e-12));
    CHECK(unlike.taxels[1].fit.samples == alike.taxels[1].fit.samples - 4);
  }
}

// Models along histories by hand: what lies between branches, inputs that waver, measured turns; and a sensor's taxels.

namespace {

// Up 0, 1, 3 at 0, 30, 60; down 3, 2, 0 at 60, 30, 0.
const PreisachModel& small_film() {
  static const PreisachModel film(0.0, 60.0, 0.0, {1, 1, 1});
  return film;
}

std::vector<double> walked(const std::vector<double>& x, const std::vector<Branch>& branches) {
  return predict_history(small_film(), {"h", x, std::vector<double>(x.size(), 0.0), branches}, false);
}

// Up as the square of the share, down as twice the share less its square; 0 to 4.
std::shared_ptr<const PolyModel> bent_poly() {
  PolyParameters p;
  p.a[4] = 1.0;
  p.b[4] = -1.0;
  p.b[5] = 120.0;
  return std::make_shared<PolyModel>(p, 0.0, 60.0, 0.0, 4.0);
}

}  // namespace

TEST_CASE("predicted history: follows branches, and single samples outside of branches") {
  struct Row {
    const char* what;
    std::vector<double> x;
    std::vector<Branch> branches;
    std::vector<double> y;
    bool falls;
  };
  const Row rows[] = {
      {"up and down", {0, 30, 60, 45, 30, 15}, {{0, 2, true}, {2, 5, false}}, {0, 1, 3, 2.5, 2, 1}, false},
      // From 45 to 30 it would be 1.5.
      {"a step back within a branch is no turn",
       {0, 45, 30, 60, 30},
       {{0, 3, true}, {3, 4, false}},
       {0, 2, 1, 3, 2},
       false},
      {"before the only branch it is one", {0, 45, 30, 15, 30, 60}, {{3, 5, true}}, {0, 2, 1.5, 1, 1.5, 3}, false},
      {"after it, too", {0, 45, 30, 15}, {{0, 1, true}}, {0, 2, 1.5, 1}, false},
      {"no branch", {0, 45, 30, 15}, {}, {0, 2, 1.5, 1}, false},
      {"begins to fall: it came from the top", {30, 15}, {{0, 1, false}}, {2, 1}, true},
      {"falls later: it did not", {30, 45, 15}, {{1, 2, false}}, {1, 2, 1}, false},
      {"begins to rise", {15, 30}, {{0, 1, true}}, {0.5, 1}, false},
      {"falls without a branch", {30, 15}, {}, {1, 0.5}, false}};
  for (const Row& row : rows) {
    INFO(row.what);
    check_alike(walked(row.x, row.branches), row.y, 1e-12);
    CHECK(begins_falling({"h", row.x, {}, row.branches}) == row.falls);
  }
}

TEST_CASE("predicted history: a measured turning point starts the next branch, except in a free run") {
  // Up to 30 the model has 1, where 2 was measured: down to 15, half of the way, three quarters of that.
  const History history{"h", {0, 30, 15}, {0, 2, 0}, {{0, 1, true}, {1, 2, false}}};
  check_alike(predict_history(*bent_poly(), history, false), {0, 1, 1.5}, 1e-12);
  check_alike(predict_history(*bent_poly(), history, true), {0, 1, 0.75}, 1e-12);
  ModelTaxel taxel;
  taxel.fit.model = bent_poly();
  taxel.zero = 0.5;
  taxel.gain = 2.0;
  History adjusted = history;
  for (double& y : adjusted.y) y = 0.5 + 2.0 * y;
  check_alike(taxel.predicted(adjusted, false), {0.5, 2.5, 3.5}, 1e-12);
  check_alike(taxel.predicted(adjusted, true), {0.5, 2.5, 2.0}, 1e-12);
}

TEST_CASE("SensorModel: separates the mean taxel, lists fitted taxels, and handles falling outputs and the loop") {
  SensorModel model;
  model.source = "run 4";
  CHECK(model.array().empty());
  for (const int number : {3, 5, 7}) {
    ModelTaxel taxel;
    taxel.taxel = number;
    taxel.status = number == 5 ? TaxelStatus::kDead : TaxelStatus::kFitted;
    model.taxels.push_back(taxel);
  }
  CHECK(model.array().size() == 3);
  CHECK(model.fitted() == std::vector<std::size_t>{0, 2});
  CHECK(model.taxel(7).taxel == 7);
  CHECK_THROWS_WITH(model.taxel(4), Catch::Contains("4") && Catch::Contains("3"));
  model.taxels[2].taxel = kMeanTaxel;
  CHECK(model.array().size() == 2);
  CHECK(model.fitted() == std::vector<std::size_t>{0});
  ModelTaxel& taxel = model.taxels[0];
  taxel.zero = 0.5;
  taxel.gain = 2.0;
  CHECK(model.to_model(taxel, 4.5) == 2.0);
  CHECK(model.from_model(taxel, 2.0) == 4.5);
  model.falling = true;
  CHECK(model.to_model(taxel, -4.5) == 2.0);
  CHECK(model.from_model(taxel, 2.0) == -4.5);
  CHECK(taxel.full_scale() == 0.0);
  // As the model walks: 1 and 2 at 30, adjusted.
  taxel.fit.model = std::make_shared<PreisachModel>(small_film());
  set_loop(taxel, std::vector<double>{0, 30, 60});
  CHECK(taxel.ascending.y()[1] == Approx(2.5));
  CHECK(taxel.descending.y()[1] == Approx(4.5));
  CHECK(taxel.y0() == Approx(0.5));
  CHECK(taxel.yu() == Approx(6.5));
  CHECK(taxel.full_scale() == Approx(6.5));
  CHECK(ExternalBranch(taxel, true).output(30.0) == Approx(2.5));
  CHECK(ExternalBranch(taxel, false).output(30.0) == Approx(4.5));
  CHECK(ExternalBranch(taxel, true).input(4.5) == Approx(45.0));
  CHECK(ExternalBranch(taxel, false).input(4.5) == Approx(30.0));
  // As given, in the model's outputs.
  set_loop(taxel, std::vector<double>{0, 30, 60}, std::vector<double>{-9, 1, 2}, std::vector<double>{-9, 1.5, 2});
  CHECK(taxel.ascending.y()[1] == 2.5);
  CHECK(taxel.descending.y()[1] == 3.5);
  CHECK(taxel.full_scale() == 17.5);
}
