// External Loop Adaptation Method, Sanchez-Duran et al., Sensors 2015: direct model Eqs (9)-(28) and inverse (29)-(39)
// in the general form with (x0, y0) [A4], [A5]. Pressure in psi, output in volts; x0, xu are the ends of the pattern
// grid, y0, yu the measured ends common to both patterns.
#pragma once

#include <array>

#include "analysis/models/pattern_curve.h"

namespace tactbench::analysis {

struct ElamParameters {
  double alpha_d = 0.5;    // Eq. (14), 0..1
  double beta_d = 0.5;     // Eq. (15), 0..1
  double alpha_a1 = 0.0;   // Eq. (21), 1/psi [A17]
  double alpha_a0 = 0.5;   // Eq. (21)
  double beta_a = 0.5;     // Eq. (22), 0..1
};
inline constexpr std::array<const char*, 5> kElamParameterNames = {"alpha_d", "beta_d", "alpha_a1", "alpha_a0", "beta_a"};

struct ElamOptions {
  bool exact_outer = false;  // true: external branches follow the patterns themselves [A6]
};

// One taxel.
struct ElamModel {
  PatternCurve ascending;    // P_a
  PatternCurve descending;   // P_d
  ElamParameters parameters;
  ElamOptions options;
  [[nodiscard]] double x0() const { return ascending.x().front(); }
  [[nodiscard]] double xu() const { return ascending.x().back(); }
  [[nodiscard]] double y0() const { return ascending.y().front(); }
  [[nodiscard]] double yu() const { return ascending.y().back(); }
};

// A target curve from one turning point on, Eqs (13)-(26) and (31)-(38): built once a turn, then evaluated.
class ElamCurve {
 public:
  // Descending from (x_M, y_M) towards (x0, y0), or ascending from (x_m, y_m) towards (xu, yu).
  ElamCurve(const ElamModel& model, bool ascending, double x_turn, double y_turn);
  [[nodiscard]] double output(double x) const;      // Eqs (17), (19), (24), (26)
  [[nodiscard]] double input(double y) const;       // Eqs (32), (34), (36), (38); clamped to the curve's range
  [[nodiscard]] double split_x() const { return xs_; }
  [[nodiscard]] double split_y() const { return ys_; }
  [[nodiscard]] bool ascending() const { return ascending_; }

 private:
  const ElamModel* model_;
  bool ascending_;
  double x_turn_, y_turn_;
  double xs_, ys_;          // split point of the target curve
  double xsp_ = 0, xmp_ = 0, ysp_ = 0;  // split and turn on the pattern
  bool pattern_itself_ = false;
};

}  // namespace tactbench::analysis
