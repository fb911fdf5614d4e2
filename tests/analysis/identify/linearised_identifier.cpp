// Which taxels get their readout divider undone, and how such models are kept.
#include "analysis/identify/linearised_identifier.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "analysis/identify/stored/model_document.h"
#include "analysis/models/linearised.h"
#include "analysis/models/model_json.h"
#include "tests/analysis/support/dynamic_plant.h"

using namespace synthetic;

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

TEST_CASE("the divider of a plant is found, and without one the model is the plain one bit for bit", "[linearise]") {
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

TEST_CASE("models on the linearised output are kept and read with their c, and others as before", "[linearise]") {
  const FitData data = two_sequences(plant());
  IdentifyOptions options;
  options.linearise = true;
  for (const char* const name : model_names()) {
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
