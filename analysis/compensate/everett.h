// Everett's function of a Preisach model as a table at grid points, its branches' linear pieces, and the staircase of
// turning points: what the dynamic compensator reads. Inputs count in intervals of the grid, from 0 to n.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "analysis/compensate/options.h"
#include "analysis/models/interval.h"

namespace tactbench::analysis {

// Everett's function at grid points, (high i, low j), j <= i <= n: the output's rise from j to i. A view: the table has
// (n + 1) (n + 2) / 2 values, that of (i, j) at i (i + 1) / 2 + j.
template <class Real>
struct Everett {
  const Real* table = nullptr;
  std::size_t n = 0;
  static std::size_t size(std::size_t n) { return (n + 1) * (n + 2) / 2; }
  [[nodiscard]] Real at(std::size_t i, std::size_t j) const { return table[i * (i + 1) / 2 + j]; }
  [[nodiscard]] Real top() const { return at(n, 0); }
};

// x = x_a + slope (u - u_a) for u_low <= u <= u_high.
template <class Real>
struct BranchPiece {
  Real u_low = 0, u_high = 0, u_a = 0, x_a = 0, slope = 0;
  [[nodiscard]] bool holds(Real u) const { return u >= u_low && u <= u_high; }
  [[nodiscard]] Real along(Real u) const { return x_a + slope * (u - u_a); }
};

// The last k <= most <= n for which `holds`, which is true up to it and false beyond; 0 also when nothing else is.
// Looks at every fourth and then at the three between: how often does not depend on the data, so no branch is
// mispredicted.
template <class Holds>
std::size_t last_that(std::size_t most, std::size_t n, const Holds& holds) {
  std::size_t k = 0;
  for (std::size_t at = 4; at <= n; at += 4) k += holds(at) ? 4U : 0U;
  std::size_t more = 0;
  for (std::size_t off = 1; off < 4; ++off) more += holds(k + off) ? 1U : 0U;
  return std::min(k + more, most);
}

// The piece in which the branch from (x0, u0) has output u; beyond the branch's end a constant one.
template <class Real>
BranchPiece<Real> piece_of(const Everett<Real>& e, bool rises, Real x0, Real u0, Real u) {
  constexpr Real kFar = std::numeric_limits<Real>::max();
  const auto n = e.n;
  const std::size_t place = interval_of(x0, n);
  const Real share = x0 - static_cast<Real>(place);
  const auto between = [&](Real xa, Real ea, Real xb, Real eb) {
    // From (xa, ea) to (xb, eb), ea <= eb: Everett's function on the way from the corner.
    const Real sign = rises ? Real(1) : Real(-1), ua = u0 + sign * ea, ub = u0 + sign * eb;
    const Real slope = sign * (ub - ua) > Real(kLeastRise) ? (xb - xa) / (ub - ua) : Real(0);
    return BranchPiece<Real>{std::min(ua, ub), std::max(ua, ub), ua, xa, slope};
  };
  if (rises) {
    const std::size_t j = place;
    const auto line = [&](std::size_t i) { return e.at(i, j) + share * (e.at(i, j + 1) - e.at(i, j)); };  // i > j
    const Real rise = u - u0;
    if (rise > line(n)) return {u0 + line(n), kFar, u0 + line(n), static_cast<Real>(n), Real(0)};
    if (rise < Real(0)) return {-kFar, u0, u0, x0, Real(0)};
    // The last i with line(i) < rise, or j. line(n) >= rise.
    const std::size_t low =
        j + last_that(n - 1 - j, n, [&](std::size_t off) { return line(std::min(j + off, n)) < rise; });
    if (low == j) return between(x0, Real(0), static_cast<Real>(j + 1), line(j + 1));
    const Real kink = e.at(low, j + 1) + (e.at(low + 1, j + 1) - e.at(low, j + 1)) * share +
                      (e.at(low, j) - e.at(low, j + 1)) * (Real(1) - share);
    const Real here = static_cast<Real>(low);
    return rise <= kink ? between(here, line(low), here + share, kink)
                        : between(here + share, kink, here + Real(1), line(low + 1));
  }
  const std::size_t i = place;
  const auto line = [&](std::size_t j) { return e.at(i, j) + share * (e.at(i + 1, j) - e.at(i, j)); };  // j <= i
  const Real fall = u0 - u;
  if (fall > line(0)) return {-kFar, u0 - line(0), u0 - line(0), Real(0), Real(0)};
  if (fall < Real(0)) return {u0, kFar, u0, x0, Real(0)};
  // The last j with line(j) >= fall. line(0) >= fall.
  const std::size_t low = last_that(i, n, [&](std::size_t j) { return (j <= i) & (line(std::min(j, i)) >= fall); });
  const Real here = static_cast<Real>(low);
  if (low == i) return between(x0, Real(0), here, line(i));
  const Real kink = e.at(i, low + 1) + (e.at(i + 1, low + 1) - e.at(i, low + 1)) * share +
                    (e.at(i, low) - e.at(i, low + 1)) * (Real(1) - share);
  return fall >= kink ? between(here + share, kink, here, line(low))
                      : between(here + Real(1), line(low + 1), here + share, kink);
}

// Turning points, minima even and maxima odd, the first the low end; the branch since the last is the current one.
// Of fixed size: when full, the last two, the smallest loop, are forgotten.
template <class Real>
struct Staircase {
  static constexpr std::size_t kMost = 24;
  Real x[kMost] = {}, u[kMost] = {};
  std::uint8_t count = 1;

  [[nodiscard]] bool rises() const { return count % 2 == 1; }
  // How many corners remain when the current branch goes on to u.
  [[nodiscard]] std::uint8_t left_at(Real at) const {
    std::uint8_t left = count;
    if (rises())
      while (left >= 3 && at > u[left - 2]) left = static_cast<std::uint8_t>(left - 2);
    else
      while (left >= 4 && at < u[left - 2]) left = static_cast<std::uint8_t>(left - 2);
    return left;
  }
  void go(Real at) { count = left_at(at); }
  // The branch that has output `at`: its corner, and where the next one wipes it out.
  struct Branch {
    Real x, u, end;
  };
  [[nodiscard]] Branch branch(Real at) const {
    constexpr Real kFar = std::numeric_limits<Real>::max();
    const std::uint8_t left = left_at(at);
    const bool ends = left >= (rises() ? 3 : 4);
    return {x[left - 1], u[left - 1], ends ? u[left - 2] : rises() ? kFar : -kFar};
  }
  [[nodiscard]] BranchPiece<Real> piece(const Everett<Real>& e, Real at) const {
    const Branch from = branch(at);
    BranchPiece<Real> piece = piece_of(e, rises(), from.x, from.u, at);
    (rises() ? piece.u_high : piece.u_low) =
        rises() ? std::min(piece.u_high, from.end) : std::max(piece.u_low, from.end);
    return piece;
  }
  void turn(const Everett<Real>& e, Real at) {
    const Real x_turn = piece(e, at).along(at);
    turn_at(x_turn, at);
  }
  void turn_at(Real x_turn, Real at) {
    go(at);
    if (!rises() && x_turn <= Real(0)) {
      count = 1;
      return;
    }
    if (count == kMost) count = static_cast<std::uint8_t>(count - 2);
    x[count] = x_turn;
    u[count] = at;
    ++count;
  }
  void start_low(Real u_low) {
    count = 1;
    x[0] = Real(0);
    u[0] = u_low;
  }
  void start_high(const Everett<Real>& e, Real u_low) {
    start_low(u_low);
    turn_at(static_cast<Real>(e.n), u_low + e.top());
  }
};

}  // namespace tactbench::analysis
