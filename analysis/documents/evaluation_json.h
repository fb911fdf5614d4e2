// Figures of a run as JSON, for verbs and for the data of reports. The run itself is not included: a verb adds the
// run's number, a report its title.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "analysis/statistics/figures/evaluation.h"

namespace tactbench::analysis {

// Keys that end in _fs: shares of full scale.
//   frames full_scale_v full_scale_psi hysteresis_max_fs hysteresis_mean_fs mean_error_psi max_error_psi
//   mean_error_observable_psi max_error_observable_psi worst_taxel_mean_error_psi worst_taxel raw_distance_fs
//   comp_distance_of_mean_fs comp_distance_fs comp_distance_observable_fs worst_taxel_distance_fs
//   worst_taxel_distance_observable_fs flat_share levels_made_worse_psi
nlohmann::ordered_json evaluation_json(const Evaluation& evaluation);

}  // namespace tactbench::analysis
