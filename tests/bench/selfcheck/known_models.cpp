// selfcheck's known models give what another program, in Python, works out of their equations; and what it calls
// recovered or inverted lies within what it says, judged by models that are off by a known amount.
#include "bench/selfcheck/known_models.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "analysis/models/elam_hysteresis.h"

using namespace tactbench;
using namespace tactbench::bench;
using analysis::ModelParameter;

namespace {

// All calls of the states of one line.
struct LineCalls {
  int states = 0;
  std::vector<std::vector<double>> inputs;  // of each state
};

// Output 0.05 V/psi and `offset`; its inverse errs by `error_psi`.
class LineModel final : public analysis::HysteresisModel {
 public:
  explicit LineModel(std::string name, std::vector<double> parameters = {}) : name_(std::move(name)) {
    for (const double value : parameters) {
      ModelParameter parameter;
      parameter.value = value;
      parameters_.push_back(parameter);
    }
  }
  double offset = 0.0, error_psi = 0.0;
  mutable LineCalls calls;

  [[nodiscard]] std::string name() const override { return name_; }
  [[nodiscard]] std::vector<ModelParameter> parameters() const override { return parameters_; }
  [[nodiscard]] double x_low() const override { return 0.0; }
  [[nodiscard]] double x_high() const override { return 60.0; }
  [[nodiscard]] int operations_per_sample() const override { return 1; }
  [[nodiscard]] nlohmann::ordered_json to_json() const override { return {}; }
  [[nodiscard]] std::unique_ptr<analysis::ModelState> state() const override {
    calls.inputs.emplace_back();
    return std::make_unique<Line>(*this, static_cast<std::size_t>(calls.states++));
  }

 private:
  class Line final : public analysis::ModelState {
   public:
    Line(const LineModel& model, std::size_t number) : model_(model), number_(number) {}
    void reset() override {}
    [[nodiscard]] double output_at(double x) const override { return 0.05 * x + model_.offset; }
    [[nodiscard]] double input_at(double y) const override { return (y - model_.offset) / 0.05 + model_.error_psi; }
    void go(double x) override { model_.calls.inputs[number_].push_back(x); }

   private:
    const LineModel& model_;
    std::size_t number_;
  };
  std::string name_;
  std::vector<ModelParameter> parameters_;
};

const std::map<std::string, std::vector<double>>& outputs_by_python() {
  static const std::map<std::string, std::vector<double>> list = {
      {"elam", {0.0, 2.10077920147374, 2.81289731357367, 2.38296550145603, 1.01073107822528, 2.47883974152128}},
      {"gpi",
       {-0.349260432699923, 2.19584686504441, 2.91544955531854, 2.91544955531854, 1.99337208204905, 2.65185898820238}},
      {"mpi", {0.3, 2.77788416581076, 4.33125876620215, 2.84337460039139, 1.30779153371512, 3.36567569952589}},
      {"poly", {0.0, 2.102725, 3.49, 2.47571875, 1.10566036522634, 2.74754486831276}}};
  return list;
}

SelfcheckAnswer fit_off_by(const std::string& name, const std::vector<double>& known, const std::vector<double>& got,
                           double share_of_span) {
  const LineModel truth(name, known);
  LineModel fitted(name, got);
  fitted.offset = 3.0 * share_of_span;
  return judge_fit(truth, fitted);
}

}  // namespace

TEST_CASE("selfcheck's known models: outputs at 0, 30, 60, 30, 10 and 40 psi") {
  const auto models = known_models();
  std::string names;
  for (const auto& model : models) {
    names += model->name() + " ";
    INFO(model->name());
    const std::vector<double> outputs = predict(*model, std::vector<double>{0.0, 30.0, 60.0, 30.0, 10.0, 40.0});
    const std::vector<double>& known = outputs_by_python().at(model->name());
    for (std::size_t i = 0; i < known.size(); ++i) CHECK(outputs[i] == Approx(known[i]).epsilon(1e-12).margin(1e-13));
    CHECK(model->x_low() == 0.0);
    CHECK(model->x_high() == 60.0);
  }
  CHECK(names == "elam gpi mpi poly ");
}

TEST_CASE("selfcheck's data of a known model: both sequences of Table 1, and its external loop at 31 pressures") {
  for (const auto& model : known_models()) {
    INFO(model->name());
    const analysis::FitData data = data_made_by(*model);
    REQUIRE(data.histories.size() == 2);
    CHECK(data.histories[0].x.size() == 211);
    CHECK(data.histories[1].x.size() == 451);
    CHECK(data.histories[0].branches.size() == 12);
    CHECK(data.histories[1].branches.size() == 20);
    const std::vector<double>& known = outputs_by_python().at(model->name());
    // 0-60-0 psi in steps of 2 psi at the beginning of the first.
    for (const auto& history : data.histories) {
      CHECK(history.name == "known");
      CHECK(history.y[0] == Approx(known[0]).margin(1e-13));
      CHECK(history.y[15] == Approx(known[1]).epsilon(1e-12));
      CHECK(history.y[30] == Approx(known[2]).epsilon(1e-12));
      CHECK(history.y[45] == Approx(known[3]).epsilon(1e-12));
    }
    CHECK(data.histories[0].y[55] == Approx(known[4]).epsilon(1e-12));
    const auto at = [](const analysis::PatternCurve& curve, double psi) { return curve(psi); };
    if (model->name() == "gpi") {  // a straight line of 3.49 V: its own loop does not end where it starts
      CHECK(at(data.ascending, 0.0) == 0.0);
      CHECK(at(data.ascending, 30.0) == Approx(1.745).epsilon(1e-12));
      CHECK(at(data.descending, 60.0) == Approx(3.49).epsilon(1e-12));
      continue;
    }
    REQUIRE(data.ascending.x().size() == 31);
    REQUIRE(data.descending.x().size() == 31);
    for (std::size_t i = 0; i < 31; ++i) CHECK(data.ascending.x()[i] == Approx(2.0 * static_cast<double>(i)));
    if (model->name() == "elam") {  // its own patterns, from which its branches are split off
      const analysis::ElamModel& elam = dynamic_cast<const analysis::ElamHysteresis&>(*model).elam();
      CHECK(at(data.ascending, 30.0) == elam.ascending(30.0));
      CHECK(at(data.descending, 30.0) == elam.descending(30.0));
      continue;
    }
    CHECK(at(data.ascending, 30.0) == Approx(known[1]).epsilon(1e-12));
    CHECK(at(data.ascending, 60.0) == Approx(known[2]).epsilon(1e-12));
    CHECK(at(data.descending, 60.0) == Approx(known[2]).epsilon(1e-12));
    CHECK(at(data.descending, 30.0) == Approx(known[3]).epsilon(1e-12));
    CHECK(at(data.descending, 10.0) == Approx(known[4]).epsilon(1e-12));
    CHECK(at(data.descending, 0.0) == at(data.ascending, 0.0));
    // Each of the 31, from 0 up and from 60 psi down.
    const std::vector<double>& first = data.histories[0].y;
    for (std::size_t i = 1; i < 30; ++i) {
      CHECK(data.ascending.y()[i] == Approx(first[i]).epsilon(1e-9));
      CHECK(data.descending.y()[i] == Approx(first[60 - i]).epsilon(1e-9));
    }
  }
}

TEST_CASE("selfcheck: a fit has recovered the parameters that data determine, and its outputs") {
  CHECK(expected_of_fit("elam") ==
        "5 parameters within 0.0001 of their ranges or values, outputs on 20 other histories within 1e-06 of full "
        "scale");
  CHECK(expected_of_fit("gpi") ==
        "2 parameters within 0.0001 of their ranges or values, outputs on 20 other histories within 1e-06 of full "
        "scale");
  CHECK(expected_of_fit("mpi") ==
        "5 parameters within 0.001 of their ranges or values, outputs on 20 other histories within 1e-06 of full "
        "scale");
  CHECK(expected_of_fit("poly") == "outputs on 20 other histories within 1e-07 of full scale");
  struct Tolerances {
    const char* model;
    std::vector<std::size_t> judged;
    double of_parameters, of_outputs;
  };
  for (const auto& [model, judged, of_parameters, of_outputs] :
       {Tolerances{"elam", {0, 1, 2, 3, 4}, 1e-4, 1e-6}, Tolerances{"gpi", {1, 5}, 1e-4, 1e-6},
        Tolerances{"mpi", {0, 1, 2, 3, 4}, 1e-3, 1e-6}, Tolerances{"poly", {}, 1e-4, 1e-7}}) {
    INFO(model);
    const std::vector<double> known(11, -2.0);
    CHECK(fit_off_by(model, known, known, 0.0).pass);
    CHECK(fit_off_by(model, known, known, 0.9 * of_outputs).pass);
    CHECK(fit_off_by(model, known, known, -0.9 * of_outputs).pass);
    CHECK_FALSE(fit_off_by(model, known, known, 1.1 * of_outputs).pass);
    CHECK_FALSE(fit_off_by(model, known, known, -1.1 * of_outputs).pass);
    for (std::size_t i = 0; i < known.size(); ++i) {
      INFO("parameter " << i);
      std::vector<double> near = known, far = known, below = known;
      near[i] *= 1.0 + 0.9 * of_parameters;
      far[i] *= 1.0 + 1.1 * of_parameters;
      below[i] *= 1.0 - 1.1 * of_parameters;
      const bool counts = std::ranges::find(judged, i) != judged.end();
      CHECK(fit_off_by(model, known, near, 0.0).pass);
      CHECK(fit_off_by(model, known, far, 0.0).pass == !counts);
      CHECK(fit_off_by(model, known, below, 0.0).pass == !counts);
    }
  }
}

TEST_CASE("selfcheck: a fit's answer names its worst parameter and its worst output") {
  const std::vector<double> known{1.0, 2.0, 4.0, 0.0, -5.0};
  CHECK(fit_off_by("elam", known, {1.00001, 2.0, 4.0001, 0.0, -5.00005}, 2e-7).found ==
        "parameters within 2.5e-05, outputs within 2e-07");
  CHECK(fit_off_by("elam", known, {1.0, 2.0, 4.0, 5e-17, -5.0}, 0.0).found ==
        "parameters within 5e-05, outputs within 0");  // of a 0: in units of 1e-12
  CHECK(fit_off_by("poly", known, {9.0, 9.0, 9.0, 9.0, 9.0}, 0.03).found == "outputs within 0.03");
}

TEST_CASE("selfcheck: outputs of a fit are compared along twenty histories of ten random turns") {
  const LineModel truth("poly"), fitted("poly");
  CHECK(judge_fit(truth, fitted).pass);
  REQUIRE(truth.calls.states == 21);
  REQUIRE(fitted.calls.states == 20);
  CHECK(truth.calls.inputs[0] == std::vector<double>{0.0, 60.0});  // its span
  for (std::size_t i = 0; i < 20; ++i) {
    const std::vector<double>& inputs = fitted.calls.inputs[i];
    CHECK(inputs == truth.calls.inputs[i + 1]);
    REQUIRE(inputs.size() == 51);
    CHECK(inputs.front() == 0.0);
    for (std::size_t k = 0; k + 5 < 51; k += 5)
      for (std::size_t j = 1; j <= 5; ++j)
        CHECK(inputs[k + j] ==
              Approx(inputs[k] + (inputs[k + 5] - inputs[k]) * static_cast<double>(j) / 5.0).epsilon(1e-12));
  }
  // By the same generator and the seeds 1 and 20, in Python.
  CHECK(fitted.calls.inputs[0][5] == Approx(59.83108849381593));
  CHECK(fitted.calls.inputs[0][10] == Approx(55.95344168208993));
  CHECK(fitted.calls.inputs[0][50] == Approx(50.778655100690436));
  CHECK(fitted.calls.inputs[19][5] == Approx(53.244702293371745));
  CHECK(fitted.calls.inputs[19][50] == Approx(48.99325785032264));
}

TEST_CASE("selfcheck: an inverse may err by a thousand millionth of full scale, along 200 random histories") {
  LineModel exact("line"), near("line"), far("line"), below("line");
  exact.offset = near.offset = far.offset = below.offset = 0.25;
  near.error_psi = 60.0 * 0.9e-9;
  far.error_psi = 60.0 * 1.1e-9;
  below.error_psi = -60.0 * 1.1e-9;
  CHECK(judge_round_trips(exact).pass);
  CHECK(judge_round_trips(near).pass);
  CHECK(judge_round_trips(near).found == "within 9e-10");
  CHECK_FALSE(judge_round_trips(far).pass);
  CHECK(judge_round_trips(far).found == "within 1.1e-09");
  CHECK_FALSE(judge_round_trips(below).pass);
  // Each history: its outputs, their inverse, and the outputs again.
  REQUIRE(exact.calls.states == 600);
  for (std::size_t i = 0; i < 600; i += 3) {
    REQUIRE(exact.calls.inputs[i].size() == 32);  // eight turns of four steps
    REQUIRE(exact.calls.inputs[i + 1].size() == 33);
    REQUIRE(exact.calls.inputs[i + 2].size() == 33);
    CHECK(exact.calls.inputs[i + 2].front() == Approx(0.0).margin(1e-9));
  }
  const auto turn = [&](std::size_t history, std::size_t number) {
    return exact.calls.inputs[history][4 * number - 1];
  };
  CHECK(turn(0, 1) == Approx(60.0 * 0.5928446165166826));
  CHECK(turn(0, 2) == Approx(60.0 * 0.8442657442565983));
  CHECK(exact.calls.inputs[0][0] == Approx(15.0 * 0.5928446165166826));
  CHECK(turn(597, 1) == Approx(60.0 * 0.5670648493465948));
}
