/* The compensator in integers, first part: arithmetic, noise, direction. C99 and C++11; no library, no allocation. What
 * a device compiles and what `tactbench compensate --as fixed` runs; words and order of steps:
 * analysis/export/README.md. */
#ifndef TB_FIXED_H
#define TB_FIXED_H

#include <stdint.h> /* NOLINT(modernize-deprecated-headers): C reads this */

/* NOLINTBEGIN(modernize-*,readability-identifier-naming): C's names */

/* Signed values are shifted to the right: with their sign, or this does not compile. */
typedef char tb_shifts_keep_the_sign[(-3 >> 1) == -2 ? 1 : -1];

/* Status of a taxel in a frame, the bits of compensator_c.h. */
enum {
  TB_VALID = 1,        /* computed from this frame's count */
  TB_OUT_OF_RANGE = 4, /* a count that the taxel cannot give: the loop's end, or the last pressure again */
  TB_DEAD = 8,         /* without a model: pressure 0 */
  TB_UNKNOWN = 32,     /* has not been at its zero or its top yet, so that its history is not known */
  TB_LOST = 64         /* no frame: the last pressure again */
};

/* Functions that are called with a constant, for which they become short; and those that are not to be copied. */
#if defined(__GNUC__)
#define TB_INLINE static inline __attribute__((always_inline))
#define TB_OUTLINE static __attribute__((noinline, unused))
#else
#define TB_INLINE static inline
#define TB_OUTLINE static inline
#endif

/* Processors that do not divide: a quotient by products. */
#if defined(__ARM_ARCH_6M__) || defined(__ARM_ARCH_8M_BASE__)
#define TB_SHORT 1
#else
#define TB_SHORT 0
#endif

/* 2^31 / b in the middle of each of 128 intervals of b from 2^15 to 2^16. */
static const uint16_t tb_inverse[128] = {
    65280, 64776, 64280, 63791, 63310, 62836, 62368, 61908, 61455, 61008, 60567, 60133, 59705, 59283, 58867, 58457,
    58052, 57653, 57260, 56871, 56488, 56111, 55738, 55370, 55007, 54648, 54295, 53946, 53601, 53261, 52924, 52593,
    52265, 51941, 51622, 51306, 50994, 50686, 50382, 50081, 49784, 49490, 49200, 48913, 48629, 48349, 48072, 47798,
    47527, 47259, 46995, 46733, 46474, 46218, 45964, 45714, 45466, 45221, 44979, 44739, 44501, 44267, 44034, 43804,
    43577, 43351, 43129, 42908, 42690, 42473, 42259, 42048, 41838, 41630, 41425, 41221, 41020, 40820, 40622, 40427,
    40233, 40041, 39850, 39662, 39475, 39290, 39107, 38926, 38746, 38568, 38391, 38216, 38043, 37871, 37701, 37532,
    37365, 37200, 37035, 36873, 36711, 36551, 36393, 36235, 36080, 35925, 35772, 35620, 35469, 35320, 35172, 35025,
    34879, 34735, 34592, 34450, 34309, 34169, 34030, 33893, 33756, 33621, 33487, 33354, 33222, 33091, 32961, 32832};
/* floor(a 65536 / b), a < b < 65536: both twice as large until b has 16 bits, 1 / b by a step of Newton from the table,
 * below by so little that the quotient is a few too small. */
TB_OUTLINE uint32_t tb_r_short(uint32_t a, uint32_t b) {
  uint32_t inverse, ratio, rest;
  if (b < 0x100U) b <<= 8, a <<= 8;
  if (b < 0x1000U) b <<= 4, a <<= 4;
  if (b < 0x4000U) b <<= 2, a <<= 2;
  if (b < 0x8000U) b <<= 1, a <<= 1;
  inverse = tb_inverse[(b >> 8) - 128U];
  inverse += (uint32_t)(((int32_t)(0x80000000U - inverse * b) >> 9) * (int32_t)inverse >> 22);
  ratio = (a * inverse) >> 15;
  for (rest = (a << 16) - ratio * b; rest >= b; rest -= b) ++ratio;
  return ratio;
}
/* floor(a b / 65536), b below 65536. */
static inline int32_t tb_m(int32_t a, uint32_t b) {
  return (a >> 16) * (int32_t)b + (int32_t)((((uint32_t)a & 0xFFFFU) * b) >> 16);
}
/* floor(a 65536 / b), 0 <= a < b < 65536. */
static inline uint32_t tb_r16(uint32_t a, uint32_t b) { return TB_SHORT ? tb_r_short(a, b) : (a << 16) / b; }
/* The same of b < 2^20. */
static inline uint32_t tb_r(uint32_t a, uint32_t b) {
  uint32_t first;
  if (a < 0x10000U) return (a << 16) / b;
  first = (a << 12) / b;
  return (first << 4) | ((((a << 12) - first * b) << 4) / b);
}
static inline int32_t tb_signed(uint16_t low, uint16_t high) {
  return ((int32_t)high - (high & 0x8000U ? 0x10000 : 0)) * 0x10000 + (int32_t)low;
}

/* CRC-32 (zlib's crc32) of words of 16 bits, the low byte first; of several parts one after another, from
 * TB_HASH_START. */
#define TB_HASH_START 0U
static inline uint32_t tb_hash(uint32_t hash, const uint16_t* words, uint32_t count) {
  uint32_t i, bit;
  hash = ~hash;
  for (i = 0; i < count; ++i)
    for (hash ^= words[i], bit = 0; bit < 16; ++bit) hash = hash & 1 ? (hash >> 1) ^ 0xEDB88320U : hash >> 1;
  return ~hash;
}

/* A linear piece of a branch: inputs x over outputs u, low < u < high; elsewhere the nearer end. */
typedef struct {
  uint16_t low, high, x_low, x_high;
} tb_piece;
typedef struct {
  uint16_t x, u;
} tb_point;

static inline int tb_inside(const tb_piece* p, uint32_t u) { return u > p->low && u < p->high; }
static inline uint32_t tb_along(const tb_piece* p, uint32_t u) {
  if (u >= p->high) return p->x_high;
  if (u <= p->low) return p->x_low;
  return p->x_low + (((uint32_t)(p->x_high - p->x_low) * tb_r16(u - p->low, (uint32_t)(p->high - p->low))) >> 16);
}
/* The output from which another branch goes on ends the piece. */
static inline void tb_cut(tb_piece* p, int rises, tb_point at) {
  const uint16_t x = at.x < p->x_low ? p->x_low : at.x > p->x_high ? p->x_high : at.x;
  if (rises && p->high > at.u) {
    p->high = at.u;
    p->x_high = x;
  }
  if (!rises && p->low < at.u) {
    p->low = at.u;
    p->x_low = x;
  }
}

/* Thresholds in noises / 256, by samples in a mean from 1 to 8 (CompensatorOptions in
 * analysis/compensate/compensator.h). */
enum {
  TB_LONGEST_MEAN = 8,
  TB_STEP_CEILING = 57344, /* 14 noises squared / 4096 */
  TB_MOVING = 9830,        /* 2.4 */
  TB_STEP_WINDOW = 2731,   /* 65536 / 24 */
  TB_REST = 768,           /* 3 noises */
  TB_BAND = 1408,          /* 5.5 noises */
  TB_LONGEST_SPIKE = 3,
  TB_LONGEST_GAP = 10
};
static const uint16_t tb_jump[8] = {1810, 1568, 1478, 1431, 1402, 1383, 1368, 1358};               /* 5 sqrt(1 + 1/n) */
static const uint16_t tb_step_share[8] = {32768, 49152, 54613, 57344, 58982, 60075, 60855, 61440}; /* 1 - 1/(2n) */
static const uint16_t tb_part[8] = {65535, 32768, 21845, 16384, 13107, 10923, 9362, 8192};         /* 1/n */
static const uint16_t tb_lead[8] = {0, 158, 172, 168, 160, 152, 145, 139};    /* 1.75 (1 - 1/n) / sqrt(n) */
static const uint16_t tb_band[8] = {1408, 996, 813, 704, 630, 575, 532, 498}; /* 5.5 / sqrt(n) */
static const uint16_t tb_hold[8] = {410, 290, 236, 205, 183, 167, 155, 145};  /* 1.6 / sqrt(n) */

/* Words of a taxel that both models have. */
typedef struct {
  uint16_t gain;             /* (count << count_shift) to noises / 256; 0: a dead taxel */
  uint16_t zero[2];          /* count << count_shift, signed, low word first */
  uint16_t top[2], limit[2]; /* full output, and the most that is possible, noises / 256 */
  uint16_t place;            /* (noises / 256) << place_shift to 2^-20 */
  uint16_t up, down;         /* counts from zero to what is possible */
} tb_front;

enum { TB_RISES = 1, TB_BEGUN = 2, TB_NOT_KNOWN = 4, TB_SEARCHED = 8 };

/* State of a taxel that both models have. */
typedef struct {
  int32_t mean, extreme, zero; /* noises / 256; count << count_shift */
  uint16_t steps, pressure;    /* mean square of the steps; the last one */
  uint16_t low, high;          /* counts that are possible */
  tb_piece here, there;        /* of the present branch, and of the way back from the extreme */
  uint8_t samples, extreme_samples, spikes, flags, below;
} tb_taxel;

/* At rest at the lowest input, or, not known, anywhere. */
TB_OUTLINE void tb_forget(tb_taxel* t, int known) {
  const tb_piece none = {0, 0, 0, 0};
  t->mean = t->extreme = 0;
  t->steps = TB_STEP_CEILING;
  t->here = t->there = none;
  t->samples = t->extreme_samples = 1;
  t->spikes = t->below = 0;
  t->flags = (uint8_t)(known ? TB_RISES | TB_BEGUN : TB_RISES | TB_NOT_KNOWN);
}

/* Counts that are possible; `highest`: the top as it is, 32768 as in the model. */
static inline void tb_set_limits(const tb_front* w, unsigned shift, uint32_t highest, tb_taxel* t) {
  const int32_t zero = (t->zero + (int32_t)((1U << shift) >> 1)) >> shift;
  const int32_t high = zero + (int32_t)((w->up * highest) >> 15), low = zero - (int32_t)((w->down * highest) >> 15);
  t->high = (uint16_t)(high > 65535 ? 65535 : high < 0 ? 0 : high);
  t->low = (uint16_t)(low > 65535 ? 65535 : low < 0 ? 0 : low);
}

/* `count` becomes the zero of an unloaded taxel. 0: it is off by more than a fifth of the span. */
static inline int tb_set_zero(const tb_front* w, unsigned shift, uint32_t count, tb_taxel* t) {
  const int32_t off = tb_m((int32_t)(count << shift) - t->zero, w->gain);
  const int32_t most = tb_m(tb_signed(w->top[0], w->top[1]), 13107);
  if (off > most || off < -most) return 0;
  t->zero = (int32_t)(count << shift);
  return 1;
}

/* What lies beyond the possible is a spike, unless it came from the end nearby or stays: then it is the loop's end.
 * 0: a spike. */
static inline int tb_end_of_loop(const tb_front* w, uint32_t count, tb_taxel* t, int32_t* y) {
  const int above = count > t->high, begun = (t->flags & TB_BEGUN) != 0;
  const int32_t end = above ? tb_signed(w->top[0], w->top[1]) : 0;
  const int nearby = begun && (above ? t->mean >= end - TB_BAND : t->mean <= end + TB_BAND);
  if (!nearby && t->spikes < TB_LONGEST_SPIKE) {
    ++t->spikes;
    return 0;
  }
  *y = (above ? t->mean > end : t->mean < end) && begun ? t->mean : end; /* not back from where it was already */
  return 1;
}

/* The count as an output. 0: it is held. */
static inline int tb_output_of(const tb_front* w, unsigned shift, uint32_t gain, uint32_t count, tb_taxel* t,
                               int32_t* y, uint16_t* status) {
  if (count < t->low || count > t->high) {
    *status = TB_OUT_OF_RANGE;
    return tb_end_of_loop(w, count, t, y);
  }
  {
    const int32_t limit = tb_signed(w->limit[0], w->limit[1]);
    *y = tb_m((int32_t)(count << shift) - t->zero, gain);
    if (*y > limit) *y = limit;
    if (*y < 0 && *y < tb_signed(w->top[0], w->top[1]) - limit) *y = tb_signed(w->top[0], w->top[1]) - limit;
  }
  t->spikes = 0;
  *status = TB_VALID;
  return 1;
}

/* A history that is not known is known at the zero, where it begins anew (1), and at the top. */
static inline int tb_find_history(const tb_front* w, tb_taxel* t, int32_t y) {
  const int32_t top = tb_signed(w->top[0], w->top[1]), rest = tb_m(top, 655);
  if (y <= (rest > TB_BAND ? rest : TB_BAND)) {
    tb_forget(t, 1);
    return 1;
  }
  if (y >= top - TB_BAND) t->flags = (uint8_t)(t->flags & ~TB_NOT_KNOWN);
  return 0;
}

/* The mean: an output that does not move is averaged. */
static inline void tb_follow(tb_taxel* t, int32_t y) {
  const int32_t off = y - t->mean, size = off < 0 ? -off : off;
  const unsigned at = t->samples - 1U;
  const int moving = t->steps > TB_MOVING;
  int32_t step = TB_STEP_CEILING; /* of 2047 or more: its square has 22 bits */
  if (!(t->flags & TB_BEGUN)) {   /* the first sample of a history that is not known */
    t->flags |= TB_BEGUN;
    t->mean = t->extreme = y;
    return;
  }
  if (size < 2047) {
    step = tb_m(size * size, tb_step_share[at]) >> 4;
    if (step > TB_STEP_CEILING) step = TB_STEP_CEILING;
  }
  t->steps = (uint16_t)(t->steps + tb_m(step - (int32_t)t->steps, TB_STEP_WINDOW));
  if (moving || size > tb_jump[at]) {
    t->samples = 1;
    t->mean = y;
  } else {
    if (at + 1U < TB_LONGEST_MEAN) ++t->samples;
    t->mean += tb_m(off, tb_part[t->samples - 1]);
  }
}

/* The furthest mean, without what the highest of many means lies too high by. */
static inline int32_t tb_turn(const tb_taxel* t) {
  const int32_t lead = tb_lead[t->extreme_samples - 1];
  return t->flags & TB_RISES ? t->extreme - lead : t->extreme + lead;
}
static inline void tb_take_extreme(tb_taxel* t) {
  t->extreme = t->mean;
  t->extreme_samples = t->samples;
  t->there.low = t->there.high = 0;
}

/* Where the mean lies: on the present branch behind the furthest mean, on the way back, ahead, or turned. `nearer`: the
 * mean, or with the creep since the furthest one left in where that is nearer to it. */
enum { TB_HELD, TB_BACK, TB_AHEAD, TB_TURNED };
static inline int tb_zone(tb_taxel* t, int32_t nearer) {
  const int rises = t->flags & TB_RISES;
  const unsigned fewer = (t->samples < t->extreme_samples ? t->samples : t->extreme_samples) - 1U;
  if (rises ? t->mean < t->extreme : t->mean > t->extreme) {
    const int32_t turn = tb_turn(t), behind = rises ? turn - nearer : nearer - turn;
    if (behind > tb_band[fewer]) return TB_TURNED;
    /* It came to rest so near that the extreme was noise. */
    if (t->samples < TB_LONGEST_MEAN || t->extreme_samples >= TB_LONGEST_MEAN || behind > TB_REST)
      return behind > tb_hold[fewer] ? TB_BACK : TB_HELD;
  }
  tb_take_extreme(t);
  return TB_AHEAD;
}

/* A frame was lost: the next one is taken as it comes. */
static inline uint16_t tb_lose(tb_taxel* t) {
  t->steps = TB_STEP_CEILING;
  return (uint16_t)(t->flags & TB_NOT_KNOWN ? TB_LOST | TB_UNKNOWN : TB_LOST);
}

/* Of a whole array. */
typedef struct {
  uint16_t phase, gap; /* of the taxels that are renewed in the next frame; frames lost in a row */
} tb_frames;

/* NOLINTEND(modernize-*,readability-identifier-naming) */
#endif
