// Figures of one evaluation beside each other: raw, compensated, with and without unobservable levels.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "analysis/statistics/evaluation.h"

namespace tactbench::bench {

struct NamedEvaluation {
  std::string title;
  analysis::Evaluation evaluation;
};
std::string figures_table(const std::vector<NamedEvaluation>& evaluations);
nlohmann::ordered_json evaluation_json(const NamedEvaluation& named);

}  // namespace tactbench::bench
