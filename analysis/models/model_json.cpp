#include "analysis/models/model_json.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <span>
#include <stdexcept>

#include "analysis/models/elam_hysteresis.h"
#include "analysis/models/gpi.h"
#include "analysis/models/linearised.h"
#include "analysis/models/monotone.h"
#include "analysis/models/mpi.h"
#include "analysis/models/poly.h"
#include "analysis/models/preisach.h"

namespace tactbench::analysis {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<const char*, 4> kSideNames = {"descending_low", "descending_high", "ascending_low",
                                                   "ascending_high"};

std::vector<double> list(std::span<const double> values) { return {values.begin(), values.end()}; }

Json with_parameters(const HysteresisModel& model, double y_low) {
  Json json{{"model", model.name()}, {"x_low", model.x_low()}, {"x_high", model.x_high()}, {"y_low", y_low}};
  for (const ModelParameter& parameter : model.parameters()) json["parameters"][parameter.name] = parameter.value;
  return json;
}

Json elam_json(const ElamHysteresis& model) {
  const ElamModel& elam = model.elam();
  const int splits = model.pieces().splits();
  Json json{{"model", model.name()},
            {"x", list(elam.ascending.x())},
            {"ascending", list(elam.ascending.y())},
            {"descending", list(elam.descending.y())}};
  const std::vector<ModelParameter> parameters = model.parameters();
  for (std::size_t i = 0; i < kElamParameterNames.size(); ++i)
    json["parameters"][kElamParameterNames[i]] = parameters[i].value;
  json["options"] = {{"exact_outer", elam.options.exact_outer}, {"memory", model.memory()}, {"splits", splits}};
  if (splits > 1)
    for (std::size_t i = 0; i < kElamSides.size(); ++i) json["pieces"][kSideNames[i]] = model.pieces().*kElamSides[i];
  return json;
}

PatternCurve curve_from(const Json& json, const std::string& outputs) {
  const std::vector<double> x = json_numbers(json, "x"), y = json_numbers(json, outputs);
  if (y.empty() || y.size() != x.size())
    throw std::invalid_argument("model: \"" + outputs + "\" does not hold a number for each of \"x\"");
  return {x, y, y.front(), y.back()};
}

std::unique_ptr<HysteresisModel> elam_from(const Json& json) {
  const Json &p = json_member(json, "parameters"), &options = json_member(json, "options");
  ElamPieces pieces;
  const double splits = json_number(options, "splits");
  if (splits != 1.0)
    for (std::size_t i = 0; i < kElamSides.size(); ++i)
      pieces.*kElamSides[i] = json_numbers(json_member(json, "pieces"), kSideNames[i]);
  if (splits != pieces.splits())
    throw std::invalid_argument("model: \"splits\" is not the number of split points in \"pieces\"");
  ElamModel model{curve_from(json, "ascending"),
                  curve_from(json, "descending"),
                  {json_number(p, "alpha_d"), json_number(p, "beta_d"), json_number(p, "alpha_a1"),
                   json_number(p, "alpha_a0"), json_number(p, "beta_a")},
                  {json_flag(options, "exact_outer")}};
  return std::make_unique<ElamHysteresis>(std::move(model), json_flag(options, "memory"), std::move(pieces));
}

std::array<double, kPolyOrder + 1> polynomial_from(const Json& json, const std::string& name) {
  const std::vector<double> numbers = json_numbers(json, name);
  std::array<double, kPolyOrder + 1> polynomial;
  if (numbers.size() != polynomial.size())
    throw std::invalid_argument("model: \"" + name + "\" does not hold 7 numbers");
  std::ranges::copy(numbers, polynomial.begin());
  return polynomial;
}

}  // namespace

const Json& json_member(const Json& json, const std::string& name) {
  if (!json.is_object() || !json.contains(name)) throw std::invalid_argument("model: \"" + name + "\" is missing");
  return json.at(name);
}

double json_number(const Json& json, const std::string& name) {
  const Json& value = json_member(json, name);
  if (!value.is_number() || !std::isfinite(value.get<double>()))
    throw std::invalid_argument("model: \"" + name + "\" is not a number");
  return value.get<double>();
}

std::vector<double> json_numbers(const Json& json, const std::string& name) {
  const Json& list = json_member(json, name);
  const auto number = [](const auto& value) {
    return value.is_number() && std::isfinite(value.template get<double>());
  };
  if (!list.is_array() || !std::ranges::all_of(list, number))
    throw std::invalid_argument("model: \"" + name + "\" is not a list of numbers");
  return list.get<std::vector<double>>();
}

bool json_flag(const Json& json, const std::string& name) {
  const Json& value = json_member(json, name);
  if (!value.is_boolean()) throw std::invalid_argument("model: \"" + name + "\" is neither true nor false");
  return value.get<bool>();
}

Json model_json(const HysteresisModel& model) {
  if (const auto* const elam = dynamic_cast<const ElamHysteresis*>(&model)) return elam_json(*elam);
  if (const auto* const gpi = dynamic_cast<const GpiModel*>(&model)) return with_parameters(model, gpi->y_low());
  if (const auto* const mpi = dynamic_cast<const MpiModel*>(&model)) return with_parameters(model, mpi->y_low());
  if (const auto* const poly = dynamic_cast<const PolyModel*>(&model))
    return {{"model", "poly"},
            {"x_low", poly->x_low()},
            {"x_high", poly->x_high()},
            {"y_low", poly->external(true).y},
            {"y_high", poly->external(false).y},
            {"a", poly->polynomials().a},
            {"b", poly->polynomials().b}};
  if (const auto* const film = dynamic_cast<const PreisachModel*>(&model))
    return {{"model", "preisach"},
            {"x_low", film->x_low()},
            {"x_high", film->x_high()},
            {"y_low", film->y_low()},
            {"weights", film->weights()}};
  if (const auto* const curve = dynamic_cast<const MonotoneModel*>(&model))
    return {{"model", "monotone"}, {"x", list(curve->curve().x())}, {"y", list(curve->curve().y())}};
  const auto& outer = dynamic_cast<const LinearisedModel&>(model);
  return {{"model", "linearised"},
          {"zero", outer.divider().zero},
          {"per_amplitude", outer.divider().per_amplitude},
          {"of", model_json(outer.inner())}};
}

std::unique_ptr<HysteresisModel> model_from_json(const Json& json) {
  const Json& model = json_member(json, "model");
  if (!model.is_string()) throw std::invalid_argument("model: \"model\" is not a name");
  const auto name = model.get<std::string>();
  const auto number = [&](const char* of) { return json_number(json, of); };
  const auto parameter = [&](const char* of) { return json_number(json_member(json, "parameters"), of); };
  if (name == "elam") return elam_from(json);
  if (name == "gpi")
    return std::make_unique<GpiModel>(GpiParameters{parameter("a0"), parameter("a1"), parameter("a2"), parameter("a3"),
                                                    parameter("b0"), parameter("b1"), parameter("b2"), parameter("b3"),
                                                    parameter("alpha"), parameter("rho"), parameter("tau")},
                                      number("x_low"), number("x_high"), number("y_low"));
  if (name == "mpi")
    return std::make_unique<MpiModel>(
        MpiParameters{parameter("a1"), parameter("a2"), parameter("a3"), parameter("rho"), parameter("tau")},
        number("x_low"), number("x_high"), number("y_low"));
  if (name == "poly")
    return std::make_unique<PolyModel>(PolyParameters{polynomial_from(json, "a"), polynomial_from(json, "b")},
                                       number("x_low"), number("x_high"), number("y_low"), number("y_high"));
  if (name == "preisach")
    return std::make_unique<PreisachModel>(number("x_low"), number("x_high"), number("y_low"),
                                           json_numbers(json, "weights"));
  if (name == "monotone") return std::make_unique<MonotoneModel>(curve_from(json, "y"));
  if (name == "linearised")
    return std::make_unique<LinearisedModel>(Divider{number("zero"), number("per_amplitude")},
                                             model_from_json(json_member(json, "of")));
  throw std::invalid_argument("model: \"model\" is \"" + name + "\", which this program does not know");
}

}  // namespace tactbench::analysis
