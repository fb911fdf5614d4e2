/* ELAM in integers, with memory of turns, as the program's stream has it (analysis/compensate/elam_curve.h). Equations:
 * analysis/models/elam.h. */
#ifndef TB_ELAM_H
#define TB_ELAM_H

#include "tb_fixed.h"

/* NOLINTBEGIN(modernize-*,readability-identifier-naming): C's names */

/* x: 65535 at the highest input; outputs: 61440 at the top. */
#define TB_ELAM_X 65535U
#define TB_ELAM_Y 61440U
#define TB_ELAM_POINTS 12U /* when full, the last two, the smallest loop, are forgotten */

typedef struct {
  tb_front front;
  uint16_t alpha_d, beta_d, beta_a; /* / 65536 */
  uint16_t split_short, split_long; /* Eq. (21) for a branch of no length and of all, / 65536 */
} tb_elam_words;

typedef struct {
  uint32_t hash; /* tb_elam_hash() of the words as they were exported */
  uint16_t taxels, knots;
  uint16_t flip; /* 65535: the output falls */
  uint16_t count_shift, place_shift;
  uint16_t exact_outer; /* external branches follow the patterns [A6] */
  const uint16_t* x;    /* of the knots */
  const tb_elam_words* words;
  const uint16_t* patterns; /* outputs at the knots, rising, then falling, of one taxel after another */
} tb_elam_model;

typedef struct {
  tb_taxel at;
  tb_point points[TB_ELAM_POINTS]; /* turns, the first where the branch of the external loop began */
} tb_elam_taxel;

/* A branch from `from` to `end`, where it closes its loop or ends: the curve of Eqs (31)-(38) from `from` on, its
 * outputs scaled so that it meets `end`. */
typedef struct {
  int rises;
  tb_point from, end;
  uint32_t split_x, split_y;           /* of the curve */
  uint32_t turn_p, split_p, split_p_y; /* on the pattern: x of turn and split, output of the split */
  uint32_t reach;                      /* output of the curve at the end's x */
} tb_elam_curve;

/* v from one range to another, both rising; ranges that are the same: v itself. */
static inline uint32_t tb_map(uint32_t v, uint32_t low, uint32_t high, uint32_t to_low, uint32_t to_high) {
  if (v <= low) return to_low;
  if (v >= high) return to_high;
  if (low == to_low && high == to_high) return v;
  return to_low + (((to_high - to_low) * tb_r(v - low, high - low)) >> 16);
}
/* The last of n knots, but for the very last, that is not above v; else the first. */
static inline uint32_t tb_interval(const uint16_t* knots, uint32_t n, uint32_t v) {
  uint32_t first = 0, left = n - 1;
  while (left > 1) {
    const uint32_t half = left / 2;
    if (knots[first + half] <= v) first += half;
    left -= half;
  }
  return first;
}
static inline uint32_t tb_through(const uint16_t* from, const uint16_t* to, uint32_t n, uint32_t v) {
  const uint32_t k = tb_interval(from, n, v);
  return tb_map(v, from[k], from[k + 1], to[k], to[k + 1]);
}

static inline const uint16_t* tb_elam_pattern(const tb_elam_model* m, uint32_t number, int rises) {
  return m->patterns + (2 * number + (rises ? 0U : 1U)) * m->knots;
}

static inline void tb_elam_curve_of(const tb_elam_model* m, uint32_t number, int rises, tb_point from, tb_point end,
                                    tb_elam_curve* c) {
  const tb_elam_words* const w = &m->words[number];
  const uint16_t* const pattern = tb_elam_pattern(m, number, rises);
  const uint32_t x = from.x, y = rises && from.u > TB_ELAM_Y ? TB_ELAM_Y : from.u;
  const uint32_t near_end = 655; /* 0.01 */
  c->rises = rises;
  c->from.x = from.x;
  c->from.u = (uint16_t)y;
  c->end = end;
  if (rises) {
    const uint32_t length = TB_ELAM_X - x;
    const uint32_t share = w->split_long >= w->split_short
                               ? w->split_short + ((length * (uint32_t)(w->split_long - w->split_short)) >> 16)
                               : w->split_short - ((length * (uint32_t)(w->split_short - w->split_long)) >> 16);
    c->split_x = x + ((length * share) >> 16);              /* (21) */
    c->split_y = y + (((TB_ELAM_Y - y) * w->beta_a) >> 16); /* (22) */
    c->split_p = tb_through(pattern, m->x, m->knots, c->split_y);
    c->turn_p = tb_through(pattern, m->x, m->knots, y);
    c->split_p_y = c->split_y;
    if (m->exact_outer && x <= near_end) c->split_x = c->split_p > x ? c->split_p : x;
  } else {
    /* Near the top the split is that of a turn at the highest input: within 0.01 of the span, fading out to 0.02. */
    const uint32_t below = y < TB_ELAM_Y ? TB_ELAM_Y - y : 0U;
    const uint32_t share = below <= 614 ? 65536U : below >= 1228 ? 0U : (1228U - below) * 106U;
    const uint32_t x_split = x + (share == 65536U ? TB_ELAM_X - x : ((TB_ELAM_X - x) * share) >> 16);
    c->split_x = (x_split * w->alpha_d) >> 16; /* (14) */
    if (c->split_x > x) c->split_x = x;
    c->split_p = c->split_x;
    c->turn_p = x;
    c->split_p_y = tb_through(m->x, pattern, m->knots, c->split_x);
    c->split_y = m->exact_outer && TB_ELAM_X - x_split <= near_end ? tb_map(c->split_p_y, 0, TB_ELAM_Y, 0, y)
                                                                   : (y * w->beta_d) >> 16; /* (15) */
  }
  /* (16) to (19), (23) to (26) */
  c->reach = end.u;
  if (rises ? end.x < TB_ELAM_X : end.x > 0) {
    const uint32_t e = end.x;
    if (rises)
      c->reach = e <= x ? y
                        : tb_through(m->x, pattern, m->knots,
                                     e <= c->split_x ? tb_map(e, x, c->split_x, c->turn_p, c->split_p)
                                                     : tb_map(e, c->split_x, TB_ELAM_X, c->split_p, TB_ELAM_X));
    else if (e >= x)
      c->reach = y;
    else if (e >= c->split_x)
      c->reach = tb_map(tb_through(m->x, pattern, m->knots, tb_map(e, c->split_x, x, c->split_x, TB_ELAM_X)),
                        c->split_p_y, TB_ELAM_Y, c->split_y, y);
    else
      c->reach = tb_map(tb_through(m->x, pattern, m->knots, e), 0, c->split_p_y, 0, c->split_y);
  } else if (!rises) {
    c->reach = 0;
  } else {
    c->reach = TB_ELAM_Y;
  }
}

/* One of the two parts of a curve: the same stretch as the curve's outputs and inputs, and as the pattern's. */
typedef struct {
  uint32_t y_low, y_high, x_low, x_high, p_y_low, p_y_high, p_x_low, p_x_high;
} tb_elam_part;

static inline void tb_elam_part_of(const tb_elam_curve* c, int upper, tb_elam_part* s) {
  if (c->rises) {
    s->y_low = upper ? c->split_y : c->from.u;
    s->y_high = upper ? TB_ELAM_Y : c->split_y;
    s->x_low = upper ? c->split_x : c->from.x;
    s->x_high = upper ? TB_ELAM_X : c->split_x;
    s->p_y_low = s->y_low;
    s->p_y_high = s->y_high;
    s->p_x_low = upper ? c->split_p : c->turn_p;
    s->p_x_high = upper ? TB_ELAM_X : c->split_p;
  } else {
    s->y_low = upper ? c->split_y : 0;
    s->y_high = upper ? c->from.u : c->split_y;
    s->x_low = s->p_x_low = upper ? c->split_x : 0;
    s->x_high = upper ? c->from.x : c->split_x;
    s->p_y_low = upper ? c->split_p_y : 0;
    s->p_y_high = upper ? TB_ELAM_Y : c->split_p_y;
    s->p_x_high = upper ? TB_ELAM_X : c->split_x;
  }
}

/* The piece with output y. Between two knots of the pattern, or their images, low < y <= high. */
static inline tb_piece tb_elam_piece(const tb_elam_model* m, const uint16_t* pattern, const tb_elam_curve* c,
                                     uint32_t y) {
  const uint32_t from =
      c->rises ? (c->from.u < c->end.u ? c->from.u : c->end.u) : (c->from.u > c->end.u ? c->from.u : c->end.u);
  const uint32_t low = c->rises ? from : c->end.u, high = c->rises ? c->end.u : from;
  const uint32_t of_low = c->rises ? c->from.u : c->reach, of_high = c->rises ? c->reach : c->from.u;
  const uint16_t x_low = c->rises ? c->from.x : c->end.x, x_high = c->rises ? c->end.x : c->from.x;
  tb_elam_part part;
  tb_piece p;
  uint32_t k, of_curve;
  p.low = (uint16_t)low;
  p.high = (uint16_t)high;
  p.x_low = x_low;
  p.x_high = x_high;
  if (y <= low) {
    p.low = 0;
    p.high = (uint16_t)low;
    p.x_high = x_low;
    return p;
  }
  if (y >= high) {
    p.low = (uint16_t)high;
    p.high = 65535U;
    p.x_low = x_high;
    return p;
  }
  if (of_high <= of_low) return p; /* rises too little to be scaled: linear [A12] */
  of_curve = tb_map(y, low, high, of_low, of_high);
  tb_elam_part_of(c, c->rises ? of_curve > c->split_y : of_curve >= c->split_y, &part);
  k = tb_interval(pattern, m->knots, tb_map(of_curve, part.y_low, part.y_high, part.p_y_low, part.p_y_high));
  for (;;) {
    uint32_t own[2], x[2], end;
    for (end = 0; end < 2; ++end) {
      const uint32_t knot = pattern[k + end], at = m->x[k + end];
      const uint32_t of = tb_map(knot, part.p_y_low, part.p_y_high, part.y_low, part.y_high);
      own[end] = tb_map(of, of_low, of_high, low, high);
      x[end] = knot <= part.p_y_low    ? part.x_low
               : knot >= part.p_y_high ? part.x_high
                                       : tb_map(at, part.p_x_low, part.p_x_high, part.x_low, part.x_high);
    }
    if (y <= own[0] && pattern[k] > part.p_y_low && k > 0) {
      --k;
    } else if (y > own[1] && pattern[k + 1] < part.p_y_high && k + 2 < m->knots) {
      ++k;
    } else {
      p.low = (uint16_t)own[0];
      p.high = (uint16_t)own[1];
      p.x_low = (uint16_t)(x[0] > x_low ? x[0] : x_low);
      p.x_high = (uint16_t)(x[1] < x_high ? x[1] : x_high);
      if (p.x_high < p.x_low) p.x_high = p.x_low;
      return p;
    }
  }
}

/* Where branch number `below` ends: the turn before, of the external loop its own end. */
static inline tb_point tb_elam_end(const tb_elam_taxel* t, unsigned below, int rises) {
  tb_point end = {0, 0};
  if (below > 0) end = t->points[below - 1];
  if (rises && (below == 0 || end.x >= TB_ELAM_X)) {
    end.x = TB_ELAM_X;
    end.u = TB_ELAM_Y;
  }
  if (!rises && (below == 0 || end.x == 0)) end.x = end.u = 0;
  return end;
}
/* How many turns are before the branch that goes on at y: loops that it closed are forgotten. */
static inline unsigned tb_elam_left(const tb_elam_taxel* t, unsigned below, int rises, uint32_t y) {
  while (below >= 2) {
    const tb_point end = tb_elam_end(t, below, rises);
    if (rises ? y <= end.u : y >= end.u) break;
    below -= 2;
  }
  return below;
}
/* Of the branch from `from`, which `below` turns are before. */
static inline tb_piece tb_elam_find(const tb_elam_model* m, uint32_t number, const tb_elam_taxel* t, unsigned below,
                                    int rises, tb_point from, uint32_t y) {
  const unsigned left = tb_elam_left(t, below, rises, y);
  const tb_point end = tb_elam_end(t, left, rises);
  tb_elam_curve curve;
  tb_piece p;
  tb_elam_curve_of(m, number, rises, left == below ? from : t->points[left], end, &curve);
  p = tb_elam_piece(m, tb_elam_pattern(m, number, rises), &curve, y);
  if (left >= 2) tb_cut(&p, rises, end);
  return p;
}
static inline tb_piece tb_elam_here(const tb_elam_model* m, uint32_t number, const tb_elam_taxel* t, uint32_t y) {
  return tb_elam_find(m, number, t, t->at.below, t->at.flags & TB_RISES, t->points[t->at.below], y);
}
/* The branch that turns at y: where it begins, and how many turns are before it. */
static inline unsigned tb_elam_way(const tb_elam_model* m, uint32_t number, const tb_elam_taxel* t, uint32_t y,
                                   tb_point* from) {
  const int rises = t->at.flags & TB_RISES;
  const tb_piece on = tb_inside(&t->at.here, y) ? t->at.here : tb_elam_here(m, number, t, y);
  const unsigned below = tb_elam_left(t, t->at.below, rises, y) + 1U;
  from->x = (uint16_t)tb_along(&on, y);
  from->u = (uint16_t)y;
  if (rises ? from->x >= TB_ELAM_X : from->x == 0) return 0;
  return below < TB_ELAM_POINTS ? below : below - 2U;
}

static inline uint32_t tb_elam_place(const tb_elam_model* m, const tb_elam_words* w, int32_t y) {
  return y > 0 ? (uint32_t)(tb_m((int32_t)((uint32_t)y << m->place_shift), w->front.place) >> 4) : 0U;
}

/* How the history begins: at rest, or not known. */
static inline void tb_elam_start(const tb_elam_model* m, const tb_elam_words* w, tb_elam_taxel* t, int known) {
  tb_forget(&t->at, known);
  t->at.pressure = 0;
  t->points[0].x = t->points[0].u = 0;
  tb_set_limits(&w->front, m->count_shift, 32768U, &t->at);
}

/* One count of taxel number `number`; the pressure is then t->at.pressure. Returns the status. */
static inline uint16_t tb_elam_step(const tb_elam_model* m, uint32_t number, tb_elam_taxel* t, uint32_t count) {
  const tb_elam_words* const w = &m->words[number];
  uint16_t status;
  uint32_t u;
  int32_t y;
  int zone;
  if (w->front.gain == 0) return TB_DEAD;
  if (!tb_output_of(&w->front, m->count_shift, w->front.gain, count ^ m->flip, &t->at, &y, &status))
    return (uint16_t)(t->at.flags & TB_NOT_KNOWN ? status | TB_UNKNOWN : status);
  if ((t->at.flags & TB_NOT_KNOWN) && tb_find_history(&w->front, &t->at, y)) t->points[0].x = t->points[0].u = 0;
  tb_follow(&t->at, y);
  zone = tb_zone(&t->at, t->at.mean);
  if (zone == TB_TURNED) {
    tb_point from;
    const unsigned below = tb_elam_way(m, number, t, tb_elam_place(m, w, tb_turn(&t->at)), &from);
    t->points[below] = from;
    t->at.below = (uint8_t)below;
    t->at.flags ^= TB_RISES;
    t->at.here.low = t->at.here.high = 0;
    tb_take_extreme(&t->at);
  }
  u = tb_elam_place(m, w, t->at.mean);
  if (zone == TB_BACK) {
    if (!tb_inside(&t->at.there, u)) {
      tb_point from;
      const unsigned below = tb_elam_way(m, number, t, tb_elam_place(m, w, tb_turn(&t->at)), &from);
      t->at.there = tb_elam_find(m, number, t, below, !(t->at.flags & TB_RISES), from, u);
    }
    t->at.pressure = (uint16_t)tb_along(&t->at.there, u);
  } else {
    if (!tb_inside(&t->at.here, u)) {
      if (zone >= TB_AHEAD) t->at.below = (uint8_t)tb_elam_left(t, t->at.below, t->at.flags & TB_RISES, u);
      t->at.here = tb_elam_here(m, number, t, u);
    }
    t->at.pressure = (uint16_t)tb_along(&t->at.here, u);
  }
  return (uint16_t)(t->at.flags & TB_NOT_KNOWN ? status | TB_UNKNOWN : status);
}

static inline uint32_t tb_elam_hash(const tb_elam_model* m) {
  uint32_t hash = tb_hash(TB_HASH_START, m->x, m->knots);
  hash = tb_hash(hash, &m->words[0].front.gain, m->taxels * (uint32_t)(sizeof(tb_elam_words) / sizeof(uint16_t)));
  return tb_hash(hash, m->patterns, 2U * m->taxels * m->knots);
}

/* 1: the words are those that were exported. All histories are unknown. */
static inline int tb_elam_init(const tb_elam_model* m, tb_frames* f, tb_elam_taxel* t) {
  uint32_t i;
  f->phase = f->gap = 0;
  for (i = 0; i < m->taxels; ++i) {
    t[i].at.zero = tb_signed(m->words[i].front.zero[0], m->words[i].front.zero[1]);
    tb_elam_start(m, &m->words[i], &t[i], 0);
  }
  return tb_elam_hash(m) == m->hash;
}
/* How many taxels were too far off: those keep their zero, and their history is unknown. */
static inline uint32_t tb_elam_tare(const tb_elam_model* m, tb_frames* f, tb_elam_taxel* t, const uint16_t* counts) {
  uint32_t i, refused = 0;
  f->phase = f->gap = 0;
  for (i = 0; i < m->taxels; ++i) {
    const tb_front* const w = &m->words[i].front;
    const int taken = w->gain == 0 || tb_set_zero(w, m->count_shift, (uint32_t)counts[i] ^ m->flip, &t[i].at);
    tb_elam_start(m, &m->words[i], &t[i], taken);
    if (!taken) ++refused;
  }
  return refused;
}
static inline void tb_elam_frame(const tb_elam_model* m, tb_frames* f, tb_elam_taxel* t, const uint16_t* counts,
                                 uint16_t* pressures, uint16_t* status) {
  uint32_t i;
  f->gap = 0;
  for (i = 0; i < m->taxels; ++i) {
    status[i] = tb_elam_step(m, i, &t[i], counts[i]);
    pressures[i] = t[i].at.pressure;
  }
}
/* Without a count; `forgets`: too many in a row. */
static inline uint16_t tb_elam_lose(const tb_elam_model* m, uint32_t number, tb_elam_taxel* t, int forgets) {
  if (m->words[number].front.gain == 0) return TB_DEAD;
  if (forgets) tb_elam_start(m, &m->words[number], t, 0);
  return tb_lose(&t->at);
}
static inline void tb_elam_lost_frame(const tb_elam_model* m, tb_frames* f, tb_elam_taxel* t, uint16_t* pressures,
                                      uint16_t* status) {
  uint32_t i;
  if (f->gap <= TB_LONGEST_GAP) ++f->gap;
  for (i = 0; i < m->taxels; ++i) {
    status[i] = tb_elam_lose(m, i, &t[i], f->gap > TB_LONGEST_GAP);
    pressures[i] = t[i].at.pressure;
  }
}

/* NOLINTEND(modernize-*,readability-identifier-naming) */
#endif
