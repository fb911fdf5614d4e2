// When a model of the linearised output is taken: the errors on branches that were held out, sample by sample, by
// models whose output is one number.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "analysis/identify/congruency.h"
#include "analysis/identify/fit_models.h"
#include "analysis/identify/linearised_identifier.h"
#include "analysis/identify/stored/model_document.h"
#include "analysis/models/linearised.h"
#include "analysis/models/model_json.h"
#include "analysis/models/preisach.h"
#include "tests/analysis/support/dynamic_plant.h"
#include "tests/analysis/support/fit_samples.h"

using namespace synthetic;

namespace {

// One constant for outputs that reach higher than `above`, another for others.
class ConstantOutputs final : public Identifier {
 public:
  ConstantOutputs(double above, double higher, double other) : above_(above), higher_(higher), other_(other) {}
  [[nodiscard]] ModelFit fit(const FitData& data) const override {
    ModelFit fit;
    const double output = data.ascending.y().back() > above_ ? higher_ : other_;
    fit.model = std::make_shared<PreisachModel>(0.0, 60.0, output, std::vector<double>{0.0});
    return fit;
  }

 private:
  double above_, higher_, other_;
};

class NeverFits final : public Identifier {
 public:
  [[nodiscard]] ModelFit fit(const FitData& /*data*/) const override { throw std::invalid_argument("not these"); }
};

FitData data_with_divider() {
  const LinearisedModel film({0.02, 1.0 / 3.3}, std::make_unique<PreisachModel>(film_of(29, 30)));
  return two_sequences(film);
}

double above_plain(const FitData& data) { return 1.01 * data.ascending.y().back(); }

// Outputs of branches from inside the range, without their first.
std::vector<double> held_outputs(const FitData& data) {
  std::vector<double> outputs;
  for (const History& history : data.histories)
    for (const Branch& branch : history.branches) {
      const double from = history.x[static_cast<std::size_t>(branch.first)];
      if (branch.ascending ? from <= 0.6 : from >= 59.4) continue;
      outputs.insert(outputs.end(), history.y.begin() + branch.first + 1, history.y.begin() + branch.last + 1);
    }
  return outputs;
}

double amplitude_taken(const FitData& data, bool cross, const PrepareInner& inner) {
  const ModelFit fit = prepare_linearised(data, false, cross, inner)->fit(data);
  return dynamic_cast<const LinearisedModel&>(*fit.model).divider().per_amplitude;
}

}  // namespace

TEST_CASE("linearised: the divider is used if it reduces the errors on held-out branches", "[linearise]") {
  const FitData data = data_with_divider();
  REQUIRE(find_divider(data).divider.per_amplitude > 0.0);
  const double zero = data.ascending.y().front(), above = above_plain(data);
  // With the divider all samples are `zero`, without it `even`, where both err by as much in sum.
  double sum = 0.0;
  const std::vector<double> outputs = held_outputs(data);
  for (const double y : outputs) {
    REQUIRE(y >= zero);
    sum += y;
  }
  const double even = 2.0 * sum / static_cast<double>(outputs.size()) - zero;
  REQUIRE(even > *std::ranges::max_element(outputs));
  const auto with = [&](double plain) {
    return [above, plain](const FitData&) { return std::make_unique<ConstantOutputs>(above, 0.0, plain); };
  };
  CHECK(amplitude_taken(data, true, with(even * (1.0 + 1e-6))) > 0.0);
  CHECK(amplitude_taken(data, true, with(even * (1.0 - 1e-6))) == 0.0);
  // No less: it stays off.
  CHECK(amplitude_taken(data, true, with(zero)) == 0.0);
  CHECK(amplitude_taken(data, false, with(zero)) > 0.0);
}

TEST_CASE("linearised: if no branches can be held out the congruency test alone decides on the divider",
          "[linearise]") {
  const FitData data = data_with_divider();
  const double above = above_plain(data);
  int prepared = 0;
  // Without the divider all would be less.
  const auto good = [&] { return std::make_unique<ConstantOutputs>(above, 0.0, 1.5); };
  CHECK(amplitude_taken(data, true, [&](const FitData&) { return good(); }) == 0.0);
  CHECK(amplitude_taken(data, true, [&](const FitData&) -> std::unique_ptr<Identifier> {
          if (prepared++ == 0) return good();
          return std::make_unique<NeverFits>();
        }) > 0.0);
  CHECK(prepared == 6);
  prepared = 0;
  CHECK(amplitude_taken(data, true, [&](const FitData&) -> std::unique_ptr<Identifier> {
          if (prepared++ == 3) throw std::invalid_argument("not these");
          return good();
        }) > 0.0);
  CHECK(prepared == 4);
}

TEST_CASE("linearised: errors are those of the whole model on the measured outputs", "[linearise]") {
  const FitData data = data_with_divider();
  const double above = above_plain(data), zero = data.ascending.y().front();
  const auto fit = prepare_linearised(data, false, false, [&](const FitData&) {
                     return std::make_unique<ConstantOutputs>(above, 0.0, 9.0);
                   })->fit(data);
  double squares = 0.0, sum = 0.0, most = 0.0;
  int samples = 0;
  for (const History& history : data.histories)
    for (const Branch& branch : history.branches)
      for (int i = branch.first + 1; i <= branch.last; ++i, ++samples) {
        const double off = std::abs(history.y[static_cast<std::size_t>(i)] - zero);
        squares += off * off;
        sum += off;
        most = std::max(most, off);
      }
  CHECK(fit.samples == samples);
  CHECK(fit.j == Approx(squares));
  CHECK(fit.mean_error == Approx(sum / samples));
  CHECK(fit.max_error == Approx(most));
  CHECK(fit.full_scale == Approx(data.ascending.y().back() - zero));
}

TEST_CASE("linearised: without a divider, outputs that start above 0 are fitted by the plain model", "[linearise]") {
  FitData data = two_sequences(film_of(31, 30));
  for (History& history : data.histories)
    for (double& y : history.y) y += 0.5;
  const auto raised = [](const PatternCurve& curve) {
    std::vector<double> y(curve.y().begin(), curve.y().end());
    for (double& at : y) at += 0.5;
    return PatternCurve(curve.x(), y, y.front(), y.back());
  };
  data.ascending = raised(data.ascending);
  data.descending = raised(data.descending);
  REQUIRE(find_divider(data).divider.per_amplitude == 0.0);
  for (const bool cross : {false, true}) {
    const ModelFit fit = prepare_linearised(data, false, cross, [&](const FitData&) {
                           return std::make_unique<ConstantOutputs>(100.0, 0.0, 2.0);
                         })->fit(data);
    const auto& model = dynamic_cast<const LinearisedModel&>(*fit.model);
    CHECK(model.divider().zero == 0.0);
    CHECK(predict(model, std::vector<double>{0.0, 30.0}) == std::vector<double>{2.0, 2.0});
    CHECK(fit.samples == 0);  // as the plain model's fit tells them
  }
}

// Which taxels get their readout divider undone, and how such models are kept.

namespace {

const LinearisedModel& linearised_in(const ModelFit& fit) { return dynamic_cast<const LinearisedModel&>(*fit.model); }

const LinearisedModel& plant() {
  static const LinearisedModel model({0.02, 1.0 / 3.3}, std::make_unique<PreisachModel>(film_of(29, 30)));
  return model;
}

// A model of a table's one taxel, with what its document holds.
SensorModel sensor_of(const std::string& name, const ModelFit& fit, const FitData& data) {
  SensorModel sensor;
  sensor.model = name;
  sensor.options.linearise = true;
  sensor.rows = sensor.columns = 1;
  sensor.pressure_psi.assign(data.ascending.x().begin(), data.ascending.x().end());
  ModelTaxel& taxel = sensor.taxels.emplace_back();
  taxel.status = TaxelStatus::kFitted;
  taxel.fit = fit;
  taxel.loop_low = data.ascending.y().front();
  set_loop(taxel, data.ascending.x(), data.ascending.y(), data.descending.y());
  return sensor;
}

}  // namespace

TEST_CASE("linearised: finds a plant's divider within 1 %, and without one equals the plain model bit for bit",
          "[linearise]") {
  IdentifyOptions options;
  options.linearise = true;
  for (const unsigned seed : {31U, 32U, 33U}) {
    for (const double amplitude : {2.7, 3.9}) {
      const LinearisedModel film({0.02, 1.0 / amplitude}, std::make_unique<PreisachModel>(film_of(seed, 30)));
      const ModelFit fit = identify("preisach", two_sequences(film), options);
      CHECK(1.0 / linearised_in(fit).divider().per_amplitude == Approx(amplitude).epsilon(0.01));
    }
    const FitData bare = two_sequences(film_of(seed, 30));
    for (const char* const name : {"elam", "preisach", "poly"}) {
      const ModelFit fit = identify(name, bare, options), plain = identify(name, bare);
      const LinearisedModel& model = linearised_in(fit);
      CHECK(model.divider().per_amplitude == 0.0);
      CHECK(model.parameters().front().name == "c");
      CHECK_FALSE(model.parameters().front().at_bound());
      CHECK(model_json(model.inner()) == model_json(*plain.model));
      CHECK(fit.j == plain.j);
      const std::vector<double> way = random_way(300, 2.5, seed);
      CHECK(predict(model, way) == predict(*plain.model, way));
    }
  }
}

TEST_CASE("linearised: documents store and read back the divider, documents of plain models have no divider",
          "[linearise]") {
  const FitData data = two_sequences(plant());
  IdentifyOptions options;
  options.linearise = true;
  for (const std::string& name : model_names()) {
    const SensorModel sensor = sensor_of(name, identify(name, data, options), data);
    CHECK(label_of(sensor) == std::string(name) + ", linearised");
    const std::string text = to_text(sensor);
    CHECK_THAT(text, Catch::Contains("\"linearise\": true"));
    const SensorModel again = document_from_text(text, "m.json");
    CHECK(to_text(again) == text);
    CHECK(again.options.linearise);
    REQUIRE(linearised_of(again.taxels.front()) != nullptr);
    CHECK(linearised_of(again.taxels.front())->divider().per_amplitude ==
          linearised_of(sensor.taxels.front())->divider().per_amplitude);
    SensorModel plain = sensor_of(name, identify(name, data), data);
    plain.options.linearise = false;
    CHECK_THAT(to_text(plain), !Catch::Contains("linearise"));
    CHECK(linearised_of(plain.taxels.front()) == nullptr);
  }
}

// A sensor whose outputs begin at another voltage: each model fits and predicts the same, that much higher.

TEST_CASE("identification: an output offset shifts each model's prediction and leaves its errors unchanged") {
  const FitData data = paper_both(0.03, 0.02);
  for (const double offset : {0.7, -1.9}) {
    const auto moved = [&](std::vector<double> y) {
      for (double& value : y) value += offset;
      return y;
    };
    const auto pattern = [&](const PatternCurve& p) {
      const std::vector<double> x(p.x().begin(), p.x().end()), y = moved({p.y().begin(), p.y().end()});
      return PatternCurve(x, y, y.front(), y.back());
    };
    FitData higher{data.histories, pattern(data.ascending), pattern(data.descending)};
    for (History& history : higher.histories) history.y = moved(history.y);
    for (const char* name : {"elam", "gpi", "mpi", "poly", "preisach", "monotone"}) {
      CAPTURE(name, offset);
      const ModelFit own = identify(name, data, {.starts = 1}), other = identify(name, higher, {.starts = 1});
      CHECK(other.j == Approx(own.j).epsilon(1e-5));
      CHECK(other.full_scale == Approx(own.full_scale));
      CHECK(other.mean_error == Approx(own.mean_error).epsilon(1e-4));
      const std::vector<double> expected = moved(predict(*own.model, data.histories[0].x));
      const std::vector<double> found = predict(*other.model, data.histories[0].x);
      double off = 0.0;
      for (std::size_t i = 0; i < found.size(); ++i) off = std::max(off, std::abs(found[i] - expected[i]));
      CHECK(off < 1e-4);
      if (std::string(name) != "poly") continue;
      // a0 to a6, b0 to b6: polynomials from the lower end of the loop to the upper one.
      for (const std::size_t first : {0U, 7U}) {
        const std::vector<ModelParameter> p = other.model->parameters();
        double top = 0.0;
        for (std::size_t i = 0; i <= 6; ++i) top += p[first + i].value * std::pow(60.0, 6.0 - static_cast<double>(i));
        CHECK(p[first + 6].value == Approx(higher.ascending.y().front()));
        CHECK(top == Approx(higher.ascending.y().back()));
      }
    }
  }
}
