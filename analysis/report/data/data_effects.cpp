// What creep and temperature were found to be, as JSON.
#include <nlohmann/json.hpp>

#include "analysis/json_fields.h"
#include "analysis/report/data/data.h"
#include "analysis/report/parts.h"

namespace tactbench::analysis {
namespace {

using EffectJson = nlohmann::ordered_json;

EffectJson change_json(const OutputChange& change) { return {JSON_FIELDS(change, share, zero_v)}; }

}  // namespace

EffectJson creep_effect_json(const CreepEffect& creep) {
  EffectJson levels = EffectJson::array();
  for (const HeldLevel& level : creep.levels) {
    levels.push_back({JSON_FIELDS(level, sequence, pressure_psi),
                      {"branch", level.up ? "up" : "down"},
                      JSON_FIELDS(level, from_s, to_s, median_share),
                      {"taxel_share", number_list(level.share, 5)}});
  }
  return {{"read_after_s", creep.read_after_s},
          {"covered_to_s", creep.to_s},
          {"levels", std::move(levels)},
          {"carried_back", creep.extrapolated_back},
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

}  // namespace tactbench::analysis
