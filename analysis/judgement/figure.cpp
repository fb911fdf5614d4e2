#include "analysis/judgement/figure.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "db/run_store.h"

namespace tactbench::analysis {
namespace {

struct CriterionNames {
  const char* key;
  const char* words;  // by VIM and the guides on conformity
  Quantity quantity;
};

constexpr std::array<CriterionNames, 6> kCriteria = {{
    // by Criterion
    {"mean_compensation_error", "mean absolute error", Quantity::kPressure},
    {"worst_taxel_error", "worst taxel's mean error", Quantity::kPressure},
    {"distance_of_mean", "hysteresis of the mean", Quantity::kShareOfFullScale},
    {"unfit_taxels", "taxels not modelled", Quantity::kCount},
    {"mismatch", "non-uniformity", Quantity::kShareOfFullScale},
    {"mpe", "maximum permissible error", Quantity::kPressure},
}};
constexpr std::array kQuantities = {"psi", "FS", "taxels"};
constexpr std::array kKinds = {"array", "level", "span"};
constexpr std::array kDirections = {"both", "up", "down"};

const CriterionNames& words_of(Criterion criterion) { return kCriteria.at(static_cast<std::size_t>(criterion)); }

template <class Enum, std::size_t N>
std::optional<Enum> one_of(const std::array<const char*, N>& words, std::string_view word) {
  const auto found = std::ranges::find(words, word);
  return found == words.end() ? std::nullopt : std::optional(static_cast<Enum>(found - words.begin()));
}

std::string pressures_of(const Scope& scope, PressureUnit unit) {
  return scope.kind == Scope::Kind::kLevel ? unit.short_text(scope.low_psi)
                                           : unit.short_span(scope.low_psi, scope.high_psi);
}

// "275.8 kPa" followed by direction and share.
std::string with_rest(const Scope& scope, std::string text) {
  if (scope.direction != Direction::kBoth) text += scope.direction == Direction::kUp ? " increasing" : " decreasing";
  if (scope.share < 1.0) text += fmt::format(", {:g} %", 100.0 * scope.share);
  return text;
}

}  // namespace

Quantity quantity_of(Criterion criterion) { return words_of(criterion).quantity; }
bool is_per_reading(Criterion criterion) { return criterion == Criterion::kMpe; }

Scope Scope::level(double psi, Direction direction) { return {Kind::kLevel, psi, psi, direction, 1.0}; }

Scope Scope::span(double low_psi, double high_psi, double share) {
  return {low_psi == high_psi ? Kind::kLevel : Kind::kSpan, low_psi, high_psi, Direction::kBoth, share};
}

double JudgedFigure::use_of_limit() const {
  const double most = value + (std::isnan(u.expanded) ? 0.0 : u.expanded);
  if (std::isnan(most) || limit == 0.0) return most <= 0.0 ? 0.0 : std::numeric_limits<double>::infinity();
  return most / limit;
}

const char* to_string(Criterion criterion) { return words_of(criterion).key; }
const char* to_string(Quantity quantity) { return kQuantities.at(static_cast<std::size_t>(quantity)); }
const char* to_string(Scope::Kind kind) { return kKinds.at(static_cast<std::size_t>(kind)); }
const char* to_string(Direction direction) { return kDirections.at(static_cast<std::size_t>(direction)); }

std::optional<Criterion> criterion_from(std::string_view word) {
  const auto* const found = std::ranges::find(kCriteria, word, &CriterionNames::key);
  return found == kCriteria.end() ? std::nullopt : std::optional(static_cast<Criterion>(found - kCriteria.begin()));
}
std::optional<Scope::Kind> scope_kind_from(std::string_view word) { return one_of<Scope::Kind>(kKinds, word); }
std::optional<Direction> direction_from(std::string_view word) { return one_of<Direction>(kDirections, word); }

const char* display_text(Criterion criterion) { return words_of(criterion).words; }

std::string display_text(const Scope& scope, PressureUnit unit) {
  return scope.kind == Scope::Kind::kArray ? "array" : with_rest(scope, pressures_of(scope, unit));
}

std::string in_both_units(const Scope& scope, PressureUnit unit) {
  if (scope.kind == Scope::Kind::kArray) return "array";
  return with_rest(scope, fmt::format("{} ({})", pressures_of(scope, unit), pressures_of(scope, unit.beside())));
}

std::string figure_text(Criterion criterion, double value, PressureUnit unit) {
  if (!std::isfinite(value)) return "not measured";  // e.g. the run has no such level
  switch (quantity_of(criterion)) {
    case Quantity::kPressure:
      return fmt::format("{:.3g} {}", unit.of(value), unit.symbol());
    case Quantity::kShareOfFullScale:
      return fmt::format("{:.3g} % FS", 100.0 * value);
    case Quantity::kCount:
      break;
  }
  return value == 1.0 ? "1 taxel" : fmt::format("{:.3g} taxels", value);
}

nlohmann::ordered_json scope_json(const Scope& scope) {
  nlohmann::ordered_json json = {{"kind", to_string(scope.kind)}};
  if (scope.kind == Scope::Kind::kArray) return json;
  if (scope.kind == Scope::Kind::kLevel) {
    json["psi"] = scope.low_psi;
  } else {
    json["low_psi"] = scope.low_psi;
    json["high_psi"] = scope.high_psi;
  }
  json["direction"] = to_string(scope.direction);
  if (scope.share < 1.0) json["share"] = scope.share;
  return json;
}

nlohmann::ordered_json figure_json(const JudgedFigure& figure) {
  return {{"criterion", to_string(figure.criterion)},
          {"scope", scope_json(figure.scope)},
          {"value", figure.value},
          {"expanded", figure.u.expanded},
          {"limit", figure.limit},
          {"unit", to_string(quantity_of(figure.criterion))},
          {"rule", to_string(figure.rule)},
          {"verdict", to_string(figure.verdict)},
          {"limits_sha256", figure.limits_sha256}};
}

db::VerdictRecord record_of(const JudgedFigure& figure, const std::string& limits_toml) {
  db::VerdictRecord record;
  record.run = figure.run;
  record.fit = figure.fit;
  record.model_run = figure.model_run;
  record.criterion = to_string(figure.criterion);
  record.scope_kind = to_string(figure.scope.kind);
  record.low_psi = figure.scope.low_psi;
  record.high_psi = figure.scope.high_psi;
  record.direction = to_string(figure.scope.direction);
  record.share = figure.scope.share;
  record.value = figure.value;
  record.expanded = figure.u.expanded;
  record.limit = figure.limit;
  record.unit = to_string(quantity_of(figure.criterion));
  record.rule = to_string(figure.rule);
  record.verdict = to_string(figure.verdict);
  record.limits_toml = limits_toml;
  record.limits_sha256 = figure.limits_sha256;
  return record;
}

JudgedFigure figure_of(const db::VerdictRecord& record) {
  const auto criterion = criterion_from(record.criterion);
  const auto kind = scope_kind_from(record.scope_kind);
  const auto direction = direction_from(record.direction);
  const auto rule = decision_rule_from(record.rule);
  const auto verdict = verdict_from(record.verdict);
  if (!criterion || !kind || !direction || !rule || !verdict)
    throw db::StoreError(
        "TB-STORE-SQL",
        fmt::format("a verdict on run {} contains a word that this program does not know: {}, {}, {}, {}, {}",
                    record.run, record.criterion, record.scope_kind, record.direction, record.rule, record.verdict),
        "judge the run again: tactbench judge MODEL RUN --limits FILE");
  JudgedFigure figure;
  figure.criterion = *criterion;
  figure.scope = {*kind, record.low_psi, record.high_psi, *direction, record.share};
  figure.value = record.value;
  figure.u.expanded = record.expanded;
  figure.run = record.run;
  figure.fit = record.fit;
  figure.model_run = record.model_run;
  figure.limit = record.limit;
  figure.rule = *rule;
  figure.verdict = *verdict;
  figure.limits_sha256 = record.limits_sha256;
  return figure;
}

std::vector<JudgedFigure> figures_of(std::span<const db::VerdictRecord> records) {
  std::vector<JudgedFigure> figures;
  for (const db::VerdictRecord& record : records) figures.push_back(figure_of(record));
  return figures;
}

}  // namespace tactbench::analysis
