#include "analysis/judgement/figure.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "analysis/loop.h"
#include "analysis/statistics/figures/levels.h"
#include "analysis/statistics/numbers/moments.h"
#include "db/run_store.h"

namespace tactbench::analysis {
namespace {

// The full sweeps are the sample, because a repeat may contain several. From the judged run, or from the models' run if
// the judged one has fewer than two sweeps per direction.
class SweepScatter {
 public:
  // `of_models`: results of the models' run, filled in when needed.
  SweepScatter(const Dataset& judged, const Dataset& models, const SensorModel& fit, int threads,
               std::optional<SweepErrors>& of_models)
      : fitted_(fit), range_psi_(fit.pressure_psi.back()) {
    SensorModel rising = fit;
    rising.falling = false;
    judged_ = sweep_errors(as_modelled(judged, fit), rising, threads);
    const bool own = most(judged_, true) >= 2 && most(judged_, false) >= 2;
    if (!own && !of_models) of_models = sweep_errors(as_modelled(models, fit), rising, threads);
    sweeps_ = own ? judged_ : *of_models;
    run_ = own ? "the run judged" : "the run of the models";
  }

  // Scatter of the distance between loading and unloading of the array's mean, pooled over the levels; share of full
  // pressure.
  [[nodiscard]] FigureScatter distance() const {
    const auto mean = [this](const std::vector<double>& errors) { return mean_of(errors) / range_psi_; };
    const PooledScatter up = pooled_scatter(by_sweep(true, mean)), down = pooled_scatter(by_sweep(false, mean));
    const std::size_t judged_up = most(judged_, true), judged_down = most(judged_, false);
    if (!up.known() || !down.known() || judged_up == 0 || judged_down == 0) return {};
    const std::vector<VarianceShare> shares = {{up.s / std::sqrt(static_cast<double>(judged_up)), up.dof},
                                               {down.s / std::sqrt(static_cast<double>(judged_down)), down.dof}};
    const double dof = effective_dof(shares);
    return {combined_uncertainty(shares), dof,
            fmt::format("scatter of the mean of all taxels over {} loading and {} unloading full sweeps of {}, pooled "
                        "over the levels ({:.1f} degrees of freedom); the run judged has {} and {}",
                        up.rows, down.rows, run_, dof, judged_up, judged_down)};
  }

  // Scatter of the standard deviation over the taxels at one level; share of full pressure. At a level that not every
  // sweep passes, such as a turning point, the pooled scatter of the other levels.
  [[nodiscard]] FigureScatter mismatch(double pressure_psi, bool up) const {
    const LevelReadings* const level = level_of(sweeps_, pressure_psi, up);
    const std::size_t sweeps = most(sweeps_, up), judged = most(judged_, up);
    if (level == nullptr || sweeps < 2 || judged == 0) return {};
    if (level->readings < sweeps) {
      const PooledScatter pooled =
          pooled_scatter(by_sweep(up, [&](const std::vector<double>& e) { return spread(e); }));
      if (!pooled.known()) return {};
      return quotient(pooled.s, pooled.dof, judged,
                      fmt::format("scatter of the figure over {} full sweeps of {}, pooled over their common levels",
                                  pooled.rows, run_));
    }
    std::vector<double> spreads;
    for (std::size_t sweep = 0; sweep < sweeps; ++sweep)
      spreads.push_back(spread(fitted_.row(level->error_psi, sweep)));
    return quotient(sample_deviation(spreads), static_cast<double>(sweeps - 1), judged,
                    fmt::format("scatter of the figure over {} full sweeps of {}", sweeps, run_));
  }

 private:
  static std::size_t most(const SweepErrors& errors, bool up) {
    std::size_t sweeps = 0;
    for (const LevelReadings& level : errors.levels)
      if (level.up == up) sweeps = std::max(sweeps, level.readings);
    return sweeps;
  }
  static const LevelReadings* level_of(const SweepErrors& errors, double pressure_psi, bool up) {
    const auto found = std::ranges::find_if(errors.levels, [&](const LevelReadings& level) {
      return level.up == up && same_level(level.pressure_psi, pressure_psi);
    });
    return found == errors.levels.end() ? nullptr : &*found;
  }
  [[nodiscard]] double spread(const std::vector<double>& errors) const {
    return errors.size() < 2 ? 0.0 : sample_deviation(errors) / range_psi_;
  }
  // Sweeps x levels: `figure` computed from the taxels' errors; only levels that every sweep passes.
  template <class OfErrors>
  [[nodiscard]] std::vector<std::vector<double>> by_sweep(bool up, const OfErrors& figure) const {
    std::vector<std::vector<double>> rows(most(sweeps_, up));
    for (const LevelReadings& level : sweeps_.levels)
      for (std::size_t sweep = 0; sweep < rows.size() && level.up == up && level.readings == rows.size(); ++sweep)
        rows[sweep].push_back(figure(fitted_.row(level.error_psi, sweep)));
    return rows;
  }

  Fitted fitted_;
  double range_psi_;
  SweepErrors judged_, sweeps_;
  std::string run_;
};

struct CriterionNames {
  const char* key;
  const char* text;  // by VIM and the guides on conformity
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
std::optional<Enum> one_of(const std::array<const char*, N>& text, std::string_view word) {
  const auto found = std::ranges::find(text, word);
  return found == text.end() ? std::nullopt : std::optional(static_cast<Enum>(found - text.begin()));
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

const char* display_text(Criterion criterion) { return words_of(criterion).text; }

std::string display_text(const Scope& scope, PressureUnit unit) {
  return scope.kind == Scope::Kind::kArray ? "array" : with_rest(scope, pressures_of(scope, unit));
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

namespace {

std::optional<Criterion> criterion_from(std::string_view word) {
  const auto* const found = std::ranges::find(kCriteria, word, &CriterionNames::key);
  return found == kCriteria.end() ? std::nullopt : std::optional(static_cast<Criterion>(found - kCriteria.begin()));
}

std::optional<Direction> direction_from(std::string_view word) { return one_of<Direction>(kDirections, word); }

std::optional<Scope::Kind> scope_kind_from(std::string_view word) { return one_of<Scope::Kind>(kKinds, word); }

}  // namespace

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

namespace {

constexpr std::array kVerdictNames = {"report only",      "pass",         "conditional pass",
                                      "conditional fail", "inconclusive", "fail"};
static_assert(kVerdictNames.size() == kVerdicts.size());

struct DecisionRuleText {
  DecisionRule rule;
  const char* word;
  const char* text;
};

constexpr std::array<DecisionRuleText, 5> kDecisionRules = {{
    {DecisionRule::kDefault, "default", "four-way if the uncertainty is known, simple if it is not"},
    {DecisionRule::kSimple, "simple",
     "pass when the value is at most the limit. The uncertainty is not taken into account (w = 0): for a value at the "
     "limit the risk of a false acceptance, and of a false rejection, is up to 50 %"},
    {DecisionRule::kGuarded, "guarded",
     "pass when the value is at most the limit less U (guard band w = U), else fail. The risk of a false acceptance is "
     "below 2.5 %; a value within U below the limit is rejected although it more probably conforms"},
    {DecisionRule::kFourWay, "four-way",
     "pass up to the limit less U, conditional pass up to the limit, conditional fail up to the limit plus U, fail "
     "above (w = U). The risk of a false acceptance is below 2.5 % for a pass and up to 50 % for a conditional pass; "
     "the risk of a false rejection is below 2.5 % for a fail and up to 50 % for a conditional fail"},
    {DecisionRule::kReportOnly, "report-only", "values and limits are reported; conformity is not stated"},
}};

const DecisionRuleText& text_of(DecisionRule rule) { return kDecisionRules.at(static_cast<std::size_t>(rule)); }

}  // namespace

const char* to_string(Verdict verdict) { return kVerdictNames.at(static_cast<std::size_t>(verdict)); }

std::optional<Verdict> verdict_from(std::string_view word) {
  for (const Verdict verdict : kVerdicts)
    if (word == to_string(verdict)) return verdict;
  return std::nullopt;
}

std::string verdict_text(std::optional<Verdict> verdict) { return verdict ? to_string(*verdict) : ""; }

std::vector<std::string> verdict_names() { return {kVerdictNames.begin() + 1, kVerdictNames.end()}; }

bool states_conformity(std::optional<Verdict> verdict) { return verdict && *verdict != Verdict::kReportOnly; }

bool passes(std::optional<Verdict> verdict) {
  return verdict == Verdict::kPass || verdict == Verdict::kConditionalPass;
}

const char* to_string(DecisionRule rule) { return text_of(rule).word; }

std::optional<DecisionRule> decision_rule_from(std::string_view word) {
  const auto* const found = std::ranges::find(kDecisionRules, word, &DecisionRuleText::word);
  return found == kDecisionRules.end() ? std::nullopt : std::optional(found->rule);
}

std::string rule_text(DecisionRule rule) {
  return fmt::format("“{}” (ILAC-G8:09/2019): {}", text_of(rule).word, text_of(rule).text);
}

DecisionRule rule_applied(DecisionRule asked, double expanded) {
  if (asked != DecisionRule::kDefault) return asked;
  return std::isnan(expanded) ? DecisionRule::kSimple : DecisionRule::kFourWay;
}

Verdict verdict_of(DecisionRule rule, double value, double limit, double expanded) {
  rule = rule_applied(rule, expanded);
  if (rule == DecisionRule::kReportOnly) return Verdict::kReportOnly;
  if (std::isnan(value) || std::isnan(limit)) return Verdict::kInconclusive;
  if (rule == DecisionRule::kSimple) return value <= limit ? Verdict::kPass : Verdict::kFail;
  if (std::isnan(expanded)) return Verdict::kInconclusive;
  if (value <= limit - expanded) return Verdict::kPass;
  if (rule == DecisionRule::kGuarded || value > limit + expanded) return Verdict::kFail;
  return value <= limit ? Verdict::kConditionalPass : Verdict::kConditionalFail;
}

namespace {

std::size_t repeats_of(const Dataset& dataset) {
  std::size_t least = dataset.sequences.empty() ? 0 : dataset.sequences.front().repeats.size();
  for (const SequenceData& data : dataset.sequences) least = std::min(least, data.repeats.size());
  return least;
}

Dataset repeat_of(const Dataset& dataset, std::size_t repeat) {
  Dataset one = dataset;
  for (SequenceData& data : one.sequences) data.repeats = {data.repeats[repeat]};
  return one;
}

// The sequences with more than one repeat.
Dataset repeated_of(Dataset dataset) {
  std::erase_if(dataset.sequences, [](const SequenceData& data) { return data.repeats.size() < 2; });
  return dataset;
}

// The figures of each repeat separately: of the judged run, or of the models' run if the judged run has one repeat.
class RepeatScatter {
 public:
  RepeatScatter(const Dataset& judged, const Dataset& models, const SensorModel& fit, int threads,
                ModelRunResults& shared)
      : judged_(std::max<std::size_t>(1, repeats_of(judged))) {
    const bool own = repeats_of(judged) >= 2;
    const auto evaluated = [&](const Dataset& dataset) {
      std::vector<Evaluation> each;
      for (std::size_t repeat = 0; repeat < repeats_of(dataset); ++repeat)
        each.push_back(evaluate(repeat_of(dataset, repeat), fit, threads));
      return each;
    };
    if (!own && !shared.repeats) shared.repeats = evaluated(repeated_of(models));
    repeats_ = own ? evaluated(judged) : *shared.repeats;
    run_ = own ? "the judged run" : "the run of the models, because the judged run has one repeat";
  }

  // Scatter of a mean of absolute errors, also of one taxel, pooled over the taxels.
  [[nodiscard]] FigureScatter errors() const {
    std::vector<std::vector<double>> rows;
    for (const Evaluation& evaluation : repeats_) rows.push_back(evaluation.taxel_mean_error_psi);
    const PooledScatter pooled = pooled_scatter(rows);
    if (!pooled.known()) return {};
    return quotient(pooled.s, pooled.dof, judged_,
                    fmt::format("scatter of a taxel over {} repeats of {}, pooled over {} taxels ({:.1f} degrees of "
                                "freedom)",
                                pooled.rows, run_, pooled.parts, pooled.dof));
  }

 private:
  std::size_t judged_;
  std::vector<Evaluation> repeats_;  // empty: fewer than two repeats, no scatter
  std::string run_;
};

std::vector<VarianceShare> shares_of(const ReferenceUncertainty& reference, double drift_psi) {
  std::vector<VarianceShare> shares;
  for (const ReferenceRow& row : reference.rows(reference.largest_certificate_u(), drift_psi))
    shares.push_back({row.u_psi, kInfiniteDof});
  return shares;
}

// `firm`: the contributions that give the degrees of freedom.
FigureUncertainty expanded(std::string basis, const std::vector<VarianceShare>& shares,
                           const std::vector<VarianceShare>& firm) {
  FigureUncertainty u;
  u.combined = combined_uncertainty(shares);
  u.dof = effective_dof(firm);
  u.factor = coverage_factor(std::max(1.0, u.dof));
  u.expanded = u.factor * u.combined;
  u.basis = std::move(basis);
  return u;
}

FigureUncertainty unknown(std::string why) {
  FigureUncertainty u;
  u.missing = std::move(why);
  return u;
}

constexpr const char* kOneRepeat = "neither the judged run nor that of the models has two repeats";
constexpr const char* kOneSweep = "neither the judged run nor that of the models has two full sweeps at its levels";

std::string limits_sentence(const ReferenceUncertainty& reference) {
  constexpr std::array<const char*, kReferenceParts> kNames = {"voltage input", "hysteresis", "zero", "temperature"};
  std::string text;
  for (std::size_t part = 0; part < kReferenceParts; ++part)
    if (reference.limits[part].half_width_psi > 0.0) text += fmt::format(", {}", kNames[part]);
  return text;
}

// Of a mean of absolute errors against the reference.
FigureUncertainty error_uncertainty(const FigureScatter& scatter, const ReferenceUncertainty& reference) {
  if (!reference.certificate_missing.empty()) return unknown(reference.certificate_missing);
  if (reference.untraced() && !reference.overdue)
    return unknown("the run goes beyond the pressures that the reference's certificate covers");
  if (!scatter.known()) return unknown(kOneRepeat);
  // A drift beyond its stated limit raises u but does not lower k: it adds doubt, not degrees of freedom.
  std::vector<VarianceShare> shares = shares_of(reference, reference.drift_psi);
  std::vector<VarianceShare> firm = shares_of(reference, std::min(reference.drift_psi, reference.drift_stated_psi));
  shares.push_back({scatter.u, scatter.dof});
  firm.push_back({scatter.u, scatter.dof});
  return expanded(
      fmt::format("reference (certificate{}{}{}), which moves a mean of absolute errors by at most its own "
                  "error (c = 1); and {}",
                  !reference.drift_missing.empty()                   ? ""
                  : reference.drift_psi > reference.drift_stated_psi ? ", drift beyond its stated limit"
                                                                     : ", drift",
                  reference.resolution_missing.empty() ? ", resolution" : "", limits_sentence(reference), scatter.text),
      shares, firm);
}

// Of a difference between readings at one level, in which the reference's error cancels, except for its hysteresis
// where they were reached in two directions. `hysteresis`: its half-width to each side, as a share of full pressure.
FigureUncertainty difference_uncertainty(const FigureScatter& scatter, double hysteresis = 0.0) {
  if (!scatter.known()) return unknown(kOneSweep);
  std::vector<VarianceShare> shares = {{scatter.u, scatter.dof}};
  if (hysteresis > 0.0) shares.push_back({2.0 * hysteresis / std::numbers::sqrt3, kInfiniteDof});
  return expanded(fmt::format("the reference's error cancels{}; {}",
                              hysteresis > 0.0 ? " except for its hysteresis" : "", scatter.text),
                  shares, shares);
}

}  // namespace

std::vector<Figure> measured_figures(const Dataset& judged, const Dataset& models, const SensorModel& fit,
                                     const Evaluation& evaluation, const ReferenceUncertainty& reference, int threads,
                                     ModelRunResults* shared) {
  ModelRunResults alone;
  ModelRunResults& of_models = shared != nullptr ? *shared : alone;
  const FigureUncertainty of_errors =
      error_uncertainty(RepeatScatter(judged, models, fit, threads, of_models).errors(), reference);
  const SweepScatter sweeps(judged, models, fit, threads, of_models.sweeps);
  const double full = evaluation.full_scale_psi;
  const double hysteresis = full > 0.0 ? reference.limit(ReferencePart::kHysteresis).half_width_psi / full : 0.0;
  const bool any = evaluation.frames > 0 && evaluation.worst_taxel >= 0;
  const std::size_t unfit = fit.array().size() - fit.fitted().size();
  std::vector<Figure> figures = {
      {Criterion::kMeanError, {}, any ? evaluation.mean_error_psi : kNan, of_errors},
      {Criterion::kWorstTaxelError, {}, any ? evaluation.worst_taxel_mean_error_psi : kNan, of_errors},
      {Criterion::kDistanceOfMean,
       {},
       evaluation.levels.empty() ? kNan : evaluation.comp_distance_of_mean,
       difference_uncertainty(sweeps.distance(), hysteresis)},
      {Criterion::kUnfitTaxels,
       {},
       static_cast<double>(unfit),
       {0.0, 0.0, kInfiniteDof, 2.0, "a count by the rules of identification has no uncertainty of its own", {}, {}}}};
  for (const LevelFigures& level : evaluation.levels)
    for (const bool up : {true, false})
      figures.push_back({Criterion::kMismatch, Scope::level(level.pressure_psi, up ? Direction::kUp : Direction::kDown),
                         up ? level.comp_std_up : level.comp_std_down,
                         difference_uncertainty(sweeps.mismatch(level.pressure_psi, up))});
  return figures;
}

}  // namespace tactbench::analysis
