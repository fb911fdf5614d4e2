// The figures of the section "Uncertainty", and of conformity, as JSON.
#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

#include "analysis/report/page.h"

namespace tactbench::analysis {
namespace {

using UncertaintyJson = nlohmann::ordered_json;

// Three digits of U are one more than the page prints. Written straight: there are 16 000 of them in a report.
std::string map_text(const std::vector<double>& values) {
  std::string text = "[";
  for (const double value : values) {
    if (text.size() > 1) text += ',';
    if (std::isfinite(value)) {
      fmt::format_to(std::back_inserter(text), "{:.3g}", value);
    } else {
      text += "null";
    }
  }
  return text + "]";
}

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
                      {"unit", text.unit},
                      {"distribution", text.distribution},
                      {"divisor", row.divisor},
                      {"sensitivity", row.sensitivity},
                      {"u_psi", row.u_psi},
                      {"dof", degrees(row.dof)}});
  }
  UncertaintyJson out = {{"taxel", budget.taxel},
                         {"error_psi", budget.error_psi},
                         {"u_psi", u},
                         {"combined_psi", budget.combined_psi},
                         {"dof", degrees(budget.dof)},
                         {"factor", budget.factor},
                         {"expanded_psi", budget.expanded_psi},
                         {"linear", budget.linear}};
  if (whole) out["contributions"] = rows;
  return out;
}

std::string dumped(const UncertaintyJson& json) {
  return json.dump(-1, ' ', true, UncertaintyJson::error_handler_t::replace);
}

std::string level_uncertainty_text(const LevelUncertainty& level, bool whole) {
  std::string text = dumped({{"pressure_psi", level.pressure_psi},
                             {"branch", level.up ? "up" : "down"},
                             {"readings", level.median.readings},
                             {"median", budget_json(level.median, whole)},
                             {"worst", budget_json(level.worst, whole)},
                             {"not_linear", level.not_linear}});
  text.pop_back();
  return fmt::format("{},\"taxel_expanded_psi\":{}}}", text, map_text(level.expanded_psi));
}

std::string reading_text(const Uncertainty& uncertainty) {
  UncertaintyJson sources = UncertaintyJson::array(), missing = UncertaintyJson::object();
  for (std::size_t i = 0; i < kUncertaintySources; ++i) {
    const char* name = text_of(static_cast<UncertaintySource>(i)).name;
    sources.push_back(name);
    if (!uncertainty.missing[i].empty()) missing[name] = uncertainty.missing[i];
  }
  const ReferenceUncertainty& reference = uncertainty.reference;
  std::string text = dumped({{"coverage_probability", kCoverageProbability},
                             {"reference",
                              {{"certificate", reference.certificate},
                               {"due", reference.due},
                               {"overdue", reference.overdue},
                               {"independent", reference.independent},
                               {"largest_u_psi", reference.largest_certificate_u()},
                               {"resolution_psi", reference.resolution_psi},
                               {"drift_psi", reference.drift_psi}}},
                             {"sources", sources},
                             {"not_assessed", missing},
                             {"chosen", uncertainty.chosen}});
  text.pop_back();
  text += effects_members(uncertainty);
  text += ",\"levels\":[";
  for (std::size_t i = 0; i < uncertainty.levels.size(); ++i) {
    if (i > 0) text += ",\n";
    text += level_uncertainty_text(uncertainty.levels[i], i == uncertainty.chosen);
  }
  return text + "]}";
}

}  // namespace

std::string uncertainty_json(const ReportInput& input) {
  UncertaintyJson judged = UncertaintyJson::array();
  for (const JudgedUncertainty& figure : input.judged)
    judged.push_back({{"criterion", figure.criterion},
                      {"scope", figure.scope},
                      {"unit", figure.unit},
                      {"expanded", figure.expanded},
                      {"combined", figure.combined},
                      {"dof", degrees(figure.dof)},
                      {"factor", figure.factor},
                      {"basis", figure.basis},
                      {"not_known", figure.missing}});
  return fmt::format("{{\"reading\":{},\n\"judged_figures\":{}}}",
                     input.uncertainty ? reading_text(*input.uncertainty) : std::string("null"), dumped(judged));
}

}  // namespace tactbench::analysis
