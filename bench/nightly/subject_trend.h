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
  std::string name;                // with the unit in it
  std::vector<std::int64_t> runs;  // runs that are not void, in order
  std::vector<double> values;      // value of each run
  std::vector<bool> accepted;      // belongs to the baseline
  // Start-up: the baseline's values, each measurement once. Later: those of the runs after the baseline's last one,
  // without simulated runs that repeat the seeds of an earlier one. No EWMA when the newest run is such a run.
  analysis::ControlChart chart;
  bool compared = false;  // it has a band, and its newest run is not one of the baseline's
  bool missing = false;   // the newest run has none
  bool outside = false;   // the newest run's value is outside the wide band, or not the constant, or missing
  bool shifted = false;   // the EWMA is reported among the figures judged together
  bool outlier = false;   // the newest value lies far from those of the other sensors: mark_outliers()
  // Of the run before the newest; NaN: there is none.
  [[nodiscard]] double former() const;
};

struct SubjectTrend {
  std::string subject;
  std::int64_t run = 0;                        // the newest; 0: none
  std::string origin;                          // of that run; runs of another origin are left out
  std::optional<db::BaselineRecord> baseline;  // the newest of the subject
  std::size_t repeated = 0;                    // runs of the baseline that repeat another one and do not count
  std::size_t counted = 0;                     // runs of the baseline that count
  std::int64_t same_seeds = 0;                 // simulated: newest earlier run with the newest run's seeds; 0: none
  std::vector<TrendFigure> figures;            // by name
};

// The records of a subject in a store, read once.
class TrendReader {
 public:
  TrendReader(const db::RunStore& store, const std::string& subject);
  // As the subject stood when `run` was the newest one. Not judged together with anything yet: no figure is `shifted`.
  // Values that are not numbers are left out. Empty for an unknown subject.
  [[nodiscard]] SubjectTrend up_to(std::int64_t run) const;
  [[nodiscard]] std::map<std::string, double> figures_of(std::int64_t run) const;

 private:
  std::string subject_;
  std::optional<db::BaselineRecord> baseline_;
  std::vector<db::FigureRecord> records_;
  std::map<std::int64_t, std::int64_t> repeated_, same_seeds_;  // run -> the earlier one
};
// Up to the newest run.
SubjectTrend follow(const db::RunStore& store, const std::string& subject);
// Sets `shifted` by the false discovery rate over all charts of these subjects (false_discovery.h). Constants and
// figures without a chart do not count among them.
void judge_shifts(const std::vector<SubjectTrend*>& family);
// follow() and judge_shifts() with the subject's own figures.
SubjectTrend trend_of_subject(const db::RunStore& store, const std::string& subject);

// Sets `outlier` among the sensors that have the same figure under the same recipes and model, five at least, by the
// rule of a batch page (kOutlierScore) and by more than a tenth of their median.
void mark_outliers(std::vector<SubjectTrend>& sensors);

// "mean_error_psi" -> "mean error", "psi"; "elam_alpha_a1_per_psi" -> "elam alpha a1", "1/psi".
struct FigureLabel {
  std::string name, unit;  // unit empty: a number
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
// What is not judged because the baseline is too short for control charts; empty where it is long enough.
std::string short_baseline(const SubjectTrend& followed);

// The newest values, at most `width`, as a sparkline of blocks; an arrow for one beyond the scale.
std::string sparkline(const std::vector<double>& values, const FigureScale& scale, std::size_t width);

// Converts trends of figures to the unit of pressure of the reader. Stores, JSON and baselines keep psi and the names
// with it.

// A copy with the figures whose names have the unit psi ("mean_error_psi", "hold_drift_psi_per_min", "x_per_psi") in
// `unit`: their names ("mean_error_kpa"), values, bands, averages and slopes. Others are as they were.
SubjectTrend in_unit(SubjectTrend followed, analysis::PressureUnit unit);

}  // namespace tactbench::bench
