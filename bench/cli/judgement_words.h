// A judgement as people and programs read it, and its exit code.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "analysis/statistics/conformity/overall_verdict.h"
#include "bench/common/error.h"
#include "bench/reporting/judgement.h"

namespace tactbench::bench {

// The overall verdict and what decided it: "simulated fail, decided by run 4; judged on runs 2, 3, 4". More lines for
// remarks.
std::string judgement_text(const Judgement& judgement, const std::string& origin);
// A line for each judged run: the trajectory that its errors hold for; and one with what was not assessed.
std::string conditions_text(const analysis::JudgementNotes& notes);
nlohmann::ordered_json judgement_json(const Judgement& judgement, const std::string& origin);
// final_verdict() of its rows and notes, and its exit code.
std::optional<analysis::Verdict> verdict_of(const Judgement& judgement);
ExitCode exit_code_of(const Judgement& judgement);

}  // namespace tactbench::bench
