// Figures that are compared with limits: criterion, scope, value with U, verdict; and how they are computed from an
// evaluated run.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "analysis/dataset.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/loop.h"
#include "analysis/pressure_unit.h"
#include "analysis/statistics/figures/evaluation.h"
#include "analysis/statistics/figures/levels.h"
#include "analysis/statistics/figures/limits.h"
#include "analysis/statistics/figures/reading_errors.h"
#include "analysis/statistics/numbers/moments.h"
#include "analysis/statistics/uncertainty/empirical_errors.h"
#include "analysis/statistics/uncertainty/reference_uncertainty.h"
#include "db/record.h"

namespace tactbench::analysis {

// Verdicts and decision rules (ILAC-G8:09/2019). The store, JSON and printed output use their names; decisions compare
// the enum.
// Best first, so that the worse of two is the larger. kReportOnly (no statement of conformity) ranks best and is never
// stored.
enum class Verdict { kReportOnly, kPass, kConditionalPass, kConditionalFail, kInconclusive, kFail };
inline constexpr std::array kVerdicts = {Verdict::kReportOnly,      Verdict::kPass,         Verdict::kConditionalPass,
                                         Verdict::kConditionalFail, Verdict::kInconclusive, Verdict::kFail};

// "report only", "pass", "conditional pass", "conditional fail", "inconclusive", "fail".
const char* to_string(Verdict verdict);
std::optional<Verdict> verdict_from(std::string_view word);
// Empty without a verdict.
std::string verdict_text(std::optional<Verdict> verdict);
// The words that a store may contain, best first.
std::vector<std::string> verdict_names();
// Whether the verdict states conformity or nonconformity: false without a verdict, and for report only.
bool states_conformity(std::optional<Verdict> verdict);
bool passes(std::optional<Verdict> verdict);  // also for a conditional pass

// Guard band w. Simple: w = 0, pass when value <= limit. Guarded: w = U, pass when value <= limit - U, else fail.
// Four-way: w = U, pass up to limit - U, conditional pass up to the limit, conditional fail up to limit + U, else fail.
// Report-only: no verdict.
const char* to_string(DecisionRule rule);  // "default", "simple", "guarded", "four-way", "report-only"
std::optional<DecisionRule> decision_rule_from(std::string_view word);
// Text on the rule and its risk, for reports.
std::string rule_text(DecisionRule rule);
// The rule that is applied: for kDefault, four-way if U (`expanded`) is known, simple if it is NaN.
DecisionRule rule_applied(DecisionRule asked, double expanded);

// `expanded` NaN: not known; then guarded and four-way are inconclusive, because a weaker rule must not replace the
// requested one. A value equal to the limit passes.
Verdict verdict_of(DecisionRule rule, double value, double limit, double expanded);

// kMeanError: over all fitted taxels and frames. kWorstTaxelError: the largest mean error of a taxel. kDistanceOfMean:
// distance between loading and unloading of the array's mean. kUnfitTaxels: taxels without a model. kMismatch: standard
// deviation over the taxels at a level. kMpe: the |error| of a reading that `share` of the taxels do not exceed at any
// level of a span.
enum class Criterion { kMeanError, kWorstTaxelError, kDistanceOfMean, kUnfitTaxels, kMismatch, kMpe };

enum class Quantity { kPressure, kShareOfFullScale, kCount };  // values in psi; shares of 1; taxels
Quantity quantity_of(Criterion criterion);
// Whether the criterion applies to single readings. The other criteria are means or standard deviations, which single
// readings may exceed by far.
bool is_per_reading(Criterion criterion);

enum class Direction { kBoth, kUp, kDown };

struct Scope {
  enum class Kind { kArray, kLevel, kSpan };
  Kind kind = Kind::kArray;
  double low_psi = 0.0, high_psi = 0.0;  // for a level both are its pressure; for the array 0
  Direction direction = Direction::kBoth;
  double share = 1.0;  // share of the fitted taxels for which the figure must hold
  static Scope level(double psi, Direction direction);
  static Scope span(double low_psi, double high_psi, double share);
  friend bool operator==(const Scope&, const Scope&) = default;
};

// U of a judged figure (not of a taxel's reading): k = t_95.45 for the effective degrees of freedom.
struct FigureUncertainty {
  double expanded = std::numeric_limits<double>::quiet_NaN();  // U, in the unit of the value; NaN: not known
  double combined = std::numeric_limits<double>::quiet_NaN(), dof = 0.0, factor = 0.0;
  std::string basis;    // how U was formed; without pressures
  std::string missing;  // why U is not known; empty: it is known, or the store has it without its parts
  // For the U of a reading: the kinds of history for which it was computed; empty: not known, or not of a reading.
  std::vector<UseCondition> kinds = {};
};

struct Figure {
  Criterion criterion = Criterion::kMeanError;
  Scope scope;
  double value = 0.0;  // NaN: not measured
  FigureUncertainty u;
};

struct JudgedFigure : Figure {
  std::int64_t run = 0;
  std::int64_t fit = 0, model_run = 0;  // fit and run of the models; 0: without a stored fit
  double limit = 0.0;
  DecisionRule rule = DecisionRule::kSimple;  // the applied rule, never kDefault
  Verdict verdict = Verdict::kInconclusive;
  std::string limits_sha256;
  // (value + U) / limit, without U if it is not known; above 1 the figure exceeds its limit. 0 if value and limit are
  // 0.
  [[nodiscard]] double use_of_limit() const;
};

// Names in stores, limits files and JSON: "mean_compensation_error"; "psi", "FS", "taxels"; "array", "level", "span";
// "both", "up", "down". *_from(): none for an unknown word.
const char* to_string(Criterion criterion);
const char* to_string(Quantity quantity);
const char* to_string(Scope::Kind kind);
const char* to_string(Direction direction);

// Text for display: "mean absolute error"; "array", "275.8 kPa increasing", "0 to 413.7 kPa, 95 %" of the taxels.
const char* display_text(Criterion criterion);
std::string display_text(const Scope& scope, PressureUnit unit);
// A value, U or limit of the criterion: "6.23 kPa", "1.5 % FS", "1 taxel", "not measured".
std::string figure_text(Criterion criterion, double value, PressureUnit unit);

// {"kind": "array"}; {"kind": "level", "psi": 40, "direction": "up"}; {"kind": "span", "low_psi": 0, "high_psi": 60,
// "direction": "both", "share": 0.95}.
nlohmann::ordered_json scope_json(const Scope& scope);
// criterion scope value expanded limit unit rule verdict limits_sha256
nlohmann::ordered_json figure_json(const JudgedFigure& figure);

// To a stored record, and back; U is then without its parts. Throws StoreError TB-STORE-SQL for an unknown word.
db::VerdictRecord record_of(const JudgedFigure& figure, const std::string& limits_toml);
JudgedFigure figure_of(const db::VerdictRecord& record);
std::vector<JudgedFigure> figures_of(std::span<const db::VerdictRecord> records);

// Computes the figures of an evaluated run for which limits can be set, each with its U.
// Results of the models' run that several judged runs share, computed on first use.
struct ModelRunResults {
  std::optional<SweepErrors> sweeps;               // for rising outputs
  std::optional<std::vector<Evaluation>> repeats;  // each repeat evaluated separately
};

// All criteria except kMpe (mpe.h); kMismatch at every level in both directions. `evaluation` and `reference` belong to
// `judged`. U by criterion:
//   kMeanError, kWorstTaxelError   a common error of the reference moves them by at most itself (triangle inequality):
//                                  c = 1, not known without a certificate. Scatter: of a taxel from repeat to repeat,
//                                  pooled over the taxels, / sqrt(repeats)
//   kDistanceOfMean                the reference's error cancels in differences at one level. Scatter: of the array's
//                                  mean from full sweep to full sweep, pooled over the levels
//   kMismatch                      likewise; scatter of the figure from full sweep to full sweep
//   kUnfitTaxels                   a count by rule: U = 0
// Pooling (moments.h) states its own degrees of freedom (JCGM 100, H.3.6). The scatter is that of `judged`, or of
// `models` (the run from which they were made) if `judged` has only one repeat or one full sweep. Throws as evaluate().
std::vector<Figure> measured_figures(const Dataset& judged, const Dataset& models, const SensorModel& fit,
                                     const Evaluation& evaluation, const ReferenceUncertainty& reference,
                                     int threads = 0, ModelRunResults* shared = nullptr);

// Scatter of a judged figure from full sweep to full sweep. Used only by figure.cpp.
// Scatter of one criterion's figure, as a standard uncertainty of the judged figure.
struct FigureScatter {
  double u = 0.0, dof = 0.0;
  std::string text;  // empty: not known
  [[nodiscard]] bool known() const { return !text.empty(); }
};

inline FigureScatter quotient(double s, double dof, std::size_t judged, std::string text) {
  if (judged > 1) text += fmt::format(", divided by √{}", judged);
  return {s / std::sqrt(static_cast<double>(std::max<std::size_t>(1, judged))), dof, std::move(text)};
}

}  // namespace tactbench::analysis
