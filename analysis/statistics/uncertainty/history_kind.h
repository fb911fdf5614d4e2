// Classifies the pressure history of a held-out run by its trajectory alone, not by names of recipes.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "analysis/statistics/figures/history_errors.h"
#include "analysis/statistics/uncertainty/use_condition.h"

namespace tactbench::analysis {

inline constexpr double kHeldLeastS = 5.0;     // a level with several frames over this long is held
inline constexpr double kSmallShare = 0.15;    // of the range: small reversals are no larger in the median, ...
inline constexpr std::size_t kSmallLeast = 5;  // ... and not fewer than this
inline constexpr double kWholeShare = 0.5;     // of the range lies between the turning points of "the whole range"

// Of each step the kind that its frame is evidence for; none: for no kind that has a name.
// - A sequence that holds pressures above the lowest: its frames at held levels are kHeld, the others nothing.
// - Else frames of branches over the whole range are kFullSweeps.
// - Frames of inner branches count once full pressure was reached, before the sequence (`pressed`) or in it. Where half
//   of the inner branches are small, kSmallReversals; where the points at which they turn lie far apart, kReversals.
// low < high: the range, psi.
std::vector<std::optional<UseCondition>> history_kinds(const SequenceData& sequence, double low, double high,
                                                       bool pressed);

// The histories of a run that count, by kind; each is independent of the others. A full sweep is one for each repeat of
// its sequence, of other kinds all repeats are one history, because they go the same way. A sequence with the
// set-points of one of `calibration` is evidence for full sweeps alone: its inner branches are those that models were
// fitted to.
struct KindHistories {
  UseCondition kind = UseCondition::kFullSweeps;
  FrameHistory history;
  double arrival_s = 0.0;  // median time from command to a level's first frame; 0: not stated
  double held_s = 0.0;     // longest time from command to a frame
};
std::vector<KindHistories> kind_histories(const Dataset& run, const FrameErrors& errors, const Dataset& calibration,
                                          double low, double high);

// Of fewer of a kind none can be held against U of the others, and U stays open.
inline constexpr std::size_t kLeastHistories = 2;
// How many histories of each kind a run of the sequences `judged` shows at most, as kind_histories() counts them,
// beside models of `calibration`: known from set-points and times of dwell, before anything is measured. Without a
// calibration the range is that of `judged`.
std::array<std::size_t, kHistoryKinds> planned_histories(const std::vector<SequenceData>& judged,
                                                         const std::vector<SequenceData>& calibration);

// 5 and 95 % quantile of the times from command to a level's first frame, above the lowest level; empty: not stated.
struct ArrivalTimes {
  double low_s = 0.0, high_s = 0.0;
};
std::optional<ArrivalTimes> arrival_times(const Dataset& run);

}  // namespace tactbench::analysis
