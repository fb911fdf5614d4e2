// Figures followed over time: those of a subject (a scenario of the nightly suite, a sensor, a rig) run by run,
// compared with the spread of the runs that were accepted as its baseline.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "analysis/statistics/figures/control_band.h"
#include "db/run_store.h"

namespace tactbench::bench {

struct FollowedFigure {
  std::string name;                // with the unit in it
  std::vector<std::int64_t> runs;  // runs that are not void, in order
  std::vector<double> values;      // value of each run
  std::vector<bool> accepted;      // belongs to the baseline
  // From the baseline's values, each measurement once; none without a baseline of at least three.
  std::optional<analysis::ControlBand> band;
  // Over the newest runs after the baseline: at least kDriftRuns, at most twice as many.
  std::optional<analysis::MonotoneTrend> trend;
  bool missing = false;  // the newest run has none
  bool outside = false;  // the newest run's value is outside the band, or missing
  bool drifts = false;   // a significant monotone trend that exceeds the baseline's own spread
};

inline constexpr int kDriftRuns = 7;
inline constexpr double kDriftChance = 1e-3;  // significance of a trend
inline constexpr double kNightAlarm = 0.01;  // probability that any of the figures judged together is outside by chance

struct Followed {
  std::string subject;
  std::int64_t run = 0;                        // the newest; 0: none
  std::string origin;                          // of that run; runs of another origin are left out
  std::optional<db::BaselineRecord> baseline;  // the newest of the subject
  std::size_t repeated = 0;                    // runs that repeat another one and do not count
  std::vector<FollowedFigure> figures;         // by name
};

// `judged_together`: number of figures that share kNightAlarm; 0: the subject's own. Values that are not numbers are
// left out. Empty for an unknown subject.
Followed follow(const db::RunStore& store, const std::string& subject, std::size_t judged_together = 0);

// One line per figure outside its band, and one per drifting figure.
std::vector<std::string> outside_lines(const Followed& followed);
std::vector<std::string> drift_lines(const Followed& followed);

// The newest values, at most `width`, as a sparkline of blocks. "" where there are none.
std::string sparkline(const std::vector<double>& values, std::size_t width);

}  // namespace tactbench::bench
