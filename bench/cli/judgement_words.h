// A judgement as people and programs read it.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "analysis/judgement/judgement.h"

namespace tactbench::bench {

// The statement and what decided it: "simulated fail, decided by run 4; judged on runs 2, 3, 4". More lines for
// conditions and remarks.
std::string judgement_text(const analysis::Judgement& judgement, const std::string& origin,
                           analysis::PressureUnit unit);
// A line for each judged run: the trajectory that its errors hold for; and one with what was not assessed.
std::string conditions_text(const analysis::Judgement& judgement);
// As analysis::judgement_json(), with the verdict's words.
nlohmann::ordered_json judgement_json(const analysis::Judgement& judgement, const std::string& origin);

}  // namespace tactbench::bench
