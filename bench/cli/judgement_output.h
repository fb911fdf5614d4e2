// Output of a judgement as text and JSON: the verdict with the figure that decides it, then the checks that do not
// pass.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "analysis/judgement/judgement.h"
#include "analysis/report/document/document.h"
#include "bench/reporting/named_evaluation.h"

namespace tactbench::bench {

// "PASS", "FAIL" or "INCONCLUSIVE", in agreement with the exit code; empty where no conformity is stated.
std::string verdict_banner(const analysis::Judgement& judgement);
// The verdict, what decides it, and how many checks pass; one paragraph without a line end.
std::string headline(const analysis::Judgement& judgement, const std::string& origin, analysis::PressureUnit unit);
// The headline, a table of the checks that do not pass and of the closest pass, and the scope of the verdict. `all`:
// every check, the decision rules, and each run's trajectory.
analysis::doc::Document judgement_document(const analysis::Judgement& judgement, const std::string& origin,
                                           analysis::PressureUnit unit, bool all);
// One row per evaluation: errors, and the mean taxel's hysteresis before and after; the first is the models' own run.
analysis::doc::Table figures_table(const std::vector<NamedEvaluation>& evaluations,
                                   const analysis::Judgement& judgement, analysis::PressureUnit unit);
// As analysis::judgement_json(), with the verdict's words.
nlohmann::ordered_json judgement_json(const analysis::Judgement& judgement, const std::string& origin);

}  // namespace tactbench::bench
