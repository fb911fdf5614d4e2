// The lane functions for any vector type; lanes.cpp compiles them once a level. All is inlined into the one function
// that carries the level's target, so that no code of a higher level can slip into a lower one.
#pragma once

#include "analysis/identify/elam/lanes.h"

#define TACTBENCH_INLINE inline __attribute__((always_inline))

namespace tactbench::analysis::kernel {

template <int N>
struct Lanes {
  typedef double Value __attribute__((vector_size(N * sizeof(double))));
  typedef long long Mask __attribute__((vector_size(N * sizeof(double))));
  typedef int Index __attribute__((vector_size(N * sizeof(int))));
};

template <class V>
TACTBENCH_INLINE void load(V& to, const double* from) {
  __builtin_memcpy(&to, from, sizeof(V));
}
template <class V>
TACTBENCH_INLINE void store(double* to, const V& from) {
  __builtin_memcpy(to, &from, sizeof(V));
}

// One row of two a lane. Loads of whole rows and shuffles: faster than the gather instructions.
template <int N>
TACTBENCH_INLINE void gather(const double* rows, const typename Lanes<N>::Index& index, typename Lanes<N>::Value& first,
                             typename Lanes<N>::Value& second) {
  if constexpr (N == 2) {
    typename Lanes<2>::Value row[2];
    for (int k = 0; k < 2; ++k) load(row[k], rows + 2 * index[k]);
    first = __builtin_shufflevector(row[0], row[1], 0, 2);
    second = __builtin_shufflevector(row[0], row[1], 1, 3);
  } else {
    typename Lanes<N / 2>::Index half;
    typename Lanes<N / 2>::Value low[2], high[2];
    for (int k = 0; k < N / 2; ++k) half[k] = index[k];
    gather<N / 2>(rows, half, low[0], low[1]);
    for (int k = 0; k < N / 2; ++k) half[k] = index[N / 2 + k];
    gather<N / 2>(rows, half, high[0], high[1]);
    if constexpr (N == 4) {
      first = __builtin_shufflevector(low[0], high[0], 0, 1, 2, 3);
      second = __builtin_shufflevector(low[1], high[1], 0, 1, 2, 3);
    } else {
      first = __builtin_shufflevector(low[0], high[0], 0, 1, 2, 3, 4, 5, 6, 7);
      second = __builtin_shufflevector(low[1], high[1], 0, 1, 2, 3, 4, 5, 6, 7);
    }
  }
}

// Start and rise of the segment that holds u, and how far into it u lies (in segments). `per` is 1 / width.
template <int N, bool kUniform, class V = typename Lanes<N>::Value>
TACTBENCH_INLINE void look_up(const LaneTable& table, const double* rows, const V& u, V& start, V& rise, V& part,
                              V& per) {
  if constexpr (kUniform) {
    const auto index = __builtin_convertvector(u, typename Lanes<N>::Index);  // rounding beyond the range: 0, or xu's
    part = u - __builtin_convertvector(index, V);
    gather<N>(rows, index, start, rise);
  } else {
    for (int k = 0; k < N; ++k) {
      const std::size_t i = table.segment(u[k]);
      start[k] = rows[2 * i];
      rise[k] = rows[2 * i + 1];
      per[k] = table.places()[2 * i + 1];
      part[k] = (u[k] - table.places()[2 * i]) * per[k];
    }
  }
}

template <int N>
TACTBENCH_INLINE void bounds(const typename Lanes<N>::Value& values, double& low, double& high) {
  low = high = values[0];
  for (int k = 1; k < N; ++k) {
    low = values[k] < low ? values[k] : low;
    high = values[k] > high ? values[k] : high;
  }
}

template <int N, bool kUniform>
TACTBENCH_INLINE void descending(const LaneProblem& p, const double* alphas, std::size_t count, double* js,
                                 double* betas) {
  using V = typename Lanes<N>::Value;
  const V zero{}, one = zero + 1.0;
  const double* rows = p.table.rows();
  const double nothing = 1e-12 * (p.xu - p.x0);
  for (std::size_t at = 0; at < count; at += N) {
    V alpha;
    load(alpha, alphas + at);
    V rr = zero + p.constant, gr = zero, gg = zero;  // of residuals at beta_d = 1 and their slopes
    for (const LaneCurve& curve : p.curves) {
      const V xs = p.x0 + alpha * (curve.x_turn - p.x0);  // (14)
      V start, rise, part, per = one;
      look_up<N, kUniform>(p.table, rows, xs, start, rise, part, per);
      const V ysp = start + rise * part;
      const V right_x = curve.x_turn - xs, left_x = xs - p.x0, right_y = p.yu - ysp, left_y = ysp - p.y0;
      const auto right_flat = right_y <= p.smallest_rise, left_flat = left_y <= p.smallest_rise;
      const V by_right_x = 1.0 / (right_x > nothing ? right_x : zero + nothing);
      const V by_left_x = 1.0 / (left_x > nothing ? left_x : zero + nothing);
      const V by_right_y = 1.0 / (right_flat ? one : right_y), by_left_y = 1.0 / (left_flat ? one : left_y);
      const V stretch = (p.xu - xs) * by_right_x;
      double low = 0.0, high = 0.0;
      bounds<N>(xs, low, high);
      for (std::size_t i = curve.first; i < curve.end; ++i) {
        const double x = p.x[i], weight = p.weight[i];
        V slope = zero, residual = zero;
        if (x < high) {  // left of the split in some lane, Eqs (18), (19)
          slope = curve.rise * (left_flat ? (x - p.x0) * by_left_x : p.pattern[i] * by_left_y);
          residual = (p.y[i] - p.y0) - slope;
        }
        if (x >= low) {  // Eqs (16), (17): flat at y_turn for beta_d = 1
          const auto right = xs <= x;
          const V off = right ? x - xs : zero;  // a lane left of the split must read a valid entry, too
          look_up<N, kUniform>(p.table, rows, xs + stretch * off, start, rise, part, per);
          const V share = right_flat ? off * by_right_x : (start + rise * part - ysp) * by_right_y;
          slope = right ? curve.rise * (1.0 - share) : slope;
          residual = right ? zero + (p.y[i] - curve.y_turn) : residual;
        }
        const V weighted = weight * slope;
        rr += weight * residual * residual;
        gr += weighted * residual;
        gg += weighted * slope;
      }
    }
    V step = gr / (gg > 0.0 ? gg : one);  // of beta_d, from 1
    step = step < 0.0 ? step : zero;
    step = step > -1.0 ? step : zero - 1.0;
    const V j = rr + step * (gg * step - 2.0 * gr);
    store(js + at, j);
    store(betas + at, V(1.0 + step));
  }
}

template <int N, bool kUniform, Gradient kGradient>
TACTBENCH_INLINE void ascending(AscendingLanes& lanes, std::size_t count) {
  using V = typename Lanes<N>::Value;
  const LaneProblem& p = *lanes.problem;
  const V zero{}, one = zero + 1.0;
  const double* rows = p.table.rows();
  const double nothing = 1e-12 * (p.xu - p.x0);
  for (std::size_t at = 0; at < count; at += N) {
    V u, v, j = zero + p.constant;
    load(u, &lanes.u[at]);
    load(v, &lanes.v[at]);
    V normal[6] = {zero, zero, zero, zero, zero, zero}, right[3] = {zero, zero, zero};
    std::size_t from = at;  // in splits and by_beta, which are empty where there are no curves
    for (const LaneCurve& curve : p.curves) {
      V split, by_beta;
      load(split, lanes.splits.data() + from);
      load(by_beta, lanes.by_beta.data() + from);
      from += lanes.stride;
      const V xs = curve.x_turn + (u + (v - u) * curve.share) * curve.length;  // (21)
      const V left_x = xs - curve.x_turn, right_x = p.xu - xs;
      const V by_left = 1.0 / (left_x > nothing ? left_x : zero + nothing);
      const V by_right = 1.0 / (right_x > nothing ? right_x : zero + nothing);
      const V left_stretch = (split - curve.x_pattern) * by_left, right_stretch = (p.xu - split) * by_right;
      double low = 0.0, high = 0.0;
      bounds<N>(xs, low, high);
      // Sums of weight x (dy/dsplit)^2 and weight x residual x dy/dsplit, on either side of the split; dy/dxs is
      // -stretch x dy/dsplit.
      V left_qq = zero, left_rq = zero, right_qq = zero, right_rq = zero;
      for (std::size_t i = curve.first; i < curve.end; ++i) {
        const double x = p.x[i], weight = p.weight[i];
        V start = zero, rise = zero, part = zero, per = one, pattern = zero, inside = zero;
        const double off = x - curve.x_turn;
        if (x <= low) {  // left of the split in all lanes, Eqs (25), (26)
          pattern = curve.x_pattern + left_stretch * off;
          if constexpr (kGradient != Gradient::kNone) inside = off * by_left;
        } else if (x > high) {  // Eqs (23), (24)
          pattern = split + right_stretch * (x - xs);
          if constexpr (kGradient != Gradient::kNone) inside = 1.0 - (x - xs) * by_right;
        } else {
          const auto left = xs >= x;
          pattern = left ? curve.x_pattern + left_stretch * off : split + right_stretch * (x - xs);
          if constexpr (kGradient != Gradient::kNone) inside = left ? off * by_left : 1.0 - (x - xs) * by_right;
        }
        look_up<N, kUniform>(p.table, rows, pattern, start, rise, part, per);
        const V residual = p.y[i] - (start + rise * part);
        const V weighted = weight * residual;
        j += weighted * residual;
        if constexpr (kGradient != Gradient::kNone) {
          const V q = (kUniform ? rise : rise * per) * inside;
          const V qq = weight * q * q, rq = weighted * q;
          if (x <= low) {
            left_qq += qq;
            left_rq += rq;
          } else if (x > high) {
            right_qq += qq;
            right_rq += rq;
          } else {
            const auto left = xs >= x;
            left_qq += left ? qq : zero;
            left_rq += left ? rq : zero;
            right_qq += left ? zero : qq;
            right_rq += left ? zero : rq;
          }
        }
      }
      if constexpr (kGradient != Gradient::kNone) {
        const double by_u = curve.length * (1.0 - curve.share), by_v = curve.length * curve.share;
        const V ll = left_stretch * left_stretch * left_qq + right_stretch * right_stretch * right_qq;
        const V l = -(left_stretch * left_rq + right_stretch * right_rq);
        normal[0] += ll * (by_u * by_u);
        normal[1] += ll * (by_u * by_v);
        normal[2] += ll * (by_v * by_v);
        right[0] += l * by_u;
        right[1] += l * by_v;
        if constexpr (kGradient == Gradient::kSpace) {
          const V ls = -(left_stretch * left_qq + right_stretch * right_qq) * by_beta;
          normal[3] += ls * by_u;
          normal[4] += ls * by_v;
          normal[5] += (left_qq + right_qq) * by_beta * by_beta;
          right[2] += (left_rq + right_rq) * by_beta;
        }
      }
    }
    store(&lanes.j[at], j);
    if constexpr (kGradient != Gradient::kNone) {
      constexpr int kNormal = kGradient == Gradient::kSpace ? 6 : 3, kRight = kGradient == Gradient::kSpace ? 3 : 2;
      for (int k = 0; k < kNormal; ++k) store(&lanes.normal[static_cast<std::size_t>(k)][at], normal[k]);
      for (int k = 0; k < kRight; ++k) store(&lanes.right[static_cast<std::size_t>(k)][at], right[k]);
    }
  }
}

}  // namespace tactbench::analysis::kernel
