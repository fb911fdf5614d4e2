// Trends of figures: the figures of a subject (a scenario of the nightly suite, a sensor, a rig) from run to run,
// compared with the spread of the runs that were accepted as its baseline.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "analysis/pressure_unit.h"
#include "analysis/statistics/control/control_chart.h"
#include "db/run_store.h"

namespace tactbench::bench {

struct TrendFigure {
  std::string name;                // includes the unit
  std::vector<std::int64_t> runs;  // runs that are not void, in order
  std::vector<double> values;      // value of each run
  std::vector<bool> accepted;      // whether the run belongs to the baseline
  // Start-up values: those of the baseline, each measurement once. Later values: those of the runs after the baseline's
  // last one, without simulated runs that repeat the seeds of an earlier run. No EWMA if the newest run is such a
  // repetition.
  analysis::ControlChart chart;
  bool compared = false;  // it has a band, and its newest run does not belong to the baseline
  bool missing = false;   // the newest run does not have this figure
  bool outside = false;   // the newest run's value is outside the wide band, differs from the constant, or is missing
  bool shifted = false;   // the EWMA is significant when all figures are judged together
  bool outlier = false;   // the newest value is far from those of the other sensors: mark_outliers()
  // Value of the run before the newest; NaN: there is none.
  [[nodiscard]] double former() const;
};

struct SubjectTrend {
  std::string subject;
  std::int64_t run = 0;                        // the newest; 0: none
  std::string origin;                          // of that run; runs of another origin are left out
  std::optional<db::BaselineRecord> baseline;  // the newest of the subject
  std::size_t repeated = 0;                    // runs of the baseline that repeat another run and do not count
  std::size_t counted = 0;                     // runs of the baseline that count
  std::int64_t same_seeds = 0;  // simulated data: newest earlier run with the same seeds as the newest run; 0: none
  std::vector<TrendFigure> figures;  // by name
};

// The records of a subject in a store, read once.
class TrendReader {
 public:
  TrendReader(const db::Models& store, const std::string& subject);
  // The trend as it was when `run` was the newest run. No figure is `shifted` yet: judge_shifts() decides that.
  // Values that are not numbers are left out. Empty for an unknown subject.
  [[nodiscard]] SubjectTrend up_to(std::int64_t run) const;
  [[nodiscard]] std::map<std::string, double> figures_of(std::int64_t run) const;

 private:
  std::string subject_;
  std::optional<db::BaselineRecord> baseline_;
  std::vector<db::FigureRecord> records_;
  std::map<std::int64_t, std::int64_t> repeated_, same_seeds_;  // run -> the earlier one
};
// The trend up to the newest run.
SubjectTrend follow(const db::Models& store, const std::string& subject);
// Sets `shifted` by the false discovery rate over all charts of these subjects (control_chart.h). Constants and
// figures without a chart are not counted.
void judge_shifts(const std::vector<SubjectTrend*>& family);
// follow() and judge_shifts() with only the subject's figures.
SubjectTrend trend_of_subject(const db::Models& store, const std::string& subject);

// Sets `outlier` among at least five sensors that have the same figure for the same recipes and model: an outlier
// exceeds kOutlierScore, as on a batch page, and differs from the median by more than a tenth of it.
void mark_outliers(std::vector<SubjectTrend>& sensors);

// "mean_error_psi" -> "mean error", "psi"; "elam_alpha_a1_per_psi" -> "elam alpha a1", "1/psi".
struct FigureLabel {
  std::string name, unit;  // unit empty: dimensionless
  [[nodiscard]] std::string text() const { return unit.empty() ? name : name + ", " + unit; }
};
FigureLabel display_text(const std::string& figure);

// Range of the plot of a figure over its runs: with a band three times its width, the band in the middle; without one
// from 0 to the largest value, so that small changes look small.
struct FigureScale {
  double low = 0.0, high = 1.0;
};
FigureScale scale_of(const TrendFigure& figure);

// One line per figure outside its band, and one per shifted figure.
std::vector<std::string> outside_band_lines(const SubjectTrend& followed);
std::vector<std::string> shift_lines(const SubjectTrend& followed);
// Text that lists what is not judged because the baseline is too short for control charts; empty if it is long enough.
std::string short_baseline(const SubjectTrend& followed);

// The newest values, at most `width`, as a sparkline of blocks; a value beyond the scale is an arrow.
std::string sparkline(const std::vector<double>& values, const FigureScale& scale, std::size_t width);

// Converts trends of figures to the display unit of pressure. Stores, JSON and baselines keep psi, also in the names.

// A copy with the figures whose names have the unit psi ("mean_error_psi", "hold_drift_psi_per_min", "x_per_psi") in
// `unit`: their names ("mean_error_kpa"), values, bands, averages and slopes. Other figures are unchanged.
SubjectTrend in_unit(SubjectTrend followed, analysis::PressureUnit unit);

}  // namespace tactbench::bench
