// Errors of a reading: the figures of pages 1, 4 and 5, over the taxels at each level. They are computed only here and
// stored in the report's data. A quantile is quantile_of() (moments.h).
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "analysis/report/report.h"
#include "analysis/statistics/numbers/moments.h"
#include "analysis/statistics/uncertainty/empirical_errors.h"

namespace tactbench::analysis {

inline constexpr double kTaxelsWithin = kMeasuringShare;  // share of the taxels to which statements apply
inline constexpr double kToleratedShare = 0.02;           // of the full pressure, if the limits state no MPE

struct ReadingLevel {
  double pressure_psi = 0.0;
  bool up = true;
  double median_error_psi = 0.0, median_expanded_psi = 0.0;
  double within_psi = 0.0;                                // |error| + U that 95 % of the taxels do not exceed
  double low_psi = 0.0, high_psi = 0.0;                   // 2.5 % quantile of error - U, 97.5 % quantile of error + U
  double expanded_within_psi = 0.0;                       // U that 95 % of the taxels do not exceed
  double mean_expanded_psi = kNan;                        // U of the mean of all taxels, from the budgets
  int worst = -1;                                         // taxel with the largest |error| + U here
  double worst_psi = 0.0;                                 // that sum
  std::vector<double> error_psi, expanded_psi;            // taxels
  [[nodiscard]] double sum_psi(std::size_t taxel) const;  // |error| + U, or |error| if U is not known
};

struct WorstTaxel {  // largest |error| + U over the measured kinds of history, levels and directions
  int taxel = -1;
  double pressure_psi = 0.0, error_psi = 0.0, expanded_psi = 0.0;
  bool up = true;
  std::string kind;
};

struct ReadingFigures {
  std::string kind;  // the worst of the measured kinds of history; empty: U is not known for any, and U is NaN
  double full_psi = 0.0, tolerance_psi = 0.0;
  bool by_mpe = false;                   // the tolerance is the MPE of the limits, else a share of the full pressure
  std::vector<ReadingLevel> levels;      // rising levels in ascending order, then falling ones
  MeasuringInterval span_up, span_down;  // interval in which 95 % of the taxels are within the tolerance
  // The tolerance of the headline: the MPE, else the smallest share of the full pressure that 95 % of the taxels meet
  // in both directions over at least half of the range.
  double headline_psi = 0.0;
  MeasuringInterval headline;
  WorstTaxel worst;
  [[nodiscard]] bool known() const { return !kind.empty(); }
  [[nodiscard]] const ReadingLevel* level(double pressure_psi, bool up) const;
};

// None without an assessed U.
std::optional<ReadingFigures> reading_figures(const ReportInput& input);
nlohmann::ordered_json reading_figures_json(const ReadingFigures& figures);

}  // namespace tactbench::analysis
