#include "analysis/models/elam_hysteresis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "analysis/models/elam_state.h"

namespace tactbench::analysis {
namespace {

std::array<double, 5> values_of(const ElamParameters& p) {
  return {p.alpha_d, p.beta_d, p.alpha_a1, p.alpha_a0, p.beta_a};
}

[[noreturn]] void malformed(const std::string& member, const std::string& what) {
  throw std::invalid_argument("ELAM model: \"" + member + "\" " + what);
}

const nlohmann::ordered_json& member(const nlohmann::ordered_json& json, const std::string& name) {
  if (!json.is_object() || !json.contains(name)) malformed(name, "is missing");
  return json.at(name);
}

double number(const nlohmann::ordered_json& json, const std::string& name) {
  const nlohmann::ordered_json& value = member(json, name);
  if (!value.is_number()) malformed(name, "is not a number");
  return value.get<double>();
}

std::vector<double> numbers(const nlohmann::ordered_json& json, const std::string& name, std::size_t least = 2) {
  const nlohmann::ordered_json& list = member(json, name);
  if (!list.is_array() || list.size() < least ||
      !std::ranges::all_of(list, [](const auto& value) { return value.is_number(); }))
    malformed(name, least > 0 ? "is not a list of two or more numbers" : "is not a list of numbers");
  return list.get<std::vector<double>>();
}

bool flag(const nlohmann::ordered_json& json, const std::string& name) {
  const nlohmann::ordered_json& value = member(json, name);
  if (!value.is_boolean()) malformed(name, "is neither true nor false");
  return value.get<bool>();
}

constexpr std::array<const char*, 4> kSideNames = {"descending_low", "descending_high", "ascending_low",
                                                   "ascending_high"};
constexpr std::array<std::vector<double> ElamPieces::*, 4> kSides = {
    &ElamPieces::descending_low, &ElamPieces::descending_high, &ElamPieces::ascending_low, &ElamPieces::ascending_high};

}  // namespace

ElamHysteresis::ElamHysteresis(ElamModel model, bool memory, ElamPieces pieces)
    : model_(std::move(model)), memory_(memory), pieces_(std::move(pieces)) {
  const PatternCurve &up = model_.ascending, &down = model_.descending;
  if (up.x().size() < 2 || !std::ranges::equal(up.x(), down.x()) || up.y().front() != down.y().front() ||
      up.y().back() != down.y().back())
    throw std::invalid_argument("ELAM model: the two patterns do not share their grid and their ends");
  if (!std::ranges::all_of(values_of(model_.parameters), [](double value) { return std::isfinite(value); }))
    throw std::invalid_argument("ELAM model: a parameter is not finite");
  for (const auto side : kSides)
    if (!std::ranges::all_of(pieces_.*side, [](double value) { return std::abs(value) <= kMostPieceLog; }))
      throw std::invalid_argument(fmt::format("ELAM model: the size of a piece is not within e^±{}", kMostPieceLog));
  const int up_splits = 1 + static_cast<int>(pieces_.ascending_low.size() + pieces_.ascending_high.size());
  if (pieces_.splits() > kMostSplits || pieces_.splits() != up_splits)
    throw std::invalid_argument(
        fmt::format("ELAM model: {} split points down and {} up are not the same number up to {}", pieces_.splits(),
                    up_splits, kMostSplits));
}

std::vector<ModelParameter> ElamHysteresis::parameters() const {
  const ElamParameters& p = model_.parameters;
  const double steepest = 1.0 / (model_.xu() - model_.x0());
  std::vector<ModelParameter> list = {{kElamParameterNames[0], p.alpha_d, "1", 0.0, 1.0},
                                      {kElamParameterNames[1], p.beta_d, "1", 0.0, 1.0},
                                      {kElamParameterNames[2], p.alpha_a1, "1/x", -steepest, steepest},
                                      {kElamParameterNames[3], p.alpha_a0, "1", 0.0, 1.0},
                                      {kElamParameterNames[4], p.beta_a, "1", 0.0, 1.0}};
  for (std::size_t i = 0; i < kSides.size(); ++i) {
    const char* direction = i < 2 ? "d" : "a";
    std::size_t number = i % 2 == 0 ? 0 : (pieces_.*kSides[i - 1]).size();
    for (const double value : pieces_.*kSides[i])
      list.push_back({fmt::format("log_{}{}", direction, ++number), value, "1", -kMostPieceLog, kMostPieceLog});
  }
  return list;
}

// Direction and split compared, Eq. (16) or (23) as one multiply-add, one table access, its multiply-add, Eq. (17) or
// the closing scale as another. Further pieces: a comparison each, and one more map.
int ElamHysteresis::operations_per_sample() const { return pieces_.splits() == 1 ? 9 : 11 + pieces_.splits(); }

std::unique_ptr<ModelState> ElamHysteresis::state() const {
  return std::make_unique<ElamState>(model_, pieces_, memory_);
}

nlohmann::ordered_json ElamHysteresis::to_json() const {
  const auto list = [](std::span<const double> values) { return std::vector<double>(values.begin(), values.end()); };
  nlohmann::ordered_json parameters;
  const auto values = values_of(model_.parameters);
  for (std::size_t i = 0; i < values.size(); ++i) parameters[kElamParameterNames[i]] = values[i];
  nlohmann::ordered_json json;
  json["model"] = name();
  json["x"] = list(model_.ascending.x());
  json["ascending"] = list(model_.ascending.y());
  json["descending"] = list(model_.descending.y());
  json["parameters"] = parameters;
  json["options"] = {{"exact_outer", model_.options.exact_outer}, {"memory", memory_}, {"splits", pieces_.splits()}};
  if (pieces_.splits() > 1)
    for (std::size_t i = 0; i < kSides.size(); ++i) json["pieces"][kSideNames[i]] = pieces_.*kSides[i];
  return json;
}

std::unique_ptr<HysteresisModel> elam_from_json(const nlohmann::ordered_json& json) {
  const std::vector<double> x = numbers(json, "x"), up = numbers(json, "ascending"), down = numbers(json, "descending");
  const nlohmann::ordered_json &p = member(json, "parameters"), &options = member(json, "options");
  ElamPieces pieces;
  const double splits = number(options, "splits");
  if (splits != 1.0)
    for (std::size_t i = 0; i < kSides.size(); ++i)
      pieces.*kSides[i] = numbers(member(json, "pieces"), kSideNames[i], 0);
  if (splits != pieces.splits()) malformed("splits", "is not the number of split points in \"pieces\"");
  ElamModel model{
      PatternCurve(x, up, up.front(), up.back()),
      PatternCurve(x, down, down.front(), down.back()),
      {number(p, "alpha_d"), number(p, "beta_d"), number(p, "alpha_a1"), number(p, "alpha_a0"), number(p, "beta_a")},
      {flag(options, "exact_outer")}};
  return std::make_unique<ElamHysteresis>(std::move(model), flag(options, "memory"), std::move(pieces));
}

}  // namespace tactbench::analysis
