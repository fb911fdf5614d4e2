// The figures of the section "Uncertainty", and of conformity, as JSON.
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "analysis/json_fields.h"
#include "analysis/report/data/conformity.h"
#include "analysis/report/data/data.h"
#include "analysis/report/data/reading_figures.h"
#include "analysis/report/data/section_data.h"
#include "analysis/report/parts.h"

namespace tactbench::analysis {
namespace {

using UncertaintyJson = nlohmann::ordered_json;

// JSON has no infinity.
UncertaintyJson degrees(double dof) { return std::isinf(dof) ? UncertaintyJson("infinite") : UncertaintyJson(dof); }

UncertaintyJson budget_json(const Budget& budget, bool whole) {
  UncertaintyJson u = UncertaintyJson::array(), rows = UncertaintyJson::array();
  for (std::size_t i = 0; i < kUncertaintySources; ++i) u.push_back(nullptr);
  for (const Contribution& row : budget.contributions) {
    u[static_cast<std::size_t>(row.source)] = row.u_psi;
    const SourceText& text = text_of(row.source);
    if (whole)
      rows.push_back({{"source", text.name},
                      {"type", std::string(1, text.type)},
                      {"width", row.width},
                      JSON_FIELDS(text, unit, distribution),
                      JSON_FIELDS(row, divisor, sensitivity, u_psi),
                      {"common_share", row.common},
                      {"dof", degrees(row.dof)}});
  }
  UncertaintyJson out = {JSON_FIELDS(budget, taxel, error_psi),
                         {"lower_psi", budget.lower_psi()},
                         {"upper_psi", budget.upper_psi()},
                         {"u_psi", u},
                         {"combined_psi", budget.combined_psi},
                         {"dof", degrees(budget.dof)},
                         JSON_FIELDS(budget, factor, expanded_psi, linear)};
  if (whole) out["contributions"] = rows;
  return out;
}

UncertaintyJson level_uncertainty_json(const LevelUncertainty& level, bool whole) {
  return {{"pressure_psi", level.pressure_psi},
          {"branch", level.up ? "up" : "down"},
          {"readings", level.median.readings},
          {"median", budget_json(level.median, whole)},
          {"worst", budget_json(level.worst, whole)},
          {"not_linear", level.not_linear},
          // One digit of U more than the page prints.
          {"taxel_expanded_psi", number_list(level.expanded_psi, 3)},
          {"taxel_error_psi", number_list(level.error_psi, 4)},
          {"taxel_factor", number_list(level.factor, 4)},
          {"array",
           {{"mean_expanded_psi", level.array.mean_expanded_psi},
            {"centre_expanded_pitches", std::isfinite(level.array.centre_expanded)
                                            ? UncertaintyJson(level.array.centre_expanded)
                                            : UncertaintyJson()}}}};
}

// Lists of levels x taxels: the levels in the order of `pressure_psi`.
UncertaintyJson condition_json(const ConditionUncertainty& condition, const ReportInput& input) {
  UncertaintyJson out = {{"name", condition.name},
                         {"valid", condition.valid()},
                         {"rests_on", condition.basis},
                         JSON_FIELDS(condition, histories, readings)};
  if (!condition.valid()) {
    out["not_valid_because"] = condition.not_valid;
    return out;
  }
  UncertaintyJson branches = UncertaintyJson::array();
  for (const bool up : condition.up) branches.push_back(up ? "up" : "down");
  out["factor"] = condition.factor;
  out["median_expanded_psi"] = condition.median_psi;
  const std::vector<std::size_t> fitted = input.fit.fitted();
  const double tolerance_psi = reading_tolerance(input).psi;
  out["measuring_interval"] = {{"within_psi", tolerance_psi},
                               {"up", interval_json(measuring_interval(condition, true, tolerance_psi, fitted))},
                               {"down", interval_json(measuring_interval(condition, false, tolerance_psi, fitted))}};
  out["pressure_psi"] = number_list(condition.pressure_psi);
  out["branch"] = std::move(branches);
  out["taxel_expanded_psi"] = number_list(condition.expanded_psi, 4);
  out["taxel_error_psi"] = number_list(condition.error_psi, 5);
  return out;
}

UncertaintyJson reading_json(const Uncertainty& uncertainty, const ReportInput& input) {
  UncertaintyJson sources = UncertaintyJson::array(), missing = UncertaintyJson::object(),
                  levels = UncertaintyJson::array();
  for (std::size_t i = 0; i < uncertainty.levels.size(); ++i)
    levels.push_back(level_uncertainty_json(uncertainty.levels[i], i == uncertainty.chosen));
  for (std::size_t i = 0; i < kUncertaintySources; ++i) {
    const char* name = text_of(static_cast<UncertaintySource>(i)).name;
    sources.push_back(name);
    if (!uncertainty.missing[i].empty()) missing[name] = uncertainty.missing[i];
  }
  const ReferenceUncertainty& reference = uncertainty.reference;
  UncertaintyJson limits = UncertaintyJson::object();
  for (std::size_t part = 0; part < kReferenceParts; ++part) {
    const char* name =
        text_of(static_cast<UncertaintySource>(static_cast<std::size_t>(UncertaintySource::kReferenceInput) + part))
            .name;
    const ReferenceLimit& limit = reference.limits[part];
    if (limit.half_width_psi > 0.0)
      limits[name] = limit.half_width_psi;
    else
      limits[name] = limit.part.missing.empty() ? limit.part.from : "not assessed: " + limit.part.missing;
  }
  UncertaintyJson out = {{"coverage_probability", kCoverageProbability},
                         {"reference",
                          {{"certificate", reference.calibration.certificate},
                           {"calibrated", reference.calibration.calibrated_on},
                           {"due", reference.calibration.due},
                           {"overdue", reference.overdue},
                           {"not_covered", reference.beyond ? in_words(*reference.beyond, PressureUnit::kPsi) : ""},
                           {"independent", reference.independent},
                           {"certificate_covers", in_words(reference.covers)},
                           {"beyond_the_certificate_psi", limits},
                           {"largest_u_psi", reference.largest_certificate_u()},
                           JSON_FIELDS(reference, resolution_psi, drift_psi, drift_stated_psi, drift_basis)}},
                         {"sources", sources},
                         {"not_assessed", missing},
                         {"chosen", uncertainty.chosen}};
  if (uncertainty.creep.assessed()) out["creep"] = creep_effect_json(uncertainty.creep);
  if (uncertainty.temperature.assessed()) out["temperature"] = temperature_effect_json(uncertainty.temperature);
  if (const std::optional<UseCondition> worst = uncertainty.worst())
    out["worst_kind"] = uncertainty.condition(*worst).name;
  out["conditions"] = UncertaintyJson::array();
  for (const ConditionUncertainty& condition : uncertainty.conditions)
    out["conditions"].push_back(condition_json(condition, input));
  out["levels"] = std::move(levels);
  return out;
}

}  // namespace

std::string uncertainty_json(const ReportInput& input) {
  UncertaintyJson judged = UncertaintyJson::array();
  for (const JudgedFigure& figure : input.judgement.figures)
    judged.push_back({{"on", title_of_judged(input, figure.run)},
                      {"criterion", to_string(figure.criterion)},
                      {"scope", scope_json(figure.scope)},
                      {"unit", to_string(quantity_of(figure.criterion))},
                      JSON_FIELDS(figure.u, expanded, combined),
                      {"dof", degrees(figure.u.dof)},
                      JSON_FIELDS(figure.u, factor, basis),
                      {"not_known", figure.u.missing}});
  return json_text({{"reading", input.uncertainty ? reading_json(*input.uncertainty, input) : UncertaintyJson()},
                    {"judged_figures", judged}});
}

}  // namespace tactbench::analysis
