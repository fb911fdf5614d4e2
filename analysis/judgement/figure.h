// A figure that is compared with a limit: its criterion, its scope, its value with U, and its verdict.
#pragma once

#include <cstdint>
#include <limits>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/judgement/verdict.h"
#include "analysis/pressure_unit.h"
#include "analysis/statistics/figures/limits.h"
#include "analysis/statistics/uncertainty/history_kind.h"
#include "db/record.h"

namespace tactbench::analysis {

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
std::optional<Criterion> criterion_from(std::string_view word);
std::optional<Scope::Kind> scope_kind_from(std::string_view word);
std::optional<Direction> direction_from(std::string_view word);

// Text for display: "mean absolute error"; "array", "275.8 kPa increasing", "0 to 413.7 kPa, 95 %" of the taxels.
const char* display_text(Criterion criterion);
std::string display_text(const Scope& scope, PressureUnit unit);
// Followed by the other unit, for documents: "275.8 kPa (40 psi) increasing".
std::string in_both_units(const Scope& scope, PressureUnit unit);
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

}  // namespace tactbench::analysis
