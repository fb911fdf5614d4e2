// What is followed over time: the figures of a subject (a scenario of the nightly suite, a sensor, a rig) run by run,
// held against the spread of the runs that someone accepted as its baseline.
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
  std::vector<std::int64_t> runs;  // that are not void, in order, with
  std::vector<double> values;      // what each found
  std::vector<bool> accepted;      // is it one of the baseline's
  // Of the baseline's values, each measurement once; none without a baseline of at least three.
  std::optional<analysis::ControlBand> band;
  // Of the newest runs after the baseline's: at least kDriftRuns, at most twice as many.
  std::optional<analysis::MonotoneTrend> trend;
  bool missing = false;  // the newest run has none
  bool outside = false;  // of the band: the newest run's value; also when that run has none
  bool drifts = false;   // one way, clearer than chance, and by more than the baseline's own spread
};

inline constexpr int kDriftRuns = 7;
inline constexpr double kDriftChance = 1e-3;  // so clear an order comes about by chance
inline constexpr double kNightAlarm = 0.01;   // that any of the figures judged together falls outside by chance

struct Followed {
  std::string subject;
  std::int64_t run = 0;                        // the newest; 0: none
  std::string origin;                          // of that run; runs of another origin are left out
  std::optional<db::BaselineRecord> baseline;  // the newest of the subject
  std::size_t repeated = 0;                    // of its runs, those that repeat another and do not count
  std::vector<FollowedFigure> figures;         // by name
};

// `judged_together`: among how many figures one may fall outside by chance with kNightAlarm; 0: among the subject's
// own. Values that are not numbers are left out. Empty where nothing is known of the subject.
Followed follow(const db::RunStore& store, const std::string& subject, std::size_t judged_together = 0);

// A line about each figure that lies outside, and one about each that drifts.
std::vector<std::string> outside_lines(const Followed& followed);
std::vector<std::string> drift_lines(const Followed& followed);

// The values as a row of blocks, lowest to highest, at most `width` of the newest. "" where there is none.
std::string sparkline(const std::vector<double>& values, std::size_t width);

}  // namespace tactbench::bench
