#include "analysis/report/data/reading_figures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "analysis/json_fields.h"
#include "analysis/report/data/conformity.h"
#include "analysis/report/data/data.h"
#include "analysis/report/report_facts.h"
#include "analysis/statistics/numbers/moments.h"

namespace tactbench::analysis {

namespace {

// The smallest MPE of the applied limits, else a share of the full pressure.
struct ReadingTolerance {
  double psi = 0.0;
  bool is_mpe = false;
};

constexpr std::array kHeadlineShares = {0.01, 0.02, 0.05, 0.10, 0.20};

void summarize(ReadingLevel& level) {
  std::vector<double> error, expanded, low, high, sums;
  for (std::size_t i = 0; i < level.error_psi.size(); ++i) {
    const double sum = level.sum_psi(i);
    if (!std::isfinite(sum)) continue;
    const double u = std::isfinite(level.expanded_psi[i]) ? level.expanded_psi[i] : 0.0;
    error.push_back(level.error_psi[i]);
    expanded.push_back(level.expanded_psi[i]);
    low.push_back(level.error_psi[i] - u);
    high.push_back(level.error_psi[i] + u);
    sums.push_back(sum);
    if (level.worst < 0 || sum > level.worst_psi) {
      level.worst = static_cast<int>(i);
      level.worst_psi = sum;
    }
  }
  if (sums.empty()) return;
  const bool known = std::isfinite(expanded.front());
  level.median_error_psi = quantile_of(error, 0.5);
  level.median_expanded_psi = known ? quantile_of(expanded, 0.5) : kNan;
  level.expanded_within_psi = known ? quantile_of(expanded, kTaxelsWithin) : kNan;
  level.within_psi = quantile_of(sums, kTaxelsWithin);
  level.low_psi = quantile_of(low, 0.5 - 0.5 * kTaxelsWithin);
  level.high_psi = quantile_of(high, 0.5 + 0.5 * kTaxelsWithin);
}

// Taxels without U are left out, and levels where none has any.
std::vector<ReadingLevel> levels_of(const ConditionUncertainty& kind) {
  std::vector<ReadingLevel> levels;
  const std::size_t width = kind.expanded_psi.size() / std::max<std::size_t>(1, kind.pressure_psi.size());
  for (std::size_t i = 0; i < kind.pressure_psi.size(); ++i) {
    ReadingLevel level;
    level.pressure_psi = kind.pressure_psi[i];
    level.up = kind.up[i];
    const auto from = static_cast<std::ptrdiff_t>(i * width), end = static_cast<std::ptrdiff_t>((i + 1) * width);
    level.error_psi.assign(kind.error_psi.begin() + from, kind.error_psi.begin() + end);
    level.expanded_psi.assign(kind.expanded_psi.begin() + from, kind.expanded_psi.begin() + end);
    for (std::size_t taxel = 0; taxel < width; ++taxel)
      if (!std::isfinite(level.expanded_psi[taxel])) level.error_psi[taxel] = kNan;
    if (!finite_of(level.error_psi).empty()) levels.push_back(std::move(level));
  }
  return levels;
}

// Errors without a U that would cover any use.
std::vector<ReadingLevel> levels_without_u(const Uncertainty& uncertainty) {
  std::vector<ReadingLevel> levels;
  for (const LevelUncertainty& own : uncertainty.levels) {
    ReadingLevel& level = levels.emplace_back();
    level.pressure_psi = own.pressure_psi;
    level.up = own.up;
    level.error_psi = own.error_psi;
    level.expanded_psi.assign(own.error_psi.size(), kNan);
  }
  return levels;
}

// The longest sequence of neighbouring levels for which `holds` is true.
template <class Holds>
MeasuringInterval longest_span(const std::vector<double>& rising, Holds holds) {
  MeasuringInterval best, now;
  for (const double psi : rising) {
    if (!holds(psi)) {
      now.any = false;
      continue;
    }
    now = {true, now.any ? now.low_psi : psi, psi};
    if (!best.any || now.high_psi - now.low_psi > best.high_psi - best.low_psi) best = now;
  }
  return best;
}

void find_headline(ReadingFigures& out) {
  std::map<double, double> both;  // the larger of the two directions
  for (const ReadingLevel& level : out.levels) {
    double& most = both.try_emplace(level.pressure_psi, 0.0).first->second;
    most = std::max(most, level.within_psi);
  }
  std::vector<double> all;
  for (const auto& [psi, most] : both) all.push_back(psi);
  const auto headline = [&](double tolerance_psi) {
    out.headline_psi = tolerance_psi;
    out.headline = longest_span(all, [&](double psi) { return both.at(psi) <= tolerance_psi; });
  };
  if (out.by_mpe) return headline(out.tolerance_psi);
  for (const double share : kHeadlineShares) {
    headline(share * out.full_psi);
    if (out.headline.any && out.headline.high_psi - out.headline.low_psi >= 0.5 * (all.back() - all.front())) return;
  }
}

WorstTaxel worst_of(const std::vector<ReadingLevel>& levels, const std::string& kind) {
  WorstTaxel worst;
  double most = -1.0;
  for (const ReadingLevel& level : levels) {
    if (level.worst < 0 || level.worst_psi <= most) continue;
    most = level.worst_psi;
    const auto taxel = static_cast<std::size_t>(level.worst);
    worst = {level.worst, level.pressure_psi, level.error_psi[taxel], level.expanded_psi[taxel], level.up, kind};
  }
  return worst;
}

}  // namespace

double ReadingLevel::sum_psi(std::size_t taxel) const {
  const double u = expanded_psi[taxel];
  return std::abs(error_psi[taxel]) + (std::isfinite(u) ? u : 0.0);
}

const ReadingLevel* ReadingFigures::level(double pressure_psi, bool up) const {
  const auto found = std::ranges::find_if(
      levels, [&](const ReadingLevel& own) { return own.up == up && own.pressure_psi == pressure_psi; });
  return found == levels.end() ? nullptr : &*found;
}

namespace {

ReadingTolerance reading_tolerance(const ReportInput& input) {
  const std::vector<JudgedFigure>& judged = input.judgement.figures;
  double tightest = std::numeric_limits<double>::infinity();
  for (const JudgedFigure& own : judged)
    if (own.criterion == Criterion::kMpe) tightest = std::min(tightest, own.limit);
  if (std::isfinite(tightest)) return {tightest, true};
  return {kToleratedShare * input.evaluation.full_scale_psi, false};
}

}  // namespace

std::optional<ReadingFigures> reading_figures(const ReportInput& input) {
  if (!input.uncertainty || input.uncertainty->levels.empty()) return {};
  const Uncertainty& uncertainty = *input.uncertainty;
  ReadingFigures out;
  const std::optional<UseCondition> quoted = uncertainty.worst();
  for (const ConditionUncertainty& kind : uncertainty.conditions) {
    const bool of_history = static_cast<std::size_t>(kind.condition) < kHistoryKinds;
    if (!kind.valid() || !of_history || kind.pressure_psi.empty()) continue;
    std::vector<ReadingLevel> levels = levels_of(kind);
    std::ranges::for_each(levels, summarize);
    const WorstTaxel worst = worst_of(levels, kind.name);
    if (out.worst.taxel < 0 ||
        std::abs(worst.error_psi) + worst.expanded_psi > std::abs(out.worst.error_psi) + out.worst.expanded_psi)
      out.worst = worst;
    if (kind.condition != quoted) continue;
    out.kind = kind.name;
    out.levels = std::move(levels);
  }
  if (!out.known()) {
    out.levels = levels_without_u(uncertainty);
    std::ranges::for_each(out.levels, summarize);
    out.worst = worst_of(out.levels, "");
  }
  for (ReadingLevel& level : out.levels)
    if (const LevelUncertainty* const budget = uncertainty.level(level.pressure_psi, level.up))
      level.mean_expanded_psi = budget->array.mean_expanded_psi;
  out.full_psi = input.evaluation.full_scale_psi;
  const ReadingTolerance tolerance = reading_tolerance(input);
  out.tolerance_psi = tolerance.psi;
  out.by_mpe = tolerance.is_mpe;
  if (!out.known()) return out;
  const std::vector<std::size_t> fitted = input.fit.fitted();
  out.span_up = measuring_interval(uncertainty.condition(*quoted), true, tolerance.psi, fitted);
  out.span_down = measuring_interval(uncertainty.condition(*quoted), false, tolerance.psi, fitted);
  find_headline(out);
  return out;
}

namespace {

// null: at no level
nlohmann::ordered_json interval_json(const MeasuringInterval& interval) {
  return interval.any ? nlohmann::ordered_json{JSON_FIELDS(interval, low_psi, high_psi)} : nlohmann::ordered_json();
}

}  // namespace

nlohmann::ordered_json reading_figures_json(const ReadingFigures& figures) {
  nlohmann::ordered_json levels = nlohmann::ordered_json::array();
  for (const ReadingLevel& level : figures.levels)
    levels.push_back({{"pressure_psi", level.pressure_psi},
                      {"branch", level.up ? "up" : "down"},
                      JSON_FIELDS(level, median_error_psi, median_expanded_psi, within_psi, low_psi, high_psi,
                                  expanded_within_psi, mean_expanded_psi),
                      {"worst_taxel", level.worst},
                      {"worst_psi", level.worst_psi}});
  return {{"kind", figures.kind},
          {"taxels_within", kTaxelsWithin},
          JSON_FIELDS(figures, full_psi, tolerance_psi),
          {"tolerance_is_mpe", figures.by_mpe},
          {"interval_up", interval_json(figures.span_up)},
          {"interval_down", interval_json(figures.span_down)},
          {"headline", {{"within_psi", figures.headline_psi}, {"interval", interval_json(figures.headline)}}},
          {"worst",
           {JSON_FIELDS(figures.worst, taxel, pressure_psi),
            {"branch", figures.worst.up ? "up" : "down"},
            JSON_FIELDS(figures.worst, error_psi, expanded_psi, kind)}},
          {"levels", levels}};
}

// The figures of the section "Uncertainty", and of conformity, as JSON.

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
                           {"not_covered", reference.beyond ? display_text(*reference.beyond, PressureUnit::kPsi) : ""},
                           {"independent", reference.independent},
                           {"certificate_covers", display_text(reference.covers)},
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
