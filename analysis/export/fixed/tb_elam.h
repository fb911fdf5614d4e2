/* ELAM in integers, with memory of turns, as the program's stream has it (analysis/compensate/elam_curve.h). Equations:
 * analysis/models/elam.h. */
#ifndef TB_ELAM_H
#define TB_ELAM_H

#include "tb_fixed.h"

/* NOLINTBEGIN(modernize-*,readability-identifier-naming): C's names */

/* x: 65535 at the highest input; outputs: 61440 at the top. */
#define TB_ELAM_X 65535U
#define TB_ELAM_Y 61440U
#define TB_ELAM_POINTS 10U /* when full, the last two, the smallest loop, are forgotten */

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

/* What is searched once a branch: on the pattern the split's x of a rising one or its output of a falling one, and the
 * turn's x of a rising one; the curve's output at the end's x. */
typedef struct {
  uint16_t split, turn, reach;
} tb_elam_shape;

typedef struct {
  tb_taxel at;
  tb_point points[TB_ELAM_POINTS]; /* turns, the first where the branch of the external loop began */
  tb_elam_shape shape;             /* of the present branch */
} tb_elam_taxel;

/* A branch from `from` to `end`, where it closes its loop or ends: the curve of Eqs (31)-(38) from `from` on, its
 * outputs scaled so that it meets `end`. */
typedef struct {
  tb_point from, end;
  uint32_t split_x, split_y;
  tb_elam_shape shape;
} tb_elam_curve;

/* v from one range to another, both rising; ranges that are the same: v itself. */
static inline uint32_t tb_map(uint32_t v, uint32_t low, uint32_t high, uint32_t to_low, uint32_t to_high) {
  if (v <= low) return to_low;
  if (v >= high) return to_high;
  if (low == to_low && high == to_high) return v;
  return to_low + (((to_high - to_low) * (((v - low) << 16) / (high - low))) >> 16);
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
/* The pattern's input of an output, and its output at an input, whose interval is guessed: the knots are even, or
 * nearly. */
static inline uint32_t tb_elam_input(const tb_elam_model* m, const uint16_t* pattern, uint32_t y) {
  const uint32_t k = tb_interval(pattern, m->knots, y);
  return tb_map(y, pattern[k], pattern[k + 1], m->x[k], m->x[k + 1]);
}
static inline uint32_t tb_elam_output(const tb_elam_model* m, const uint16_t* pattern, uint32_t x) {
  uint32_t k = (x * (m->knots - 1U)) >> 16;
  while (k > 0 && m->x[k] > x) --k;
  while (k + 2 < m->knots && m->x[k + 1] <= x) ++k;
  return tb_map(x, m->x[k], m->x[k + 1], pattern[k], pattern[k + 1]);
}

static inline const uint16_t* tb_elam_pattern(const tb_elam_model* m, uint32_t number, int rises) {
  return m->patterns + (2 * number + (rises ? 0U : 1U)) * m->knots;
}

/* `known`: what was searched before; else it is searched. */
TB_INLINE void tb_elam_curve_of(const tb_elam_model* m, uint32_t number, int rises, tb_point from, tb_point end,
                                const tb_elam_shape* known, tb_elam_curve* c) {
  const tb_elam_words* const w = &m->words[number];
  const uint16_t* const pattern = tb_elam_pattern(m, number, rises);
  const uint32_t x = from.x, e = end.x, y = rises && from.u > TB_ELAM_Y ? TB_ELAM_Y : from.u, near_end = 655; /* 0.01 */
  int outer = m->exact_outer;
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
    outer = outer && x <= near_end;
  } else {
    /* Near the top the split is that of a turn at the highest input: within 0.01 of the span, fading out to 0.02. */
    const uint32_t below = y < TB_ELAM_Y ? TB_ELAM_Y - y : 0U;
    const uint32_t x_split = below >= 1228  ? x
                             : below <= 614 ? TB_ELAM_X
                                            : x + (((TB_ELAM_X - x) * ((1228U - below) * 106U)) >> 16);
    c->split_x = (x_split * w->alpha_d) >> 16; /* (14) */
    if (c->split_x > x) c->split_x = x;
    c->split_y = (y * w->beta_d) >> 16; /* (15) */
    outer = outer && TB_ELAM_X - x_split <= near_end;
  }
  if (known) {
    c->shape = *known;
  } else {
    c->shape.split = (uint16_t)(rises ? tb_elam_input(m, pattern, c->split_y) : tb_elam_output(m, pattern, c->split_x));
    c->shape.turn = rises ? (uint16_t)tb_elam_input(m, pattern, y) : from.x;
  }
  if (outer && rises) c->split_x = c->shape.split > x ? c->shape.split : x;
  if (outer && !rises) c->split_y = tb_map(c->shape.split, 0, TB_ELAM_Y, 0, y);
  if (known) return;
  /* (16) to (19), (23) to (26) */
  if (rises ? e >= TB_ELAM_X : e == 0)
    c->shape.reach = (uint16_t)(rises ? TB_ELAM_Y : 0U);
  else if (rises ? e <= x : e >= x)
    c->shape.reach = (uint16_t)y;
  else if (rises)
    c->shape.reach =
        (uint16_t)tb_elam_output(m, pattern,
                                 e <= c->split_x ? tb_map(e, x, c->split_x, c->shape.turn, c->shape.split)
                                                 : tb_map(e, c->split_x, TB_ELAM_X, c->shape.split, TB_ELAM_X));
  else if (e >= c->split_x)
    c->shape.reach = (uint16_t)tb_map(tb_elam_output(m, pattern, tb_map(e, c->split_x, x, c->split_x, TB_ELAM_X)),
                                      c->shape.split, TB_ELAM_Y, c->split_y, y);
  else
    c->shape.reach = (uint16_t)tb_map(tb_elam_output(m, pattern, e), 0, c->shape.split, 0, c->split_y);
}

/* The piece with output y. Between two knots of the pattern, or their images, low < y <= high. */
TB_INLINE tb_piece tb_elam_piece(const tb_elam_model* m, const uint16_t* pattern, int rises, const tb_elam_curve* c,
                                 uint32_t y) {
  const uint32_t from = rises == (c->from.u < c->end.u) ? c->from.u : c->end.u; /* a turn beyond the end: flat */
  const uint32_t low = rises ? from : c->end.u, high = rises ? c->end.u : from;
  const uint32_t of_low = rises ? c->from.u : c->shape.reach, of_high = rises ? c->shape.reach : c->from.u;
  const uint16_t x_low = rises ? c->from.x : c->end.x, x_high = rises ? c->end.x : c->from.x;
  const int scaled = low != of_low || high != of_high;
  uint32_t k, of_curve, y_low, y_high, part_low, part_high, p_low, p_high; /* of the part: outputs, x, on the pattern */
  tb_piece p;
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
  of_curve = scaled ? tb_map(y, low, high, of_low, of_high) : y;
  if (of_curve > c->split_y || (of_curve == c->split_y && !rises)) {
    y_low = c->split_y;
    part_low = c->split_x;
    y_high = rises ? TB_ELAM_Y : c->from.u;
    part_high = rises ? TB_ELAM_X : c->from.x;
    p_low = c->shape.split;
    p_high = rises ? TB_ELAM_X : TB_ELAM_Y;
  } else {
    y_low = rises ? c->from.u : 0U;
    part_low = rises ? c->from.x : 0U;
    y_high = c->split_y;
    part_high = c->split_x;
    p_low = rises ? c->shape.turn : 0U;
    p_high = c->shape.split;
  }
  k = tb_interval(pattern, m->knots, rises ? of_curve : tb_map(of_curve, y_low, y_high, p_low, p_high));
  for (;;) {
    uint32_t own[2], x[2], end;
    for (end = 0; end < 2; ++end) {
      const uint32_t knot = pattern[k + end], at = m->x[k + end], first = rises ? y_low : p_low;
      if (knot <= first) {
        own[end] = y_low;
        x[end] = part_low;
      } else if (knot >= (rises ? y_high : p_high)) {
        own[end] = y_high;
        x[end] = part_high;
      } else if (rises) { /* (36), (38) */
        own[end] = knot;
        x[end] = tb_map(at, p_low, p_high, part_low, part_high);
      } else { /* (31) to (34) */
        own[end] = tb_map(knot, p_low, p_high, y_low, y_high);
        x[end] = y_low == 0 ? at : tb_map(at, part_low, TB_ELAM_X, part_low, part_high);
      }
      if (scaled) own[end] = tb_map(own[end], of_low, of_high, low, high);
    }
    if (y <= own[0] && k > 0 && pattern[k] > (rises ? y_low : p_low)) {
      --k;
    } else if (y > own[1] && k + 2 < m->knots && pattern[k + 1] < (rises ? y_high : p_high)) {
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
/* Of the branch from `from` that `below` turns are before, none of them passed; `known`: its shape, where it was
 * searched. */
TB_INLINE tb_piece tb_elam_branch(const tb_elam_model* m, uint32_t number, const tb_elam_taxel* t, unsigned below,
                                  int rises, tb_point from, uint32_t y, const tb_elam_shape* known,
                                  tb_elam_shape* searched) {
  const tb_point end = tb_elam_end(t, below, rises);
  tb_elam_curve curve;
  tb_piece p;
  tb_elam_curve_of(m, number, rises, from, end, known, &curve);
  *searched = curve.shape;
  p = tb_elam_piece(m, tb_elam_pattern(m, number, rises), rises, &curve, y);
  if (below >= 2) tb_cut(&p, rises, end);
  return p;
}
static inline tb_piece tb_elam_rising(const tb_elam_model* m, uint32_t number, const tb_elam_taxel* t, unsigned below,
                                      tb_point from, uint32_t y, const tb_elam_shape* known, tb_elam_shape* searched) {
  return tb_elam_branch(m, number, t, below, 1, from, y, known, searched);
}
static inline tb_piece tb_elam_falling(const tb_elam_model* m, uint32_t number, const tb_elam_taxel* t, unsigned below,
                                       tb_point from, uint32_t y, const tb_elam_shape* known, tb_elam_shape* searched) {
  return tb_elam_branch(m, number, t, below, 0, from, y, known, searched);
}
/* Of the present branch, whose shape is searched once. */
static inline tb_piece tb_elam_here(const tb_elam_model* m, uint32_t number, tb_elam_taxel* t, uint32_t y) {
  const tb_elam_shape* const known = t->at.flags & TB_SEARCHED ? &t->shape : 0;
  t->at.flags |= TB_SEARCHED;
  return (t->at.flags & TB_RISES ? tb_elam_rising : tb_elam_falling)(m, number, t, t->at.below, t->points[t->at.below],
                                                                     y, known, &t->shape);
}
/* Of the branch from `from`, which `below` turns are before. */
static inline tb_piece tb_elam_find(const tb_elam_model* m, uint32_t number, const tb_elam_taxel* t, unsigned below,
                                    int rises, tb_point from, uint32_t y) {
  const unsigned left = tb_elam_left(t, below, rises, y);
  tb_elam_shape shape = {0, 0, 0};
  return (rises ? tb_elam_rising : tb_elam_falling)(m, number, t, left, left == below ? from : t->points[left], y, 0,
                                                    &shape);
}
/* The branch that turns at y: where it begins, and how many turns are before it. */
static inline unsigned tb_elam_way(const tb_elam_model* m, uint32_t number, tb_elam_taxel* t, uint32_t y,
                                   tb_point* from) {
  const int rises = t->at.flags & TB_RISES;
  const tb_piece on = tb_inside(&t->at.here, y) ? t->at.here : tb_elam_here(m, number, t, y);
  const unsigned below = t->at.below + 1U;
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
  if ((t->at.flags & TB_NOT_KNOWN) && tb_find_history(&w->front, &t->at, y)) {
    t->points[0].x = t->points[0].u = 0;
  }
  tb_follow(&t->at, y);
  zone = tb_zone(&t->at, t->at.mean);
  if (zone == TB_TURNED) {
    tb_point from;
    const unsigned below = tb_elam_way(m, number, t, tb_elam_place(m, w, tb_turn(&t->at)), &from);
    t->points[below] = from;
    t->at.below = (uint8_t)below;
    t->at.flags = (uint8_t)((t->at.flags ^ TB_RISES) & ~TB_SEARCHED);
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
      if (zone >= TB_AHEAD) {
        const unsigned left = tb_elam_left(t, t->at.below, t->at.flags & TB_RISES, u);
        if (left != t->at.below) {
          t->at.below = (uint8_t)left;
          t->at.flags = (uint8_t)(t->at.flags & ~TB_SEARCHED);
        }
      }
      t->at.here = tb_elam_here(m, number, t, u);
    }
    t->at.pressure = (uint16_t)tb_along(&t->at.here, u);
  }
  return (uint16_t)(t->at.flags & TB_NOT_KNOWN ? status | TB_UNKNOWN : status);
}

static inline uint32_t tb_elam_hash(const tb_elam_model* m) {
  uint32_t hash = tb_hash(TB_HASH_START, m->x, m->knots);
  hash = tb_hash(hash, &m->words[0].front.gain, m->taxels * (uint32_t)(sizeof(tb_elam_words) / sizeof(uint16_t)));
  return tb_hash(hash, m->patterns, (uint32_t)m->taxels * m->knots * 2U);
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
/* `count` becomes the zero of an unloaded taxel at rest. 0: it is too far off; the zero stays, the history is unknown.
 */
static inline int tb_elam_tare_taxel(const tb_elam_model* m, uint32_t number, tb_elam_taxel* t, uint32_t count) {
  const tb_front* const w = &m->words[number].front;
  const int taken = w->gain == 0 || tb_set_zero(w, m->count_shift, count ^ m->flip, &t->at);
  tb_elam_start(m, &m->words[number], t, taken);
  return taken;
}
/* How many taxels were too far off. */
static inline uint32_t tb_elam_tare(const tb_elam_model* m, tb_frames* f, tb_elam_taxel* t, const uint16_t* counts) {
  uint32_t i, refused = 0;
  f->phase = f->gap = 0;
  for (i = 0; i < m->taxels; ++i)
    if (!tb_elam_tare_taxel(m, i, &t[i], counts[i])) ++refused;
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
