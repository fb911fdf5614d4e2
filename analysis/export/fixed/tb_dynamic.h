/* The dynamic model in integers: the divider undone, Everett's table with its staircase of corners, creep and lag, the
 * gain by the observed top. Equations: analysis/models/{divider,preisach,dynamics}.h. */
#ifndef TB_DYNAMIC_H
#define TB_DYNAMIC_H

#include "tb_fixed.h"

/* NOLINTBEGIN(modernize-*,readability-identifier-naming): C's names */

#define TB_DYNAMIC_CORNERS 12U /* when full, the last two, the smallest loop, are forgotten */
#define TB_DYNAMIC_ONE 32768U

typedef struct {
  tb_front front;
  uint16_t divider; /* (noises / 256) << place_shift to 2^-20: what the divider takes */
  uint16_t creep;   /* creep's share of the output, / 65536 */
  uint16_t lag;     /* a / (1 - a) / 16384, a the share that has not arrived between two renewals */
} tb_dynamic_words;

/* x in intervals / 2048; u / 65536, 52429 at the top. */
typedef struct {
  uint32_t hash;                     /* tb_dynamic_hash() of the words as they were exported */
  uint16_t taxels, intervals, every; /* every: frames between two renewals of a taxel's creep and lag */
  uint16_t flip;                     /* 65535: the output falls */
  uint16_t count_shift, place_shift;
  uint16_t decay[4], decay_shift[4]; /* of the three creeps and the lag from renewal to renewal, / 65536 >> shift */
  uint16_t split[3];                 /* of creep among the three, / 65536 */
  uint16_t rested[3];                /* creep at rest, / 65536 */
  uint16_t half[2];                  /* x at which creep has half its target, low word first */
  const tb_dynamic_words* words;
  const uint16_t*
      everett; /* the output's rise from line j to line i > j at i (i - 1) / 2 + j, of one taxel after another */
} tb_dynamic_model;

typedef struct {
  tb_taxel at;
  int32_t psi[3], late;                     /* / 2^24; x / 256 */
  uint16_t gain, factor;                    /* with creep and top; creep's factor, 32768: 1 */
  uint16_t extreme_factor, change;          /* at the furthest mean; factor / extreme_factor, 32768: 1 */
  uint16_t highest;                         /* the top as observed, 32768: the model's; 0: not yet */
  tb_point corners[TB_DYNAMIC_CORNERS - 1]; /* turns: odd ones maxima; number 0, the low end, is not stored */
} tb_dynamic_taxel;

static inline uint32_t tb_dynamic_place(const tb_dynamic_model* m, const tb_dynamic_words* w, int32_t y) {
  if (y > 0) {
    const uint32_t v = (uint32_t)y << m->place_shift;
    const int32_t rise = tb_m((int32_t)v, w->front.place), left = 0x100000 - tb_m((int32_t)v, w->divider);
    return rise < left ? tb_r((uint32_t)rise, (uint32_t)left) : 65535U;
  }
  return 0;
}

/* The top as the outputs are scaled by. */
static inline uint32_t tb_dynamic_top(const tb_dynamic_taxel* t) {
  return t->highest == 0 ? TB_DYNAMIC_ONE : t->highest < 32604 ? 32604U : t->highest > 33587 ? 33587U : t->highest;
}
static inline void tb_dynamic_set_gain(const tb_dynamic_words* w, tb_dynamic_taxel* t) {
  t->gain = (uint16_t)tb_r(w->front.gain, (t->factor * tb_dynamic_top(t)) >> 14);
}
static inline void tb_dynamic_set_factor(const tb_dynamic_model* m, const tb_dynamic_words* w, tb_dynamic_taxel* t) {
  int32_t missing = 0;
  int j;
  for (j = 0; j < 3; ++j) missing += tb_m(0x1000000 - t->psi[j], m->split[j]);
  t->factor = (uint16_t)(TB_DYNAMIC_ONE - (uint32_t)(tb_m(missing, w->creep) >> 9));
  tb_dynamic_set_gain(w, t);
}
static inline void tb_dynamic_mark_extreme(tb_dynamic_taxel* t) {
  t->extreme_factor = t->factor;
  t->change = TB_DYNAMIC_ONE;
}

/* Creep and lag go on as if the pressure had been the last one since the renewal before. */
static inline void tb_dynamic_renew(const tb_dynamic_model* m, const tb_dynamic_words* w, tb_dynamic_taxel* t) {
  const uint32_t x = t->at.pressure, twice = (uint32_t)t->extreme_factor * 2U;
  const int32_t target = (int32_t)(tb_r(x, x + (((uint32_t)m->half[1] << 16) | m->half[0])) << 8);
  int j;
  for (j = 0; j < 3; ++j) t->psi[j] += tb_m(target - t->psi[j], m->decay[j]) >> m->decay_shift[j];
  t->late += tb_m((int32_t)(x << 8) - t->late, m->decay[3]) >> m->decay_shift[3];
  tb_dynamic_set_factor(m, w, t);
  t->change = (uint16_t)(t->factor < twice ? tb_r(t->factor, twice) : 65535U);
}

static inline uint32_t tb_part_of(uint32_t whole, uint32_t share) { return (whole * share) >> 16; }
static inline uint16_t tb_below_65536(uint32_t u) { return (uint16_t)(u < 65535U ? u : 65535U); }

/* The output's rise from the input that is `share` of the way from line `place` to the next, to line i > place. */
static inline uint32_t tb_dynamic_up(const uint16_t* e, uint32_t i, uint32_t place, uint32_t share) {
  const uint16_t* const row = e + i * (i - 1) / 2 + place;
  return row[0] - tb_part_of(i > place + 1 ? row[0] - (uint32_t)row[1] : row[0], share);
}
/* Its fall from there to line j <= place; `row`: of line `place`. */
static inline uint32_t tb_dynamic_down(const uint16_t* row, uint32_t j, uint32_t place, uint32_t share) {
  const uint32_t a = j < place ? row[j] : 0U;
  return a + tb_part_of(row[place + j] - a, share);
}

/* The piece in which the branch from a corner has output u. */
static inline tb_piece tb_dynamic_rising(const uint16_t* e, uint32_t n, tb_point from, uint32_t u) {
  const uint32_t place = from.x >> 11 < n ? from.x >> 11 : n - 1;
  const uint32_t share = (from.x - (place << 11)) << 5, way = u - from.u;
  uint32_t low = place, high = n, low_line = 0, high_line;
  tb_piece p;
  if (u <= from.u) {
    p.low = 0;
    p.high = from.u;
    p.x_low = p.x_high = from.x;
    return p;
  }
  high_line = tb_dynamic_up(e, n, place, share);
  if (way > high_line) {
    p.low = tb_below_65536(from.u + high_line);
    p.high = 65535U;
    p.x_low = p.x_high = (uint16_t)(n << 11);
    return p;
  }
  while (high - low > 1) { /* line(low) < way <= line(high) */
    const uint32_t i = (low + high) / 2, line = tb_dynamic_up(e, i, place, share);
    if (line < way) {
      low = i;
      low_line = line;
    } else {
      high = i;
      high_line = line;
    }
  }
  p.x_low = (uint16_t)(low << 11);
  p.x_high = (uint16_t)(high << 11);
  if (low == place) {
    p.x_low = from.x;
  } else { /* between the two lines lies a kink */
    const uint16_t* const row = e + low * (low - 1) / 2 + place;
    const uint32_t inner = low > place + 1 ? row[1] : 0U;
    uint32_t kink = inner + tb_part_of(row[low + 1] - inner, share) + tb_part_of(row[0] - inner, 65536U - share);
    if (kink < low_line) kink = low_line;
    if (kink > high_line) kink = high_line;
    if (way <= kink) {
      high_line = kink;
      p.x_high = (uint16_t)((low << 11) + (share >> 5));
    } else {
      low_line = kink;
      p.x_low = (uint16_t)((low << 11) + (share >> 5));
    }
  }
  p.low = tb_below_65536(from.u + low_line);
  p.high = tb_below_65536(from.u + high_line);
  return p;
}

static inline tb_piece tb_dynamic_falling(const uint16_t* e, uint32_t n, tb_point from, uint32_t u) {
  const uint32_t place = from.x >> 11 < n ? from.x >> 11 : n - 1;
  const uint32_t share = (from.x - (place << 11)) << 5, way = from.u - u;
  const uint16_t* const row = e + place * (place + 1) / 2 - place;
  uint32_t low = 0, high = place + 1, low_line, high_line = 0;
  tb_piece p;
  if (u >= from.u) {
    p.low = from.u;
    p.high = 65535U;
    p.x_low = p.x_high = from.x;
    return p;
  }
  low_line = tb_dynamic_down(row, 0, place, share);
  if (way > low_line) {
    p.low = 0;
    p.high = (uint16_t)(from.u > low_line ? from.u - low_line : 0);
    p.x_low = p.x_high = 0;
    return p;
  }
  while (high - low > 1) { /* line(low) >= way > line(high) */
    const uint32_t j = (low + high) / 2, line = tb_dynamic_down(row, j, place, share);
    if (line >= way) {
      low = j;
      low_line = line;
    } else {
      high = j;
      high_line = line;
    }
  }
  p.x_low = (uint16_t)(low << 11);
  p.x_high = (uint16_t)(high << 11);
  if (low == place) {
    p.x_high = from.x;
    high_line = 0;
  } else {
    const uint32_t inner = high < place ? row[high] : 0U;
    uint32_t kink = inner + tb_part_of(row[place + high] - inner, share) + tb_part_of(row[low] - inner, 65536U - share);
    if (kink > low_line) kink = low_line;
    if (kink < high_line) kink = high_line;
    if (way >= kink) {
      high_line = kink;
      p.x_high = (uint16_t)((low << 11) + (share >> 5));
    } else {
      low_line = kink;
      p.x_low = (uint16_t)((low << 11) + (share >> 5));
    }
  }
  p.low = (uint16_t)(from.u > low_line ? from.u - low_line : 0);
  p.high = (uint16_t)(from.u > high_line ? from.u - high_line : 0);
  return p;
}

static inline tb_point tb_dynamic_corner(const tb_dynamic_taxel* t, unsigned number) {
  const tb_point end = {0, 0};
  return number == 0 ? end : t->corners[number - 1];
}
/* How many corners are before the branch that goes on at u: those that it passes are wiped out, two at a time. */
static inline unsigned tb_dynamic_left(const tb_dynamic_taxel* t, unsigned below, uint32_t u) {
  if (below % 2 == 0)
    while (below >= 2 && u > t->corners[below - 2].u) below -= 2;
  else
    while (below >= 3 && u < t->corners[below - 2].u) below -= 2;
  return below;
}
/* Of the branch from `from`, which `below` corners are before. */
static inline tb_piece tb_dynamic_find(const tb_dynamic_model* m, const uint16_t* e, const tb_dynamic_taxel* t,
                                       unsigned below, tb_point from, uint32_t u) {
  const unsigned left = tb_dynamic_left(t, below, u);
  const int rises = left % 2 == 0;
  tb_piece p;
  if (left != below) from = tb_dynamic_corner(t, left);
  p = rises ? tb_dynamic_rising(e, m->intervals, from, u) : tb_dynamic_falling(e, m->intervals, from, u);
  if (left >= (rises ? 2U : 3U)) tb_cut(&p, rises, t->corners[left - 2]);
  return p;
}
static inline tb_piece tb_dynamic_here(const tb_dynamic_model* m, const uint16_t* e, const tb_dynamic_taxel* t,
                                       uint32_t u) {
  return tb_dynamic_find(m, e, t, t->at.below, tb_dynamic_corner(t, t->at.below), u);
}

/* The branch that turns at u: its corner, and how many are before it. */
static inline unsigned tb_dynamic_way(const tb_dynamic_model* m, const uint16_t* e, const tb_dynamic_taxel* t,
                                      uint32_t u, tb_point* corner) {
  const tb_piece on = tb_inside(&t->at.here, u) ? t->at.here : tb_dynamic_here(m, e, t, u);
  const unsigned below = tb_dynamic_left(t, t->at.below, u) + 1U;
  corner->x = (uint16_t)tb_along(&on, u);
  corner->u = (uint16_t)u;
  if (below % 2 == 0 && corner->x == 0) {
    corner->u = 0;
    return 0;
  }
  return below < TB_DYNAMIC_CORNERS ? below : below - 2U;
}

/* Before a turn from rising to falling is remembered: the highest of long was one at full input. Scales the means. */
static inline void tb_dynamic_observe_top(const tb_dynamic_model* m, const tb_dynamic_words* w, tb_dynamic_taxel* t,
                                          int32_t* turn) {
  const int32_t top = tb_signed(w->front.top[0], w->front.top[1]);
  const uint32_t before = tb_dynamic_top(t);
  const int32_t measured = tb_m(*turn * 2, before);
  uint32_t ratio, change;
  if (measured < top - tb_m(top, 328)) return; /* 0.005 */
  ratio = measured >> 5 < top >> 4 ? tb_r((uint32_t)measured >> 5, (uint32_t)top >> 4) : 65535U;
  t->highest = (uint16_t)(ratio > t->highest ? ratio : t->highest - (((t->highest - ratio) * 1311U + 32768U) >> 16));
  change = tb_r(before, 2U * tb_dynamic_top(t));
  if (change == TB_DYNAMIC_ONE) return;
  t->at.mean = tb_m(t->at.mean * 2, change);
  *turn = tb_m(*turn * 2, change);
  tb_dynamic_set_gain(w, t);
  tb_set_limits(&w->front, m->count_shift, tb_dynamic_top(t), &t->at);
}

/* How the history begins: at rest, or not known. */
static inline void tb_dynamic_start(const tb_dynamic_model* m, const tb_dynamic_words* w, tb_dynamic_taxel* t,
                                    int known) {
  int j;
  tb_forget(&t->at, known);
  t->at.pressure = 0;
  for (j = 0; j < 3; ++j) t->psi[j] = (int32_t)m->rested[j] << 8;
  t->late = 0;
  t->highest = 0;
  if (w->front.gain == 0) return;
  tb_dynamic_set_factor(m, w, t);
  tb_dynamic_mark_extreme(t);
  tb_set_limits(&w->front, m->count_shift, TB_DYNAMIC_ONE, &t->at);
}

/* One count of taxel number `number`; the pressure is then t->at.pressure. Returns the status. */
static inline uint16_t tb_dynamic_step(const tb_dynamic_model* m, uint32_t number, tb_dynamic_taxel* t, uint32_t count,
                                       int renews) {
  const tb_dynamic_words* const w = &m->words[number];
  const uint32_t n = m->intervals;
  const uint16_t* const e = m->everett + number * (n * (n + 1) / 2);
  uint16_t status;
  uint32_t u, x;
  int32_t y, nearer, pressure;
  int zone;
  if (w->front.gain == 0) return TB_DEAD;
  if (renews) tb_dynamic_renew(m, w, t);
  if (!tb_output_of(&w->front, m->count_shift, t->gain, count ^ m->flip, &t->at, &y, &status))
    return (uint16_t)(t->at.flags & TB_NOT_KNOWN ? status | TB_UNKNOWN : status);
  if (t->at.flags & TB_NOT_KNOWN) (void)tb_find_history(&w->front, &t->at, y);
  tb_follow(&t->at, y);
  nearer = t->at.mean;
  if (t->change != TB_DYNAMIC_ONE) {
    const int32_t measured = tb_m(nearer * 2, t->change);
    if (t->at.flags & TB_RISES ? measured > nearer : measured < nearer) nearer = measured;
  }
  zone = tb_zone(&t->at, nearer);
  if (zone == TB_TURNED) {
    int32_t turn = tb_turn(&t->at);
    tb_point corner;
    unsigned below;
    if (t->at.flags & TB_RISES) tb_dynamic_observe_top(m, w, t, &turn);
    below = tb_dynamic_way(m, e, t, tb_dynamic_place(m, w, turn), &corner);
    if (below > 0) t->corners[below - 1] = corner;
    t->at.below = (uint8_t)below;
    t->at.flags ^= TB_RISES;
    t->at.here.low = t->at.here.high = 0;
    tb_take_extreme(&t->at);
  }
  u = tb_dynamic_place(m, w, t->at.mean);
  if (zone == TB_BACK) {
    if (!tb_inside(&t->at.there, u)) {
      tb_point corner;
      const unsigned below = tb_dynamic_way(m, e, t, tb_dynamic_place(m, w, tb_turn(&t->at)), &corner);
      t->at.there = tb_dynamic_find(m, e, t, below, corner, u);
    }
    x = tb_along(&t->at.there, u);
  } else {
    if (zone >= TB_AHEAD) tb_dynamic_mark_extreme(t);
    if (!tb_inside(&t->at.here, u)) {
      if (zone >= TB_AHEAD) t->at.below = (uint8_t)tb_dynamic_left(t, t->at.below, u);
      t->at.here = tb_dynamic_here(m, e, t, u);
    }
    x = tb_along(&t->at.here, u);
  }
  pressure = (int32_t)x + (tb_m(((int32_t)(x << 8) - t->late) * 4, w->lag) >> 8);
  t->at.pressure = (uint16_t)(pressure < 0 ? 0 : pressure > (int32_t)(n << 11) ? (int32_t)(n << 11) : pressure);
  return (uint16_t)(t->at.flags & TB_NOT_KNOWN ? status | TB_UNKNOWN : status);
}

static inline uint32_t tb_dynamic_hash(const tb_dynamic_model* m) {
  const uint32_t words = sizeof(tb_dynamic_words) / sizeof(uint16_t), n = m->intervals;
  const uint32_t hash = tb_hash(TB_HASH_START, &m->words[0].front.gain, m->taxels * words);
  return tb_hash(hash, m->everett, m->taxels * (n * (n + 1) / 2));
}

/* 1: the words are those that were exported. All histories are unknown. */
static inline int tb_dynamic_init(const tb_dynamic_model* m, tb_frames* f, tb_dynamic_taxel* t) {
  uint32_t i;
  f->phase = f->gap = 0;
  for (i = 0; i < m->taxels; ++i) {
    t[i].at.zero = tb_signed(m->words[i].front.zero[0], m->words[i].front.zero[1]);
    tb_dynamic_start(m, &m->words[i], &t[i], 0);
  }
  return tb_dynamic_hash(m) == m->hash;
}
/* `count` becomes the zero of an unloaded taxel at rest. 0: it is too far off; the zero stays, the history is unknown.
 */
static inline int tb_dynamic_tare_taxel(const tb_dynamic_model* m, uint32_t number, tb_dynamic_taxel* t,
                                        uint32_t count) {
  const tb_front* const w = &m->words[number].front;
  const int taken = w->gain == 0 || tb_set_zero(w, m->count_shift, count ^ m->flip, &t->at);
  tb_dynamic_start(m, &m->words[number], t, taken);
  return taken;
}
/* How many taxels were too far off. */
static inline uint32_t tb_dynamic_tare(const tb_dynamic_model* m, tb_frames* f, tb_dynamic_taxel* t,
                                       const uint16_t* counts) {
  uint32_t i, refused = 0;
  f->phase = f->gap = 0;
  for (i = 0; i < m->taxels; ++i)
    if (!tb_dynamic_tare_taxel(m, i, &t[i], counts[i])) ++refused;
  return refused;
}
/* In each frame a part of the taxels is renewed: number i in frame i, i + every, ... */
static inline void tb_dynamic_frame(const tb_dynamic_model* m, tb_frames* f, tb_dynamic_taxel* t,
                                    const uint16_t* counts, uint16_t* pressures, uint16_t* status) {
  uint32_t i, next = f->phase;
  f->gap = 0;
  f->phase = (uint16_t)(f->phase + 1U < m->every ? f->phase + 1U : 0U);
  for (i = 0; i < m->taxels; ++i) {
    const int renews = i == next;
    if (renews) next += m->every;
    status[i] = tb_dynamic_step(m, i, &t[i], counts[i], renews);
    pressures[i] = t[i].at.pressure;
  }
}
/* Without a count; `forgets`: too many in a row. */
static inline uint16_t tb_dynamic_lose(const tb_dynamic_model* m, uint32_t number, tb_dynamic_taxel* t, int forgets,
                                       int renews) {
  if (m->words[number].front.gain == 0) return TB_DEAD;
  if (forgets) tb_dynamic_start(m, &m->words[number], t, 0);
  if (renews) tb_dynamic_renew(m, &m->words[number], t);
  return tb_lose(&t->at);
}
static inline void tb_dynamic_lost_frame(const tb_dynamic_model* m, tb_frames* f, tb_dynamic_taxel* t,
                                         uint16_t* pressures, uint16_t* status) {
  uint32_t i, next = f->phase;
  if (f->gap <= TB_LONGEST_GAP) ++f->gap;
  f->phase = (uint16_t)(f->phase + 1U < m->every ? f->phase + 1U : 0U);
  for (i = 0; i < m->taxels; ++i) {
    const int renews = i == next;
    if (renews) next += m->every;
    status[i] = tb_dynamic_lose(m, i, &t[i], f->gap > TB_LONGEST_GAP, renews);
    pressures[i] = t[i].at.pressure;
  }
}

/* NOLINTEND(modernize-*,readability-identifier-naming) */
#endif
