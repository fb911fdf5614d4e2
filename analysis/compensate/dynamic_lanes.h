// The memory of a dynamic frame compensator's vector passes: blocks of 16 taxels, one row of 16 for each quantity.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "analysis/compensate/dynamic_setup.h"
#include "analysis/compensate/frame_lanes.h"

namespace tactbench::analysis {

// Outputs count from the unloaded one in units of the taxel's noise, creep undone; pressures in psi from the lowest.
// All rows are of Real: a block is an array of rows.
template <class Real>
struct alignas(64) DynamicBlock {
  // Constant, or changed by events: above zero = gain * (count - zero); the divider's c; the taxel's creep and lag.
  Real gain[kLanes], zero[kLanes], divider[kLanes], highest[kLanes], creep_scale[kLanes], lag_share[kLanes];
  Real steepest[kLanes];  // slope by which the creep's target is guessed, at most
  Real rising[kLanes];    // 1, or -1 since a turn to falling
  // As DynamicTaxelCompensator's.
  Real steps[kLanes], mean[kLanes], weight[kLanes], extreme[kLanes], extreme_weight[kLanes], turn[kLanes];
  Real psi[kCreepElements][kLanes], late[kLanes];
  // The last reading: pressure that had arrived, its slope in psi an output (at most `steepest`), that output, 1 / its
  // creep factor.
  Real last_x[kLanes], last_slope[kLanes], last_mean[kLanes], last_share[kLanes];
  // The piece of the current branch, in linearised outputs: holds for low <= u <= high. `reverse`: the sensitivity of
  // the branch back from the extreme, NaN until needed.
  Real low[kLanes], high[kLanes], u[kLanes], x[kLanes], slope[kLanes], reverse[kLanes];
  Real residual[kLanes];  // psi, of the model in this piece
  // What that is made of: the taxel's scale, and the part for a gain that was corrected, psi an interval.
  Real residual_scale[kLanes], doubted[kLanes];
  // Of the frame: own sensitivity to outputs, and results, kept for frames that are lost.
  Real pressure[kLanes], uncertainty[kLanes];
};

// What all taxels share in a frame.
template <class Real>
struct DynamicFrame {
  Real moving, jump2, least, band2, rest2, hold2, lead, flat, band;
  Real half, span, lowest;
  // For the seconds since the frame before.
  Real creep_new = 0, creep_all = 0;                      // sums of k (1 - e), and of k
  Real creep_kept[kCreepElements], kept[kCreepElements];  // k e, e
  Real lag_kept = 1;
};

// Of a lane, from the pass: `kEvent` for what it leaves to scalar code: left the piece, behind the extreme or turned,
// or a sensitivity is not known.
inline constexpr int kEvent = 1, kHeld = 2, kBack = 4, kTurned = 8;
template <class Real>
using DynamicMark = std::conditional_t<sizeof(Real) == 4, std::int32_t, std::int64_t>;

// Branches of a block's lanes whose pieces are to be found: a corner, where the branch ends, and the linearised output.
template <class Real>
struct alignas(64) DynamicSearch {
  DynamicMark<Real> wanted[kLanes] = {};  // 0: the lane stays as it is
  Real rises[kLanes] = {}, x[kLanes] = {}, u[kLanes] = {}, end[kLanes] = {}, at[kLanes] = {};
  // Of a lane that turned: where, in intervals, if the piece until then has it (turn_known).
  Real turn_x[kLanes] = {}, turn_u[kLanes] = {};
  DynamicMark<Real> turn_known[kLanes] = {}, outside[kLanes] = {};  // the lane's output is outside its piece
  std::int32_t table[kLanes] = {};                                  // where the taxel's begins
};

// What it is searched in, of all taxels.
template <class Real>
struct DynamicTables {
  const Real *everett, *residuals;  // residuals null: none
  std::int32_t intervals, first_step;
  Real per_interval, span;
};

template <class Real>
struct DynamicPasses {
  using Mark = DynamicMark<Real>;
  // Follows the outputs and reads the current pieces. `samples`: counts of this block, as Real. Returns a bit a lane:
  // whether it has an event.
  static unsigned base(DynamicBlock<Real>& b, const Real* samples, const DynamicFrame<Real>& f, Real* outputs,
                       Mark* marks);
  static unsigned avx2(DynamicBlock<Real>& b, const Real* samples, const DynamicFrame<Real>& f, Real* outputs,
                       Mark* marks);
  static unsigned avx512(DynamicBlock<Real>& b, const Real* samples, const DynamicFrame<Real>& f, Real* outputs,
                         Mark* marks);
  // What a turn does to a lane but for its memory, and which outputs are outside their pieces. For known histories.
  static void turn_base(DynamicBlock<Real>& b, const Mark* marks, Real lead, Real intervals_per,
                        DynamicSearch<Real>& s);
  static void turn_avx2(DynamicBlock<Real>& b, const Mark* marks, Real lead, Real intervals_per,
                        DynamicSearch<Real>& s);
  static void turn_avx512(DynamicBlock<Real>& b, const Mark* marks, Real lead, Real intervals_per,
                          DynamicSearch<Real>& s);
  // As State::locate for all lanes that are wanted, and their readings.
  static void locate_base(DynamicBlock<Real>& b, const DynamicSearch<Real>& s, const DynamicTables<Real>& t);
  static void locate_avx2(DynamicBlock<Real>& b, const DynamicSearch<Real>& s, const DynamicTables<Real>& t);
  static void locate_avx512(DynamicBlock<Real>& b, const DynamicSearch<Real>& s, const DynamicTables<Real>& t);
  // After the events: undoes the lag, lets creep and lag go on, writes results.
  static void finish_base(DynamicBlock<Real>& b, const DynamicFrame<Real>& f, const Real* outputs,
                          const FrameResults<Real>& results);
  static void finish_avx2(DynamicBlock<Real>& b, const DynamicFrame<Real>& f, const Real* outputs,
                          const FrameResults<Real>& results);
  static void finish_avx512(DynamicBlock<Real>& b, const DynamicFrame<Real>& f, const Real* outputs,
                            const FrameResults<Real>& results);
};

}  // namespace tactbench::analysis
