// The memory of a frame compensator's vector pass: blocks of 16 taxels, one row of 16 for each quantity.
#pragma once

#include <cstddef>
#include <cstdint>
#include <new>
#include <type_traits>
#include <vector>

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

// Outputs count from y0 in units of the taxel's noise, and from the last turn on in the direction that the output has
// since then: a lane always rises, on a falling curve its rows hold the negated outputs. Then no decision needs the
// noise or the direction.
template <class Real>
struct alignas(64) LaneBlock {
  // Constant between turns.
  Real gain[kLanes], zero[kLanes];       // output = gain * (count - zero): a tare moves whole counts
  Real lowest[kLanes], highest[kLanes];  // of an output within range
  // State, as TaxelCompensator's.
  Real steps[kLanes], mean[kLanes], weight[kLanes];  // weight: 1 / the samples in the mean
  Real extreme[kLanes], extreme_weight[kLanes];
  Real turn[kLanes];  // the extreme less its lead
  // The piece of the current curve in which the last means lay; it holds as long as low <= mean <= high. `worst` is the
  // larger one of the piece's own sensitivity and the reverse one. NaN until needed.
  Real low[kLanes], high[kLanes], origin[kLanes], at[kLanes], slope[kLanes], own[kLanes], worst[kLanes];
  Real residual2[kLanes];  // of the model there, psi squared
  // The last results, for frames that are lost.
  Real pressure[kLanes], uncertainty[kLanes];
};

// CompensatorOptions in the form of the loop.
template <class Real>
struct FrameLimits {
  Real moving, jump2, least, band2, rest2, hold2, lead, flat, counts_per_volt;
  // Values that the loop computes from a mean's weight, as tables by the number of its samples where the longest mean
  // has 8: its lowest three or four bits are the index. The same bits as computed.
  bool has_tables = false;
  alignas(64) Real jumps2[16] = {}, step_weights[16] = {};  // of that mean: 1 + and 1 - half its weight
  alignas(64) Real next_weights[16] = {}, next_roots[16] = {}, next_leads[16] = {};  // of one with a sample more

  FrameLimits() = default;
  FrameLimits(const CompensatorOptions& o, double volts_per_count);
  // The highest of means lies too high by this; root: of the weight.
  [[nodiscard]] Real lead_of(Real weight, Real root) const { return lead * root * (Real(1) - weight); }
};

// One bit a taxel.
template <class Bits>
struct LaneBits {
  Bits events;  // has left its piece, lies behind the extreme or has turned, or a sensitivity is not known
  Bits held;    // so near to the extreme that it may have turned
  Bits lost;    // the sample was not a number: state and results are as before
};

// Destination of the results: whole blocks.
template <class Real>
struct FrameResults {
  Real* pressure;
  Real* uncertainty;
  std::uint16_t* status;
};

template <class Real>
struct FrameLanes {
  AlignedVector<LaneBlock<Real>> blocks;
  LaneBits<std::vector<std::uint16_t>> bits;  // one a block, and up to three at the end that stay 0
  FrameLimits<Real> limits;
};

// One pass over all blocks, without a branch that depends on a sample: follows the outputs, reads the current pieces,
// and marks the taxels whose results need further work. `samples` are whole blocks.
template <class Real, class Sample>
using FramePass = void (*)(FrameLanes<Real>& lanes, const Sample* samples, const FrameResults<Real>& results);
template <class Real, class Sample>
struct FramePasses {
  static void base(FrameLanes<Real>& lanes, const Sample* samples, const FrameResults<Real>& results);
  static void avx2(FrameLanes<Real>& lanes, const Sample* samples, const FrameResults<Real>& results);
  static void avx512(FrameLanes<Real>& lanes, const Sample* samples, const FrameResults<Real>& results);
};

}  // namespace tactbench::analysis
