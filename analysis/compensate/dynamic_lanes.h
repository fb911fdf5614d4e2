// The memory of a dynamic frame compensator's vector passes: blocks of 16 taxels, one row of 16 for each quantity.
#pragma once

#include <cstddef>
#include <cstdint>

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

// Bits a taxel, one word a block.
struct DynamicBits {
  std::uint16_t events, held;
};

// Marks, for what the pass leaves to scalar code: left the piece, behind the extreme or turned, or a sensitivity is not
// known.
template <class Real>
struct DynamicPasses {
  // Follows the outputs and reads the current pieces. `samples`: counts of this block, as Real.
  static DynamicBits base(DynamicBlock<Real>& b, const Real* samples, const DynamicFrame<Real>& f, Real* outputs);
  static DynamicBits avx2(DynamicBlock<Real>& b, const Real* samples, const DynamicFrame<Real>& f, Real* outputs);
  static DynamicBits avx512(DynamicBlock<Real>& b, const Real* samples, const DynamicFrame<Real>& f, Real* outputs);
  // After the events: undoes the lag, lets creep and lag go on, writes results.
  static void finish_base(DynamicBlock<Real>& b, const DynamicFrame<Real>& f, const Real* outputs,
                          const FrameResults<Real>& results);
  static void finish_avx2(DynamicBlock<Real>& b, const DynamicFrame<Real>& f, const Real* outputs,
                          const FrameResults<Real>& results);
  static void finish_avx512(DynamicBlock<Real>& b, const DynamicFrame<Real>& f, const Real* outputs,
                            const FrameResults<Real>& results);
};

}  // namespace tactbench::analysis
