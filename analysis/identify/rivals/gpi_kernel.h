// GPI along the tree of states for any vector type; gpi_lanes.cpp compiles it once a level. All is inlined into the one
// function that carries the level's target.
#pragma once

#include "analysis/identify/elam/lanes_kernel.h"
#include "analysis/identify/rivals/gpi_lanes.h"

namespace tactbench::analysis::kernel {

// e^x for x in -700..700: Cody and Waite's reduction, Taylor's polynomial on |r| < 0.35, to the last place or two.
template <int N, class V = typename Lanes<N>::Value, class M = typename Lanes<N>::Mask>
TACTBENCH_INLINE V exponential(const V& x) {
  constexpr double kShift = 6755399441055744.0;  // 1.5 x 2^52: what is added to it is rounded to a whole number
  const V shifted = x * 1.4426950408889634 + kShift, whole = shifted - kShift;
  const V r = (x - whole * 0.693147180369123816490) - whole * 1.90821492927058770002e-10;
  V sum = r * (1.0 / 479001600.0) + 1.0 / 39916800.0;
  for (const double term : {1.0 / 3628800.0, 1.0 / 362880.0, 1.0 / 40320.0, 1.0 / 5040.0, 1.0 / 720.0, 1.0 / 120.0,
                            1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0, 1.0})
    sum = sum * r + term;
  M bits, power;
  __builtin_memcpy(&bits, &sum, sizeof(V));
  __builtin_memcpy(&power, &shifted, sizeof(V));
  bits += power << 52;
  V result;
  __builtin_memcpy(&result, &bits, sizeof(V));
  return result;
}

// What of an operator's output depends on which unknown: envelope by ln a, l0, ln dl, ln b, r0, ln dr.
constexpr int kFields = 6;
// In an envelope table, and in a slot an operator: the value and its derivatives.
constexpr int kValues = 2;

template <int N, bool kGradient>
TACTBENCH_INLINE void envelopes(GpiLanes& lanes, std::size_t lane) {
  using V = typename Lanes<N>::Value;
  constexpr int kRow = kGradient ? kFields : kValues;
  for (const bool is_left : {true, false}) {
    V ln_a, start, ln_rise;
    load(ln_a, &lanes.unknown[is_left ? kLnA : kLnB][lane]);
    load(start, &lanes.unknown[is_left ? kL0 : kR0][lane]);
    load(ln_rise, &lanes.unknown[is_left ? kLnDl : kLnDr][lane]);
    const V a = exponential<N>(ln_a), rise = exponential<N>(ln_rise), end = exponential<N>(-a);
    const V per_whole = 1.0 / (1.0 - end);
    double* row = lanes.envelopes.data() + (is_left ? 0 : N);
    for (const double u : lanes.tree->knots) {
      const V rest = exponential<N>(-a * u), shape = (1.0 - rest) * per_whole;
      store(row, V(start + rise * shape));
      if constexpr (kGradient) {
        store(row + 2 * N, V(rise * a * (u * rest - shape * end) * per_whole));
        store(row + 4 * N, V(rise * shape));
      }
      row += kRow * N;
    }
  }
}

template <int N, bool kGradient>
struct Plays {
  using V = typename Lanes<N>::Value;
  using M = typename Lanes<N>::Mask;
  V output[kGpiOperators];
  V field[kGradient ? kGpiOperators : 1][kFields];
};

template <class V, class M>
TACTBENCH_INLINE V chosen(const M& mask, const V& value) {
  M bits;
  __builtin_memcpy(&bits, &value, sizeof(V));
  bits &= mask;
  V result;
  __builtin_memcpy(&result, &bits, sizeof(V));
  return result;
}

template <int N, bool kGradient>
TACTBENCH_INLINE void gpi_walk(GpiLanes& lanes, const GpiTree::Target& target, std::size_t lane) {
  using V = typename Lanes<N>::Value;
  using M = typename Lanes<N>::Mask;
  constexpr int kRow = kGradient ? kFields : kValues, kSlot = kGpiOperators * (kGradient ? 1 + kFields : 1);
  const GpiTree& tree = *lanes.tree;
  const V zero{}, one = zero + 1.0;
  V threshold[kGpiOperators], density[kGpiOperators];
  V ln_alpha, s_of;
  load(ln_alpha, &lanes.unknown[kLnAlpha][lane]);
  load(s_of, &lanes.unknown[kS][lane]);
  const V alpha = exponential<N>(ln_alpha), fall = exponential<N>(-s_of);
  for (int i = 0; i < kGpiOperators; ++i) {
    threshold[i] = alpha * static_cast<double>(i);
    density[i] = i == 0 ? one : density[i - 1] * fall;
  }
  envelopes<N, kGradient>(lanes, lane);
  V j = zero + target.constant, normal[kGpiNormals], slope[kGpiUnknowns];
  for (V& value : normal) value = zero;
  for (V& value : slope) value = zero;
  for (const GpiTree::Node& node : tree.nodes) {
    Plays<N, kGradient> here;
    for (V& value : here.output) value = zero;
    for (auto& fields : here.field)
      for (V& value : fields) value = zero;
    if (node.from != GpiTree::kVirgin) {
      const double* slot = lanes.slots.data() + static_cast<std::size_t>(node.from) * kSlot * N;
      for (int i = 0; i < kGpiOperators; ++i) {
        load(here.output[i], slot);
        slot += N;
        for (int f = 0; kGradient && f < kFields; ++f, slot += N) load(here.field[i][f], slot);
      }
    }
    {
      const double* row = lanes.envelopes.data() + static_cast<std::size_t>(node.knot) * kRow * N;
      V left, right, by[4];
      load(left, row);
      load(right, row + N);
      for (int k = 0; kGradient && k < 4; ++k) load(by[k], row + (2 + k) * N);
      double* slot = lanes.slots.data() + static_cast<std::size_t>(node.slot) * kSlot * N;
      for (int i = 0; i < kGpiOperators; ++i) {
        const V up = right + threshold[i], low = left - threshold[i];
        const M on_right = here.output[i] > up;
        const V most = here.output[i] > up ? up : here.output[i];
        const M on_left = low > most;
        here.output[i] = low > most ? low : most;
        store(slot, here.output[i]);
        slot += N;
        if constexpr (kGradient) {
          const M held = ~(on_left | on_right), falls = on_right & ~on_left;
          V* field = here.field[i];
          for (int f = 0; f < kFields; ++f) field[f] = chosen(held, field[f]);
          field[0] += chosen(on_left, by[0]);
          field[1] += chosen(on_left, one);
          field[2] += chosen(on_left, by[2]);
          field[3] += chosen(falls, by[1]);
          field[4] += chosen(falls, one);
          field[5] += chosen(falls, by[3]);
          for (int f = 0; f < kFields; ++f, slot += N) store(slot, field[f]);
        }
      }
    }
    V kept[kGradient ? kGpiOperators : 1][kFields + 1];
    for (int i = 0; kGradient && i < kGpiOperators; ++i) {
      for (int f = 0; f < kFields; ++f) kept[i][f] = density[i] * here.field[i][f];
      kept[i][kFields] = threshold[i] * (kept[i][4] - kept[i][1]);
    }
    for (std::size_t s = node.first; s < node.end; ++s) {
      const double* row = lanes.envelopes.data() + static_cast<std::size_t>(tree.steps[s].knot) * kRow * N;
      V left, right;
      load(left, row);
      load(right, row + N);
      V off = zero - target.mean[s], on_left_sum = zero, on_right_sum = zero, by_s = zero, by_alpha = zero;
      V held_sum[kFields];
      for (V& value : held_sum) value = zero;
      for (int i = 0; i < kGpiOperators; ++i) {
        const V up = right + threshold[i], low = left - threshold[i];
        const V most = here.output[i] > up ? up : here.output[i];
        const V output = density[i] * (low > most ? low : most);
        off += output;
        if constexpr (kGradient) {
          const M on_right = here.output[i] > up, on_left = low > most, held = ~(on_left | on_right);
          const V rises = chosen(on_left, density[i]), falls = chosen(M(on_right & ~on_left), density[i]);
          on_left_sum += rises;
          on_right_sum += falls;
          by_alpha += threshold[i] * (falls - rises) + chosen(held, kept[i][kFields]);
          by_s -= output * static_cast<double>(i);
          for (int f = 0; f < kFields; ++f) held_sum[f] += chosen(held, kept[i][f]);
        }
      }
      const double weight = tree.steps[s].weight;
      const V weighted = off * weight;
      j += weighted * off;
      if constexpr (kGradient) {
        V by[4];
        for (int k = 0; k < 4; ++k) load(by[k], row + (2 + k) * N);
        const V own[kGpiUnknowns] = {by[0] * on_left_sum + held_sum[0],
                                     on_left_sum + held_sum[1],
                                     by[2] * on_left_sum + held_sum[2],
                                     by[1] * on_right_sum + held_sum[3],
                                     on_right_sum + held_sum[4],
                                     by[3] * on_right_sum + held_sum[5],
                                     by_alpha,
                                     by_s};
        for (int a = 0, k = 0; a < kGpiUnknowns; ++a) {
          slope[a] += weighted * own[a];
          const V much = own[a] * weight;
          for (int b = 0; b <= a; ++b, ++k) normal[k] += much * own[b];
        }
      }
    }
  }
  store(&lanes.j[lane], j);
  if constexpr (kGradient) {
    for (std::size_t k = 0; k < kGpiNormals; ++k) store(&lanes.normal[k][lane], normal[k]);
    for (std::size_t k = 0; k < kGpiUnknowns; ++k) store(&lanes.slope[k][lane], slope[k]);
  }
}

}  // namespace tactbench::analysis::kernel
