#include <algorithm>
#include <cmath>
#include <cstring>
#include <type_traits>

#include "analysis/compensate/frame_compensator.h"
#include "analysis/compensate/frame_lanes.h"

// Vectors as GCC and clang have them: one source for 16 and 32 bytes. They stay inside the pass (all is inlined into
// it), hence the ABI of wide vectors does not matter. No contraction to fused multiply-add: the same bits on each. GCC
// 12 takes compares of 64 bytes apart, AVX-512 would be slower.

#define TACTBENCH_INLINED __attribute__((always_inline))

namespace tactbench::analysis {
namespace {

constexpr double kUniform = 0.28867513459481288;  // 1 / sqrt(12): what lies anywhere within 1

template <class Real, class Sample, int kBytes>
struct Pass {
  typedef Real V __attribute__((vector_size(kBytes), may_alias));
  typedef Whole<Real> I __attribute__((vector_size(kBytes), may_alias));
  static constexpr std::size_t kWidth = kBytes / sizeof(Real);
  typedef Sample Samples __attribute__((vector_size(kWidth * sizeof(Sample)), aligned(alignof(Sample)), may_alias));

  static TACTBENCH_INLINED V all(double value) { return V{} + static_cast<Real>(value); }
  static TACTBENCH_INLINED V load(const Real* row) { return *reinterpret_cast<const V*>(row); }
  static TACTBENCH_INLINED void store(Real* row, V value) { *reinterpret_cast<V*>(row) = value; }
  static TACTBENCH_INLINED I whole(std::uint32_t bits) { return I{} + static_cast<Whole<Real>>(bits); }

  // The options as the loop wants them, made once a frame.
  struct Limits {
    V moving, jump2, least, band, band2, rest2, hold2, lead, flat, counts_per_volt;
    explicit TACTBENCH_INLINED Limits(const FrameLanes<Real>& lanes) {
      const CompensatorOptions& o = lanes.options;
      moving = all(o.moving);
      jump2 = all(o.jump_in_noises * o.jump_in_noises);
      least = all(1.0 / o.longest_mean);
      band = all(-o.band_in_noises);
      band2 = all(o.band_in_noises * o.band_in_noises);
      rest2 = all(o.rest_in_noises * o.rest_in_noises);
      hold2 = all(o.hold_in_noises * o.hold_in_noises);
      lead = all(o.lead_in_noises);
      flat = all(o.flat_psi / o.flat_in_noises);
      counts_per_volt = all(lanes.counts_per_volt);
    }
  };

  static TACTBENCH_INLINED V root(V value) {
    for (std::size_t i = 0; i < kWidth; ++i) value[i] = std::sqrt(value[i]);
    return value;
  }
  static TACTBENCH_INLINED bool any(I mask) {
    std::uint64_t words[kBytes / 8], some = 0;
    std::memcpy(words, &mask, sizeof mask);
    for (const std::uint64_t word : words) some |= word;
    return some != 0;
  }

  // One vector of taxels: TaxelCompensator's follow, turn_when_beyond and read.
  static TACTBENCH_INLINED void step(FrameLanes<Real>& lanes, std::size_t taxel, const Sample* samples,
                                     const Limits& o) {
    LaneBlock<Real>& b = lanes.blocks[taxel / kLanes];
    const std::size_t at = taxel % kLanes;
    const V zero = all(0.0), one = all(1.0), ceiling = all(kStepCeiling);
    V counts = __builtin_convertvector(*reinterpret_cast<const Samples*>(samples + taxel), V);
    if constexpr (!std::is_integral_v<Sample>) counts *= o.counts_per_volt;
    const V y = load(b.gain + at) * (counts - load(b.zero + at));
    const V weight0 = load(b.weight + at), mean0 = load(b.mean + at), steps0 = load(b.steps + at);
    const V off = y - mean0, off2 = off * off, step = off2 * (one - all(0.5) * weight0);
    const I jumps = (steps0 > o.moving) | (off2 > o.jump2 * (one + weight0));
    store(b.steps + at, steps0 + ((step < ceiling ? step : ceiling) - steps0) * all(1.0 / kStepWindow));
    V weight = weight0, root_weight = load(b.root_weight + at);
    if (any((jumps & (weight0 != one)) | (~jumps & (weight0 > o.least)))) {
      const V shared = weight0 / (one + weight0);
      weight = jumps ? one : (shared > o.least ? shared : o.least);
      root_weight = root(weight);
      store(b.weight + at, weight);
      store(b.root_weight + at, root_weight);
    }
    const V mean = jumps ? y : mean0 + weight * off;
    store(b.mean + at, mean);

    const V sign = load(b.sign + at), extreme0 = load(b.extreme + at), extreme_weight0 = load(b.extreme_weight + at);
    const V turn0 = load(b.turn + at), ahead = sign * (mean - extreme0), behind = sign * (turn0 - mean);
    const V behind2 = behind > zero ? behind * behind : zero;
    const V wider = weight > extreme_weight0 ? weight : extreme_weight0;
    const I turned = (ahead < zero) & (behind2 > o.band2 * wider);
    const I rested = (ahead < zero) & ~turned & (weight <= o.least) & (extreme_weight0 > weight) & (behind2 <= o.rest2);
    const I taken = ((ahead >= zero) & (sign != zero)) | rested;
    const I held = (ahead <= zero) | (ahead * ahead <= o.hold2 * wider);
    const V lead = o.lead * root_weight * (one - weight);
    const V turn = taken ? mean - sign * lead : turn0, extreme_weight = taken ? weight : extreme_weight0;
    store(b.extreme + at, taken ? mean : extreme0);
    store(b.extreme_weight + at, extreme_weight);
    store(b.turn + at, turn);

    const V after = sign * (turn - mean), widest = weight > extreme_weight ? weight : extreme_weight;
    const I back = (after > zero) & (after * after > o.hold2 * widest);
    const V from = load(b.from + at), own = load(b.sensitivity + at), reverse = load(b.reverse_sensitivity + at);
    const V pressure = load(b.at + at) + load(b.slope + at) * (mean - from);
    const V uncertainty = root_weight * ((held & (reverse > own)) ? reverse : own);
    const I outside = (y < o.band) | (y > load(b.highest + at));
    const I bits = outside ? whole(kTaxelOutOfRange) : whole(kTaxelValid);
    store(b.pressure + at, pressure);
    store(b.uncertainty + at, uncertainty);
    *reinterpret_cast<I*>(b.bits + at) = bits | ((uncertainty > o.flat) & whole(kTaxelFlat));
    const I left = ~((mean > from) & (mean <= load(b.to + at))) & ~turned;
    const I unfilled = (own != own) | (held & (reverse != reverse));
    if (any(left | turned | unfilled | back)) read_again(lanes, taxel, mean, turn, bits, left, turned, held, back, o);
  }

  // Where one has left its piece, turned, or lies behind the extreme.
  static TACTBENCH_INLINED void read_again(FrameLanes<Real>& lanes, std::size_t taxel, V mean, V turn, I bits, I left,
                                           I turned, I held, I back, const Limits& o) {
    LaneBlock<Real>& b = lanes.blocks[taxel / kLanes];
    const std::size_t at = taxel % kLanes;
    Whole<Real> out[kWidth];
    std::memcpy(out, &left, sizeof left);
    for (std::size_t i = 0; i < kWidth; ++i)
      if (out[i] != 0) lanes.locate(taxel + i);
    const V own = load(b.sensitivity + at), reverse = load(b.reverse_sensitivity + at);
    const V here = load(b.at + at) + load(b.slope + at) * (mean - load(b.from + at));
    const V noise = load(b.root_weight + at) * ((held & (reverse > own)) ? reverse : own);
    const V from = load(b.back_from + at), there = load(b.back_at + at) + load(b.back_slope + at) * (mean - from);
    const I known = (turn == load(b.back_turn + at)) & (mean > from) & (mean <= load(b.back_to + at));
    const V doubt = (there - here) * all(kUniform);
    store(b.pressure + at, (back & known) ? there : here);
    store(b.uncertainty + at, (back & known) ? root(noise * noise + doubt * doubt) : noise);
    *reinterpret_cast<I*>(b.bits + at) = bits | ((noise > o.flat) & whole(kTaxelFlat));
    const I unfilled = (own != own) | (held & (reverse != reverse));
    const I event =
        (turned & whole(kLaneTurned)) | (unfilled & whole(kLaneUnfilled)) | (back & ~known & whole(kLaneStrayed));
    if (!any(event)) return;
    const I found = event | (back & whole(kLaneBack)) | (held & whole(kLaneHeld));
    std::memcpy(out, &found, sizeof found);
    for (std::size_t i = 0; i < kWidth; ++i)
      if ((out[i] & (kLaneTurned | kLaneUnfilled | kLaneStrayed)) != 0)
        lanes.events[lanes.event_count++] = {static_cast<std::uint32_t>(taxel + i), static_cast<std::uint32_t>(out[i])};
  }

  static TACTBENCH_INLINED void run(FrameLanes<Real>& lanes, const Sample* samples) {
    const Limits limits(lanes);
    const std::size_t padded = lanes.blocks.size() * kLanes;
    lanes.event_count = 0;
    for (std::size_t taxel = 0; taxel < padded; taxel += kWidth) step(lanes, taxel, samples, limits);
  }
};

}  // namespace

template <class Real, class Sample>
void FramePasses<Real, Sample>::base(FrameLanes<Real>& lanes, const Sample* samples) {
  Pass<Real, Sample, 16>::run(lanes, samples);
}

#if defined(__x86_64__)
template <class Real, class Sample>
[[gnu::target("avx2")]] void FramePasses<Real, Sample>::avx2(FrameLanes<Real>& lanes, const Sample* samples) {
  Pass<Real, Sample, 32>::run(lanes, samples);
}
#else
template <class Real, class Sample>
void FramePasses<Real, Sample>::avx2(FrameLanes<Real>& lanes, const Sample* samples) {
  base(lanes, samples);
}
#endif

template struct FramePasses<float, std::uint16_t>;
template struct FramePasses<double, std::uint16_t>;
template struct FramePasses<float, float>;
template struct FramePasses<double, double>;

}  // namespace tactbench::analysis
