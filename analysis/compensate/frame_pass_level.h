// One vector level of the frame pass. frame_pass.cpp includes it once for each, and defines the level's name, the bytes
// of its vectors and the target of its functions; hence no include guard.

#define TACTBENCH_PASS_INLINE TACTBENCH_PASS_TARGET __attribute__((always_inline)) static

namespace tactbench::analysis {
namespace {
namespace TACTBENCH_PASS_LEVEL {

// Vector types of GCC and clang, and intrinsics for operations that they lack.
template <class Real>
struct Vectors {
  typedef Real V __attribute__((vector_size(TACTBENCH_PASS_BYTES), may_alias));
  static constexpr std::size_t kWidth = TACTBENCH_PASS_BYTES / sizeof(Real);
  static constexpr bool kFloat = sizeof(Real) == 4;
  typedef std::uint16_t Status __attribute__((vector_size(2 * kWidth), aligned(2), may_alias));
#if TACTBENCH_PASS_BYTES == 64
  using Mask = std::conditional_t<kFloat, __mmask16, __mmask8>;
  TACTBENCH_PASS_INLINE Mask less(V a, V b) {
    if constexpr (kFloat) return _mm512_cmp_ps_mask(a, b, _CMP_LT_OQ);
    if constexpr (!kFloat) return _mm512_cmp_pd_mask(a, b, _CMP_LT_OQ);
  }
  TACTBENCH_PASS_INLINE Mask at_most(V a, V b) {
    if constexpr (kFloat) return _mm512_cmp_ps_mask(a, b, _CMP_LE_OQ);
    if constexpr (!kFloat) return _mm512_cmp_pd_mask(a, b, _CMP_LE_OQ);
  }
  TACTBENCH_PASS_INLINE Mask both(Mask a, Mask b) { return static_cast<Mask>(a & b); }
  TACTBENCH_PASS_INLINE Mask either(Mask a, Mask b) { return static_cast<Mask>(a | b); }
  TACTBENCH_PASS_INLINE Mask only(Mask a, Mask not_b) { return static_cast<Mask>(a & ~not_b); }
  TACTBENCH_PASS_INLINE Mask no(Mask a) { return static_cast<Mask>(~a); }
  TACTBENCH_PASS_INLINE V choose(Mask mask, V yes, V no) {
    if constexpr (kFloat) return _mm512_mask_blend_ps(mask, no, yes);
    if constexpr (!kFloat) return _mm512_mask_blend_pd(mask, no, yes);
  }
  TACTBENCH_PASS_INLINE V root(V value) {
    if constexpr (kFloat) return _mm512_mask_sqrt_ps(value, 0xFFFF, value);  // without the mask GCC 12 warns
    if constexpr (!kFloat) return _mm512_mask_sqrt_pd(value, 0xFF, value);
  }
  TACTBENCH_PASS_INLINE V larger(V a, V b) {
    if constexpr (kFloat) return _mm512_maskz_max_ps(0xFFFF, a, b);
    if constexpr (!kFloat) return _mm512_maskz_max_pd(0xFF, a, b);
  }
  TACTBENCH_PASS_INLINE V smaller(V a, V b) {
    if constexpr (kFloat) return _mm512_maskz_min_ps(0xFFFF, a, b);
    if constexpr (!kFloat) return _mm512_maskz_min_pd(0xFF, a, b);
  }
  TACTBENCH_PASS_INLINE unsigned bits(Mask mask) { return mask; }
  TACTBENCH_PASS_INLINE Status status(Mask outside, Mask flat) {
    if constexpr (kFloat) {
      const __m256i range = _mm256_mask_set1_epi16(_mm256_set1_epi16(kTaxelValid), outside, kTaxelOutOfRange);
      return reinterpret_cast<Status>(range | _mm256_maskz_set1_epi16(flat, kTaxelFlat));
    } else {
      const __m128i range = _mm_mask_set1_epi16(_mm_set1_epi16(kTaxelValid), outside, kTaxelOutOfRange);
      return reinterpret_cast<Status>(range | _mm_maskz_set1_epi16(flat, kTaxelFlat));
    }
  }
#else
  typedef Whole<Real> Mask __attribute__((vector_size(TACTBENCH_PASS_BYTES), may_alias));
  TACTBENCH_PASS_INLINE Mask less(V a, V b) { return a < b; }
  TACTBENCH_PASS_INLINE Mask at_most(V a, V b) { return a <= b; }
  TACTBENCH_PASS_INLINE Mask both(Mask a, Mask b) { return a & b; }
  TACTBENCH_PASS_INLINE Mask either(Mask a, Mask b) { return a | b; }
  TACTBENCH_PASS_INLINE Mask only(Mask a, Mask not_b) { return a & ~not_b; }
  TACTBENCH_PASS_INLINE Mask no(Mask a) { return ~a; }
  TACTBENCH_PASS_INLINE V choose(Mask mask, V yes, V no) { return mask ? yes : no; }
  TACTBENCH_PASS_INLINE Mask whole(int value) { return Mask{} + static_cast<Whole<Real> >(value); }
  TACTBENCH_PASS_INLINE Status status(Mask outside, Mask flat) {
    return __builtin_convertvector(
        (outside ? whole(kTaxelOutOfRange) : whole(kTaxelValid)) | (flat & whole(kTaxelFlat)), Status);
  }
#if TACTBENCH_PASS_BYTES == 32
  TACTBENCH_PASS_INLINE V root(V value) {
    if constexpr (kFloat) return _mm256_sqrt_ps(value);
    if constexpr (!kFloat) return _mm256_sqrt_pd(value);
  }
  TACTBENCH_PASS_INLINE V larger(V a, V b) {
    if constexpr (kFloat) return _mm256_max_ps(a, b);
    if constexpr (!kFloat) return _mm256_max_pd(a, b);
  }
  TACTBENCH_PASS_INLINE V smaller(V a, V b) {
    if constexpr (kFloat) return _mm256_min_ps(a, b);
    if constexpr (!kFloat) return _mm256_min_pd(a, b);
  }
  TACTBENCH_PASS_INLINE unsigned bits(Mask mask) {
    if constexpr (kFloat) return static_cast<unsigned>(_mm256_movemask_ps(reinterpret_cast<__m256>(mask)));
    if constexpr (!kFloat) return static_cast<unsigned>(_mm256_movemask_pd(reinterpret_cast<__m256d>(mask)));
  }
#elif defined(__x86_64__)
  TACTBENCH_PASS_INLINE V root(V value) {
    if constexpr (kFloat) return _mm_sqrt_ps(value);
    if constexpr (!kFloat) return _mm_sqrt_pd(value);
  }
  TACTBENCH_PASS_INLINE V larger(V a, V b) {
    if constexpr (kFloat) return _mm_max_ps(a, b);
    if constexpr (!kFloat) return _mm_max_pd(a, b);
  }
  TACTBENCH_PASS_INLINE V smaller(V a, V b) {
    if constexpr (kFloat) return _mm_min_ps(a, b);
    if constexpr (!kFloat) return _mm_min_pd(a, b);
  }
  TACTBENCH_PASS_INLINE unsigned bits(Mask mask) {
    if constexpr (kFloat) return static_cast<unsigned>(_mm_movemask_ps(reinterpret_cast<__m128>(mask)));
    if constexpr (!kFloat) return static_cast<unsigned>(_mm_movemask_pd(reinterpret_cast<__m128d>(mask)));
  }
#else
  TACTBENCH_PASS_INLINE V root(V value) {
    for (std::size_t i = 0; i < kWidth; ++i) value[i] = std::sqrt(value[i]);
    return value;
  }
  TACTBENCH_PASS_INLINE V larger(V a, V b) { return a > b ? a : b; }
  TACTBENCH_PASS_INLINE V smaller(V a, V b) { return a < b ? a : b; }
  TACTBENCH_PASS_INLINE unsigned bits(Mask mask) {
    unsigned found = 0;
    for (std::size_t i = 0; i < kWidth; ++i) found |= (mask[i] != 0 ? 1U : 0U) << i;
    return found;
  }
#endif
#endif
  // Table entries of means by their weights: the reciprocal is rounded to a whole number, however rough it was.
#if TACTBENCH_PASS_BYTES == 64
  TACTBENCH_PASS_INLINE __m512i samples(V weight) {
    return _mm512_maskz_cvtps_epi32(0xFFFF, _mm512_maskz_rcp14_ps(0xFFFF, weight));
  }
  TACTBENCH_PASS_INLINE V entry(V table, __m512i at) { return _mm512_maskz_permutexvar_ps(0xFFFF, at, table); }
#elif TACTBENCH_PASS_BYTES == 32
  TACTBENCH_PASS_INLINE __m256i samples(V weight) { return _mm256_cvtps_epi32(_mm256_rcp_ps(weight)); }
  TACTBENCH_PASS_INLINE V entry(V table, __m256i at) { return _mm256_permutevar8x32_ps(table, at); }
#endif
  TACTBENCH_PASS_INLINE V all(Real value) { return V{} + value; }
  TACTBENCH_PASS_INLINE V load(const Real* row) { return *reinterpret_cast<const V*>(row); }
  TACTBENCH_PASS_INLINE void store(Real* row, V value) { *reinterpret_cast<V*>(row) = value; }
};

// kTables: FrameLimits's are read instead of divisions and roots; the same bits.
template <class Real, class Sample, bool kTables>
struct Pass : Vectors<Real> {
  using Base = Vectors<Real>;
  using Base::all, Base::at_most, Base::both, Base::choose, Base::either, Base::kWidth, Base::larger, Base::less,
      Base::load, Base::no, Base::only, Base::store;
  using typename Base::Mask, typename Base::V;
  typedef Sample Samples __attribute__((vector_size(kWidth * sizeof(Sample)), aligned(alignof(Sample)), may_alias));
  typedef std::int32_t Counts __attribute__((vector_size(kWidth * 4)));
  typedef std::uint32_t Bits __attribute__((vector_size(TACTBENCH_PASS_BYTES)));
  typedef Real Results __attribute__((vector_size(TACTBENCH_PASS_BYTES), aligned(alignof(Real)), may_alias));

  // FrameLimits, in registers.
  struct Limits {
    V moving, jump2, least, band2, rest2, hold2, lead, flat, counts_per_volt;
    V jumps2, step_weights, next_weights, next_roots, next_leads;
  };
  TACTBENCH_PASS_INLINE Limits limits_of(const FrameLimits<Real>& o) {
    return {all(o.moving),        all(o.jump2),         all(o.least),       all(o.band2),           all(o.rest2),
            all(o.hold2),         all(o.lead),          all(o.flat),        all(o.counts_per_volt), load(o.jumps2),
            load(o.step_weights), load(o.next_weights), load(o.next_roots), load(o.next_leads)};
  }

  // One vector of taxels, from the row's element `at` on: TaxelCompensator's follow, turn_when_beyond and read.
  TACTBENCH_PASS_INLINE void step(LaneBlock<Real>& b, std::size_t at, LaneBits<unsigned>& found, const Limits& o,
                                  const Sample* from, const FrameResults<Real>& results) {
    const V one = all(1), zero = all(0), counts = counts_of(from, o);
    const V y = load(b.gain + at) * (counts - load(b.zero + at));
    const V weight0 = load(b.weight + at), mean0 = load(b.mean + at), steps0 = load(b.steps + at);
    const V off = y - mean0, off2 = off * off;
    V jump2, step, weight, root_weight, lead;
    if constexpr (kTables) {
      const auto samples = Base::samples(weight0);
      jump2 = Base::entry(o.jumps2, samples);
      step = off2 * Base::entry(o.step_weights, samples);
      weight = Base::entry(o.next_weights, samples);
      root_weight = Base::entry(o.next_roots, samples);
      lead = Base::entry(o.next_leads, samples);
    } else {
      jump2 = o.jump2 * (one + weight0);
      step = off2 * (one - all(Real(0.5)) * weight0);
      weight = larger(weight0 / (one + weight0), o.least);
      root_weight = Base::root(weight);
      lead = o.lead * root_weight * (one - weight);
    }
    const Mask jumps = either(less(o.moving, steps0), less(jump2, off2));
    const V steps = steps0 + (Base::smaller(all(Real(kStepCeiling)), step) - steps0) * all(Real(1.0 / kStepWindow));
    const V mean = choose(jumps, y, mean0 + weight * off);
    weight = choose(jumps, one, weight);
    root_weight = choose(jumps, one, root_weight);
    lead = choose(jumps, zero, lead);

    const V extreme0 = load(b.extreme + at), extreme_weight0 = load(b.extreme_weight + at), turn0 = load(b.turn + at);
    const V ahead = larger(zero, mean - extreme0), behind = larger(zero, turn0 - mean);
    const V behind2 = behind * behind, wider = larger(weight, extreme_weight0), hold = o.hold2 * wider;
    const Mask held = at_most(ahead * ahead, hold);
    const Mask rested = both(both(at_most(weight, o.least), less(weight, extreme_weight0)),
                             both(at_most(behind2, o.rest2), at_most(behind2, o.band2 * wider)));
    const Mask taken = either(at_most(extreme0, mean), rested);

    const V pressure = load(b.at + at) + load(b.slope + at) * (mean - load(b.origin + at));
    const V sensitivity = choose(held, load(b.worst + at), load(b.own + at)), noise = root_weight * sensitivity;
    const V uncertainty = near_root(noise * noise + load(b.residual2 + at));
    const Mask outside = either(less(y, load(b.lowest + at)), less(load(b.highest + at), y));
    // A turn lies further behind than the held zone, and a NaN is not at most itself.
    const Mask fits = both(both(at_most(load(b.low + at), mean), at_most(mean, load(b.high + at))),
                           at_most(sensitivity, sensitivity));
    Mask event = either(no(fits), only(less(hold, behind2), taken));

    Mask number{};
    if constexpr (!std::is_integral_v<Sample>) {
      number = at_most(counts * counts, all(static_cast<Real>(kMostOutput * kMostOutput)));
      event = both(event, number);
      found.lost |= Base::bits(no(number)) << at;
    }
    const auto keep = [&](Real * row, V value) TACTBENCH_PASS_TARGET __attribute__((always_inline)) {
      if constexpr (!std::is_integral_v<Sample>) value = choose(number, value, load(row + at));
      store(row + at, value);
      return value;
    };
    keep(b.steps, steps);
    keep(b.mean, mean);
    keep(b.weight, weight);
    keep(b.extreme, choose(taken, mean, extreme0));
    keep(b.extreme_weight, choose(taken, weight, extreme_weight0));
    keep(b.turn, choose(taken, mean - lead, turn0));
    *reinterpret_cast<Results*>(results.pressure + at) = keep(b.pressure, pressure);
    *reinterpret_cast<Results*>(results.uncertainty + at) = keep(b.uncertainty, uncertainty);
    *reinterpret_cast<typename Base::Status*>(results.status + at) = Base::status(outside, less(o.flat, noise));
    found.events |= Base::bits(event) << at;
    found.held |= Base::bits(held) << at;
  }

  // To 5e-6 of itself in float, by Newton's steps on the inverse root, which cost half of what the processor's root
  // does.
  TACTBENCH_PASS_INLINE V near_root(V square) {
    if constexpr (sizeof(Real) == 4) {
      const V half = all(Real(0.5)) * square, most = all(Real(1.5));
      V inverse = reinterpret_cast<V>(0x5f375a86U - (reinterpret_cast<Bits>(square) >> 1));
      inverse *= most - half * inverse * inverse;
      inverse *= most - half * inverse * inverse;
      return square * inverse;
    } else {
      return Base::root(square);
    }
  }

  TACTBENCH_PASS_INLINE V counts_of(const Sample* from, const Limits& o) {
    const Samples some = *reinterpret_cast<const Samples*>(from);
    if constexpr (std::is_integral_v<Sample>)
      return __builtin_convertvector(__builtin_convertvector(some, Counts), V);
    else
      return some * o.counts_per_volt;
  }

  TACTBENCH_PASS_INLINE void run(FrameLanes<Real>& lanes, const Sample* samples, FrameResults<Real> results) {
    const Limits limits = limits_of(lanes.limits);
    std::uint16_t *events = lanes.bits.events.data(), *held = lanes.bits.held.data(), *lost = lanes.bits.lost.data();
    for (LaneBlock<Real>& block : lanes.blocks) {
      LaneBits<unsigned> found{0, 0, 0};
      for (std::size_t at = 0; at < kLanes; at += kWidth) step(block, at, found, limits, samples + at, results);
      *events++ = static_cast<std::uint16_t>(found.events);
      *held++ = static_cast<std::uint16_t>(found.held);
      if constexpr (!std::is_integral_v<Sample>) *lost++ = static_cast<std::uint16_t>(found.lost);
      samples += kLanes;
      results = {results.pressure + kLanes, results.uncertainty + kLanes, results.status + kLanes};
    }
  }
};

}  // namespace TACTBENCH_PASS_LEVEL
}  // namespace

template <class Real, class Sample>
TACTBENCH_PASS_TARGET void FramePasses<Real, Sample>::TACTBENCH_PASS_LEVEL(FrameLanes<Real>& lanes,
                                                                           const Sample* samples,
                                                                           const FrameResults<Real>& results) {
  // The name of the level's namespace is the function's, too.
  if constexpr (sizeof(Real) == 4 && TACTBENCH_PASS_BYTES > 16) {
    if (lanes.limits.has_tables)
      return analysis::TACTBENCH_PASS_LEVEL::Pass<Real, Sample, true>::run(lanes, samples, results);
  }
  analysis::TACTBENCH_PASS_LEVEL::Pass<Real, Sample, false>::run(lanes, samples, results);
}

}  // namespace tactbench::analysis

#undef TACTBENCH_PASS_INLINE
