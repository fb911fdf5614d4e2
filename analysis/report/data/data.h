// JSON helpers for the report's data: one line, ASCII; non-finite numbers become null.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>

#include "analysis/report/report.h"

namespace tactbench::analysis {

struct CreepEffect;
struct Evaluation;
struct TemperatureEffect;

// A list of numbers, stored in the tree as finished text (a binary value, which only json_text can write), because most
// of a report is numbers. Seven significant digits are finer than any converter step.
nlohmann::ordered_json number_list(std::span<const double> values, int digits = 7);

// Numbers outside these lists have all their digits.
std::string json_text(const nlohmann::ordered_json& json);

// evaluation_json() with the figures of each level. `fitted`: number of taxels with models; if the estimates of all of
// them were flagged, none is observable.
nlohmann::ordered_json whole_evaluation_json(const Evaluation& evaluation, int fitted);

// Effects of creep and of temperature; both must be assessed.
nlohmann::ordered_json creep_effect_json(const CreepEffect& creep);
nlohmann::ordered_json temperature_effect_json(const TemperatureEffect& effect);

// Data of the report's sections as JSON.

// identification_json() contains what identifies the run (number, UUID, times, host), so that the content hash can omit
// it; the others contain results. JSON in ASCII; null where a figure is not available.
std::string identification_json(const ReportInput& input);
std::string approvals_json(const ReportInput& input);  // the signatures, a part of the identification
std::string results_json(const ReportInput& input);
std::string uncertainty_json(const ReportInput& input);
std::string health_json(const ReportInput& input);
std::string behaviour_json(const ReportInput& input);
std::string as_found_json(const ReportInput& input);
std::string studies_json(const ReportInput& input);
std::string objects_json(const ReportInput& input);

}  // namespace tactbench::analysis
