#include "analysis/documents/evaluation_json.h"

#include "analysis/json_fields.h"

#include <nlohmann/json.hpp>

namespace tactbench::analysis {

nlohmann::ordered_json evaluation_json(const Evaluation& evaluation) {
  const Evaluation& e = evaluation;
  nlohmann::ordered_json made_worse = nlohmann::ordered_json::array();
  for (const LevelFigures& level : e.levels)
    if (level.made_worse) made_worse.push_back(level.pressure_psi);
  return {JSON_FIELDS(e, frames, full_scale_v, full_scale_psi, hysteresis_max_fs, hysteresis_mean_fs, mean_error_psi,
                      max_error_psi, mean_error_observable_psi, max_error_observable_psi, worst_taxel_mean_error_psi,
                      worst_taxel),
          {"raw_distance_fs", e.raw_distance},
          {"comp_distance_of_mean_fs", e.comp_distance_of_mean},
          {"comp_distance_fs", e.comp_distance},
          {"comp_distance_observable_fs", e.comp_distance_observable},
          {"worst_taxel_distance_fs", e.worst_taxel_distance},
          {"worst_taxel_distance_observable_fs", e.worst_taxel_distance_observable},
          {"flat_share", e.flat_share},
          {"levels_made_worse_psi", made_worse}};
}

}  // namespace tactbench::analysis
