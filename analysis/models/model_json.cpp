#include "analysis/models/model_json.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "analysis/models/all_models.h"
#include "analysis/models/linearised.h"

namespace tactbench::analysis {

const nlohmann::ordered_json& json_member(const nlohmann::ordered_json& json, const std::string& name) {
  if (!json.is_object() || !json.contains(name)) throw std::invalid_argument("model: \"" + name + "\" is missing");
  return json.at(name);
}

double json_number(const nlohmann::ordered_json& json, const std::string& name) {
  const nlohmann::ordered_json& value = json_member(json, name);
  if (!value.is_number() || !std::isfinite(value.get<double>()))
    throw std::invalid_argument("model: \"" + name + "\" is not a number");
  return value.get<double>();
}

std::vector<double> json_numbers(const nlohmann::ordered_json& json, const std::string& name) {
  const nlohmann::ordered_json& list = json_member(json, name);
  const auto number = [](const auto& value) {
    return value.is_number() && std::isfinite(value.template get<double>());
  };
  if (!list.is_array() || !std::ranges::all_of(list, number))
    throw std::invalid_argument("model: \"" + name + "\" is not a list of numbers");
  return list.get<std::vector<double>>();
}

bool json_flag(const nlohmann::ordered_json& json, const std::string& name) {
  const nlohmann::ordered_json& value = json_member(json, name);
  if (!value.is_boolean()) throw std::invalid_argument("model: \"" + name + "\" is neither true nor false");
  return value.get<bool>();
}

namespace {

class JsonSource final : public ModelSource {
 public:
  explicit JsonSource(const nlohmann::ordered_json& json) : json_(json) {}
  [[nodiscard]] double number(const std::string& member) const override { return of(json_number, member); }
  [[nodiscard]] std::vector<double> numbers(const std::string& member) const override {
    return of(json_numbers, member);
  }
  [[nodiscard]] bool flag(const std::string& member) const override { return of(json_flag, member); }

 private:
  template <class Value>
  Value of(Value (*read)(const nlohmann::ordered_json&, const std::string&), const std::string& member) const {
    const std::size_t slash = member.find('/');
    return slash == std::string::npos ? read(json_, member)
                                      : read(json_member(json_, member.substr(0, slash)), member.substr(slash + 1));
  }
  const nlohmann::ordered_json& json_;
};

template <class... Models>
std::unique_ptr<HysteresisModel> made(ModelList<Models...> /*of*/, const std::string& name, const ModelSource& source) {
  std::unique_ptr<HysteresisModel> model;
  (void)((name == Models::kName && (model = Models::from(source))) || ...);
  return model;
}

constexpr const char* kLinearised = "linearised";

}  // namespace

nlohmann::ordered_json model_json(const HysteresisModel& model) {
  const auto* const outer = dynamic_cast<const LinearisedModel*>(&model);
  nlohmann::ordered_json json{{"model", outer == nullptr ? model.name() : kLinearised}};
  for (const auto& [name, member] : model.members())
    std::visit([&](const auto& value) { json[nlohmann::ordered_json::json_pointer("/" + name)] = value; }, member);
  if (outer != nullptr) json["of"] = model_json(outer->inner());
  return json;
}

std::unique_ptr<HysteresisModel> model_from_json(const nlohmann::ordered_json& json) {
  const nlohmann::ordered_json& model = json_member(json, "model");
  if (!model.is_string()) throw std::invalid_argument("model: \"model\" is not a name");
  const auto name = model.get<std::string>();
  if (name == kLinearised)
    return std::make_unique<LinearisedModel>(Divider{json_number(json, "zero"), json_number(json, "per_amplitude")},
                                             model_from_json(json_member(json, "of")));
  if (auto known = made(AllModels(), name, JsonSource(json))) return known;
  throw std::invalid_argument("model: \"model\" is \"" + name + "\", which this program does not know");
}

}  // namespace tactbench::analysis
