/* ELAM in integers, with memory of turns, as the program's stream has it (analysis/compensate/curves.h). Equations:
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

/* v from one range to another that is not the same, both rising. */
TB_INLINE uint32_t tb_scale(uint32_t v, uint32_t low, uint32_t high, uint32_t to_low, uint32_t to_high) {
  const uint32_t way = v - low, whole = high - low;
  if (way >= whole) return v <= low ? to_low : to_high;
  return to_low + (((to_high - to_low) * tb_r16(way, whole)) >> 16);
}
/* The same; of ranges that are the same, v itself. */
static inline uint32_t tb_map(uint32_t v, uint32_t low, uint32_t high, uint32_t to_low, uint32_t to_high) {
  const uint32_t way = v - low, whole = high - low;
  if (way >= whole) return v <= low ? to_low : to_high;
  if (low == to_low && high == to_high) return v;
  return to_low + (((to_high - to_low) * tb_r16(way, whole)) >> 16);
}
/* Of `*left` intervals the last `size`, where they are more and v lies there, or else the first. */
TB_INLINE const uint16_t* tb_halve(const uint16_t* from, uint32_t* left, uint32_t size, uint32_t v) {
  const uint32_t over = *left - size;
  if (*left <= size) return from;
  *left = size;
  return from[over] <= v ? from + over : from;
}
/* The last of n knots, but for the very last, that is not above v; else the first. No loop for up to 65: where their
 * number is a constant, as in an exported model, four instructions a step. */
TB_INLINE uint32_t tb_interval(const uint16_t* knots, uint32_t n, uint32_t v) {
  const uint16_t* at = knots;
  uint32_t left = n - 1;
  while (left > 64) at = tb_halve(at, &left, left - left / 2, v);
  at = tb_halve(at, &left, 32, v);
  at = tb_halve(at, &left, 16, v);
  at = tb_halve(at, &left, 8, v);
  at = tb_halve(at, &left, 4, v);
  at = tb_halve(at, &left, 2, v);
  at = tb_halve(at, &left, 1, v);
  return (uint32_t)(at - knots);
}
/* The pattern's input of an output, and its output at an input. */
static inline uint32_t tb_elam_input(const tb_elam_model* m, const uint16_t* pattern, uint32_t y) {
  const uint32_t k = tb_interval(pattern, m->knots, y);
  return tb_map(y, pattern[k], pattern[k + 1], m->x[k], m->x[k + 1]);
}
static inline uint32_t tb_elam_output(const tb_elam_model* m, const uint16_t* pattern, uint32_t x) {
  const uint32_t k = tb_interval(m->x, m->knots, x);
  return tb_map(x, m->x[k], m->x[k + 1], pattern[k], pattern[k + 1]);
}

/* A point of a branch's curve: output, input, and its place on the pattern, which is the input there of a rising
 * branch, the output of a falling one. */
typedef struct {
  uint32_t u, x, place;
} tb_elam_mark;

/* A knot of the pattern, or the nearer end of the part where it lies outside: its output and its input on the curve. */
TB_INLINE uint32_t tb_elam_output_of(int rises, uint32_t knot, tb_elam_mark low, tb_elam_mark high) {
  if (rises) return knot <= low.u ? low.u : knot >= high.u ? high.u : knot; /* (36), (38) */
  return tb_map(knot, low.place, high.place, low.u, high.u);                /* (31) to (34) */
}
TB_INLINE uint32_t tb_elam_input_of(int rises, uint32_t knot, uint32_t at, tb_elam_mark low, tb_elam_mark high) {
  if (knot <= (rises ? low.u : low.place)) return low.x;
  if (knot >= (rises ? high.u : high.place)) return high.x;
  if (rises) return tb_map(at, low.place, high.place, low.x, high.x);
  return low.u == 0 ? at : tb_map(at, low.x, TB_ELAM_X, low.x, high.x);
}

/* v, low < v < high, as tb_scale() has it, and the least of the other range that tb_scale() back brings to v or above:
 * the same with both roundings up. */
TB_INLINE uint32_t tb_scale_both(uint32_t v, uint32_t low, uint32_t high, uint32_t to_low, uint32_t to_high,
                                 uint32_t* least) {
  const uint32_t way = v - low, whole = high - low, ratio = tb_r16(way, whole), range = to_high - to_low;
  const uint32_t up = ratio * range;
  *least = to_low + ((up + (ratio * whole == way << 16 ? 0U : range) + 65535U) >> 16);
  return to_low + (up >> 16);
}

/* A branch from `from` to `end`, where it closes its loop or ends: the curve of Eqs (31)-(38) from `from` on, its
 * outputs scaled so that it meets `end`. The piece with output y: between two knots of the pattern, or their images,
 * low < y <= high; what closes a loop cuts it. `shape` is searched where it is not known. */
TB_INLINE void tb_elam_branch(const tb_elam_model* m, uint32_t number, int rises, tb_point from, tb_point end,
                              int closes, uint32_t y, int known, tb_elam_shape* shape, tb_piece* p) {
  const tb_elam_words* const w = &m->words[number];
  const uint16_t* const pattern = m->patterns + (2 * number + (rises ? 0U : 1U)) * m->knots;
  const uint32_t near_end = 655; /* 0.01 */
  uint32_t low, high, of_low, of_high, x_low, x_high, k, of_curve, first, last, least, knot, u, x;
  tb_elam_mark begin, split, edge, under, over;
  int outer = m->exact_outer, scaled;
  begin.u = rises && from.u > TB_ELAM_Y ? TB_ELAM_Y : from.u;
  begin.x = from.x;
  edge.u = rises ? TB_ELAM_Y : 0U;
  edge.x = edge.place = rises ? TB_ELAM_X : 0U;
  if (rises) {
    const uint32_t length = TB_ELAM_X - begin.x;
    const uint32_t share = w->split_long >= w->split_short
                               ? w->split_short + ((length * (uint32_t)(w->split_long - w->split_short)) >> 16)
                               : w->split_short - ((length * (uint32_t)(w->split_short - w->split_long)) >> 16);
    split.x = begin.x + ((length * share) >> 16);                    /* (21) */
    split.u = begin.u + (((TB_ELAM_Y - begin.u) * w->beta_a) >> 16); /* (22) */
    outer = outer && begin.x <= near_end;
  } else {
    /* Near the top the split is that of a turn at the highest input: within 0.01 of the span, fading out to 0.02. */
    const uint32_t below = begin.u < TB_ELAM_Y ? TB_ELAM_Y - begin.u : 0U;
    const uint32_t x_split = below >= 1228  ? begin.x
                             : below <= 614 ? TB_ELAM_X
                                            : begin.x + (((TB_ELAM_X - begin.x) * ((1228U - below) * 106U)) >> 16);
    split.x = (x_split * w->alpha_d) >> 16; /* (14) */
    if (split.x > begin.x) split.x = begin.x;
    split.u = (begin.u * w->beta_d) >> 16; /* (15) */
    outer = outer && TB_ELAM_X - x_split <= near_end;
  }
  if (!known) {
    shape->split = (uint16_t)(rises ? tb_elam_input(m, pattern, split.u) : tb_elam_output(m, pattern, split.x));
    if (rises) shape->turn = (uint16_t)tb_elam_input(m, pattern, begin.u);
  }
  split.place = shape->split;
  begin.place = rises ? shape->turn : TB_ELAM_Y;
  if (outer && rises) split.x = split.place > begin.x ? split.place : begin.x;
  if (outer && !rises) split.u = tb_map(split.place, 0, TB_ELAM_Y, 0, begin.u);
  if (!known) { /* (16) to (19), (23) to (26) */
    uint32_t reach;
    if (rises ? end.x >= TB_ELAM_X : end.x == 0)
      reach = edge.u;
    else if (rises ? end.x <= begin.x : end.x >= begin.x)
      reach = begin.u;
    else if (rises)
      reach = tb_elam_output(m, pattern,
                             end.x <= split.x ? tb_map(end.x, begin.x, split.x, begin.place, split.place)
                                              : tb_map(end.x, split.x, TB_ELAM_X, split.place, TB_ELAM_X));
    else if (end.x >= split.x)
      reach = tb_map(tb_elam_output(m, pattern, tb_map(end.x, split.x, begin.x, split.x, TB_ELAM_X)), split.place,
                     TB_ELAM_Y, split.u, begin.u);
    else
      reach = tb_map(tb_elam_output(m, pattern, end.x), 0, split.place, 0, split.u);
    shape->reach = (uint16_t)reach;
  }
  low = rises && begin.u < end.u ? begin.u : end.u; /* a turn beyond the end: flat */
  high = !rises && begin.u > end.u ? begin.u : end.u;
  of_low = rises ? begin.u : shape->reach;
  of_high = rises ? shape->reach : begin.u;
  x_low = rises ? from.x : end.x;
  x_high = rises ? end.x : from.x;
  if (y <= low || y >= high || of_high <= of_low) {
    p->low = (uint16_t)low;
    p->high = (uint16_t)high;
    p->x_low = (uint16_t)x_low;
    p->x_high = (uint16_t)x_high;
    if (y <= low) {
      p->low = (uint16_t)(closes && !rises ? low : 0U);
      p->high = (uint16_t)low;
      p->x_high = (uint16_t)x_low;
    } else if (y >= high) {
      p->low = (uint16_t)high;
      p->high = (uint16_t)(closes && rises ? high : 65535U);
      p->x_low = (uint16_t)x_high;
    } /* else it rises too little to be scaled: linear [A12] */
    return;
  }
  scaled = low != of_low || high != of_high;
  of_curve = least = y;
  if (scaled) of_curve = tb_scale_both(y, low, high, of_low, of_high, &least);
  if (of_curve > split.u || (of_curve == split.u && !rises)) {
    under = split;
    over = rises ? edge : begin;
  } else {
    under = rises ? begin : edge;
    over = split;
  }
  /* The last knot of the pattern whose output is below y, or that lies before the part. */
  first = rises ? under.u : under.place;
  last = rises ? over.u : over.place;
  if (least <= under.u)
    least = 0;
  else if (least >= over.u)
    least = last;
  else if (!rises && (under.u != under.place || over.u != over.place))
    (void)tb_scale_both(least, under.u, over.u, under.place, over.place, &least);
  k = tb_interval(pattern, m->knots, least > first ? least - 1U : first);
  knot = pattern[k];
  u = tb_elam_output_of(rises, knot, under, over);
  x = tb_elam_input_of(rises, knot, m->x[k], under, over);
  if (scaled) u = tb_scale(u, of_low, of_high, low, high);
  if (closes && !rises && u < low) u = low;
  if (x > x_low) x_low = x;
  p->low = (uint16_t)u;
  p->x_low = (uint16_t)x_low;
  knot = pattern[k + 1];
  u = tb_elam_output_of(rises, knot, under, over);
  x = tb_elam_input_of(rises, knot, m->x[k + 1], under, over);
  if (scaled) u = tb_scale(u, of_low, of_high, low, high);
  if (closes && rises && u > high) u = high;
  if (x > x_high) x = x_high;
  p->high = (uint16_t)u;
  p->x_high = (uint16_t)(x < x_low ? x_low : x);
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
static inline void tb_elam_rising(const tb_elam_model* m, uint32_t number, tb_point from, tb_point end, int closes,
                                  uint32_t y, int known, tb_elam_shape* shape, tb_piece* p) {
  tb_elam_branch(m, number, 1, from, end, closes, y, known, shape, p);
}
static inline void tb_elam_falling(const tb_elam_model* m, uint32_t number, tb_point from, tb_point end, int closes,
                                   uint32_t y, int known, tb_elam_shape* shape, tb_piece* p) {
  tb_elam_branch(m, number, 0, from, end, closes, y, known, shape, p);
}
/* Of the branch from `from` that `below` turns are before, none of them passed. */
static inline void tb_elam_find(const tb_elam_model* m, uint32_t number, const tb_elam_taxel* t, unsigned below,
                                int rises, tb_point from, uint32_t y, int known, tb_elam_shape* shape, tb_piece* p) {
  const tb_point end = tb_elam_end(t, below, rises);
  if (rises)
    tb_elam_rising(m, number, from, end, below >= 2, y, known, shape, p);
  else
    tb_elam_falling(m, number, from, end, below >= 2, y, known, shape, p);
}
/* Of the present branch, whose shape is searched once. */
static inline void tb_elam_here(const tb_elam_model* m, uint32_t number, tb_elam_taxel* t, uint32_t y, tb_piece* p) {
  const int known = t->at.flags & TB_SEARCHED;
  t->at.flags |= TB_SEARCHED;
  tb_elam_find(m, number, t, t->at.below, t->at.flags & TB_RISES, t->points[t->at.below], y, known, &t->shape, p);
}
/* The branch that turns at y: where it begins, and how many turns are before it. */
static inline unsigned tb_elam_way(const tb_elam_model* m, uint32_t number, tb_elam_taxel* t, uint32_t y,
                                   tb_point* from) {
  const int rises = t->at.flags & TB_RISES;
  const unsigned below = t->at.below + 1U;
  tb_piece on = t->at.here;
  if (!tb_inside(&on, y)) tb_elam_here(m, number, t, y, &on);
  from->x = (uint16_t)tb_along(&on, y);
  from->u = (uint16_t)y;
  if (rises ? from->x >= TB_ELAM_X : from->x == 0) return 0;
  return below < TB_ELAM_POINTS ? below : below - 2U;
}

static inline uint32_t tb_elam_place(const tb_elam_model* m, const tb_elam_words* w, int32_t y) {
  return y > 0 ? (uint32_t)(tb_m((int32_t)((uint32_t)y << m->place_shift), w->front.place) >> 4) : 0U;
}

/* How the history begins: at rest, or not known. */
TB_OUTLINE void tb_elam_start(const tb_elam_model* m, const tb_elam_words* w, tb_elam_taxel* t, int known) {
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
      const int rises = !(t->at.flags & TB_RISES);
      const unsigned left = tb_elam_left(t, below, rises, u);
      tb_elam_shape shape = {0, 0, 0};
      if (left != below) from = t->points[left];
      tb_elam_find(m, number, t, left, rises, from, u, 0, &shape, &t->at.there);
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
      tb_elam_here(m, number, t, u, &t->at.here);
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
