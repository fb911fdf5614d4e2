// What creep and temperature were found to be, as JSON: members of the uncertainty of a reading.
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "analysis/report/page.h"

namespace tactbench::analysis {
namespace {

using EffectJson = nlohmann::ordered_json;

EffectJson change_json(const OutputChange& change) { return {{"share", change.share}, {"zero_v", change.zero_v}}; }

EffectJson creep_effect_json(const CreepEffect& creep) {
  EffectJson levels = EffectJson::array();
  for (const HeldLevel& level : creep.levels) {
    EffectJson shares = EffectJson::array();
    // Six digits are finer than any converter's step.
    for (const double share : level.share)
      shares.push_back(std::isfinite(share) ? EffectJson(1e-6 * std::round(1e6 * share)) : EffectJson(nullptr));
    levels.push_back({{"sequence", level.sequence},
                      {"pressure_psi", level.pressure_psi},
                      {"branch", level.up ? "up" : "down"},
                      {"from_s", level.from_s},
                      {"to_s", level.to_s},
                      {"median_share", level.median_share},
                      {"taxel_share", std::move(shares)}});
  }
  return {{"read_after_s", creep.read_after_s},
          {"covered_to_s", creep.to_s},
          {"levels", std::move(levels)},
          {"carried_back", creep.carried_back},
          {"basis", creep.in_words()}};
}

EffectJson temperature_effect_json(const TemperatureEffect& effect) {
  EffectJson runs = EffectJson::array();
  for (std::size_t i = 0; i < effect.temperature_c.size(); ++i)
    runs.push_back({{"temperature_c", effect.temperature_c[i]}, {"change", change_json(effect.change[i])}});
  return {{"per_kelvin", change_json(effect.per_kelvin)},
          {"u", change_json(effect.u)},
          {"dof", effect.dof},
          {"taxel_deviation", change_json(effect.deviation)},
          {"half_width_c", effect.half_width_c()},
          {"resolution_c", effect.resolution_c},
          {"runs", std::move(runs)},
          {"basis", effect.in_words()}};
}

}  // namespace

std::string effects_members(const Uncertainty& uncertainty) {
  const auto dumped_member = [](const char* name, const EffectJson& json) {
    return fmt::format(",\"{}\":{}", name, json.dump(-1, ' ', true, EffectJson::error_handler_t::replace));
  };
  std::string text;
  if (uncertainty.creep.assessed()) text += dumped_member("creep", creep_effect_json(uncertainty.creep));
  if (uncertainty.temperature.assessed())
    text += dumped_member("temperature", temperature_effect_json(uncertainty.temperature));
  return text;
}

}  // namespace tactbench::analysis
