// The memory of a frame compensator, laid out for vectors: blocks of 16 taxels, one row of 16 for each quantity.
#pragma once

#include <cstddef>
#include <cstdint>
#include <new>
#include <type_traits>
#include <vector>

#include "analysis/compensate/composed_curve.h"
#include "analysis/compensate/options.h"

namespace tactbench::analysis {

inline constexpr std::size_t kLanes = 16;

template <class T>
struct CacheLineAllocator {
  using value_type = T;
  CacheLineAllocator() = default;
  template <class U>
  CacheLineAllocator(const CacheLineAllocator<U>&) {}
  T* allocate(std::size_t n) { return static_cast<T*>(::operator new(n * sizeof(T), std::align_val_t(64))); }
  void deallocate(T* p, std::size_t) { ::operator delete(p, std::align_val_t(64)); }
  bool operator==(const CacheLineAllocator&) const { return true; }
};
template <class T>
using AlignedVector = std::vector<T, CacheLineAllocator<T>>;

// As wide as Real: what a comparison of vectors gives.
template <class Real>
using Whole = std::conditional_t<sizeof(Real) == 4, std::int32_t, std::int64_t>;

// Outputs count from y0 in units of the taxel's noise.
template <class Real>
struct alignas(64) LaneBlock {
  // Constant after a tare.
  Real gain[kLanes], zero[kLanes];  // output = gain * (count - zero): a tare moves whole counts
  Real highest[kLanes];             // of an output within range
  // State, as TaxelCompensator's.
  Real steps[kLanes], mean[kLanes], weight[kLanes], root_weight[kLanes];
  Real extreme[kLanes], extreme_weight[kLanes];
  Real turn[kLanes];  // the extreme less its lead
  Real sign[kLanes];  // 1 rising, -1 falling, 0 not decided
  // The piece of the current curve in which the last means lay; it holds as long as from < mean <= to. Sensitivities
  // are NaN until somebody asked for them.
  Real from[kLanes], to[kLanes], at[kLanes], slope[kLanes], sensitivity[kLanes], reverse_sensitivity[kLanes];
  // The same of the curve back from a turn at back_turn, for outputs behind the extreme.
  Real back_turn[kLanes], back_from[kLanes], back_to[kLanes], back_at[kLanes], back_slope[kLanes];
  // Results.
  Real pressure[kLanes], uncertainty[kLanes];
  Whole<Real> bits[kLanes];
};

// What a frame found out about a taxel beyond plain reading: the first three make an event.
enum LaneEvent : std::uint32_t {
  kLaneTurned = 1,
  kLaneUnfilled = 2,  // a sensitivity is not known yet, or the history
  kLaneStrayed = 4,   // behind the extreme, where the way back is not known yet
  kLaneBack = 8,      // behind the extreme
  kLaneHeld = 16
};

struct LaneEvents {
  std::uint32_t taxel, what;
};

// Of a curve's knots (piece_at's index), and of the two places below and above them all.
template <class Real>
struct KnotSensitivity {
  Real own, reverse;
};

// A piece of the current curve as a lane's rows hold it.
template <class Real>
struct LanePiece {
  Real from, to, at, slope, sensitivity, reverse_sensitivity;
  std::uint32_t index;
};

template <class Real>
struct FrameLanes {
  std::size_t taxels = 0, knots = 0;  // knots: of a pattern
  AlignedVector<LaneBlock<Real>> blocks;
  std::vector<TaxelPattern> patterns;
  std::vector<ComposedCurve> curves;                 // since the last remembered turn
  std::vector<std::uint32_t> pieces;                 // index of the piece in the block's rows
  std::vector<LanePiece<Real>> former;               // the piece before it: noise goes to and fro between two
  std::vector<KnotSensitivity<Real>> sensitivities;  // taxel, knot
  std::vector<LaneEvents> events;                    // room for every taxel
  std::size_t event_count = 0;
  CompensatorOptions options;
  double counts_per_volt = 1.0;
  [[nodiscard]] KnotSensitivity<Real>* sensitivities_of(std::size_t taxel) {
    return sensitivities.data() + taxel * (knots + 3);
  }
  [[nodiscard]] LaneBlock<Real>& block(std::size_t taxel) { return blocks[taxel / kLanes]; }
  [[nodiscard]] const LaneBlock<Real>& block(std::size_t taxel) const { return blocks[taxel / kLanes]; }
  void locate(std::size_t taxel);   // the piece that the mean lies in now
  void look_up(std::size_t taxel);  // the piece's sensitivities: NaN when one of its ends was not asked for yet
};

// One pass over all blocks: follows the outputs, reads the current curves, fills `events`. `samples` are padded to
// whole blocks. Branches only where a group of taxels has one that leaves its piece, starts a mean or lies behind.
template <class Real, class Sample>
using FramePass = void (*)(FrameLanes<Real>& lanes, const Sample* samples);
template <class Real, class Sample>
struct FramePasses {
  static void base(FrameLanes<Real>& lanes, const Sample* samples);
  static void avx2(FrameLanes<Real>& lanes, const Sample* samples);
};

}  // namespace tactbench::analysis
