// A target curve of ELAM for the fast compensator: made at a turn without allocation, read directly, or cut into the
// linear piece that holds an output. The formulas are those of ElamCurve (analysis/models/elam.h), Eqs (13)-(39).
// Outputs count from y0 in units of the taxel's noise here, so that no decision of a frame's loop needs the noise
// itself.
#pragma once

#include <cstddef>
#include <vector>

#include "analysis/compensate/frame_setup.h"

namespace tactbench::analysis {

// One taxel's patterns and parameters in the form that the curves need.
struct TaxelPattern {
  struct Side {
    std::vector<double> y, slope;  // knots from y0 on; psi per noise of each piece
    [[nodiscard]] std::size_t piece(double at,
                                    std::size_t near) const;  // the result does not depend on `near`; fast near it
  };
  std::vector<double> x;
  Side ascending, descending;
  ElamParameters parameters;
  bool exact_outer = false;
  double span = 0.0;       // yu - y0
  double noise_v = 0.0;    // volts of one unit of output
  double drift = 0.0;      // drift_share of the span
  double step = 0.0;       // of the flat criterion
  double saturated = 0.0;  // a piece that rises less is a straight line [A12]

  [[nodiscard]] double output(const Side& side, double x_at) const;
  [[nodiscard]] double input(const Side& side, double y_at,
                             std::size_t& near) const;  // near: the piece in which it was found
};

struct ComposedCurve {
  bool ascending = true;
  double x_turn = 0.0, y_turn = 0.0;
  double xs = 0.0, ys = 0.0;                  // split point of the target curve
  double xsp = 0.0, xmp = 0.0, ysp = 0.0;     // split and turn on the pattern
  std::size_t turn_near = 0, split_near = 0;  // pieces of the pattern in which turn and split lie, to begin searches at
};

// `near` below: pieces of the pattern to begin a search at; results do not depend on them.
ComposedCurve curve_from(const TaxelPattern& pattern, bool ascending, double x_turn, double y_turn, double x_split_turn,
                         const ComposedCurve& near = {});
// The reverse curve from the point of `curve` with output y (and pressure x, when that is known already).
ComposedCurve reversed(const TaxelPattern& pattern, const ComposedCurve& curve, double y);
ComposedCurve reversed(const TaxelPattern& pattern, const ComposedCurve& curve, double y, double x,
                       const ComposedCurve& near = {});
double input_at(const TaxelPattern& pattern, const ComposedCurve& curve, double y, std::size_t near);
inline double input_at(const TaxelPattern& pattern, const ComposedCurve& curve, double y) {
  return input_at(pattern, curve, y, curve.turn_near);
}
// Largest change of input_at within the flat criterion's step of y, psi per noise; x is input_at there. The second: of
// the curve back from there.
double sensitivity(const TaxelPattern& pattern, const ComposedCurve& curve, double y, double x, std::size_t near);
double reverse_sensitivity(const TaxelPattern& pattern, const ComposedCurve& curve, double y, double x,
                           const ComposedCurve& near = {});

// For from < y <= to, x = at + slope * (y - from). Its ends are the knots `index` and `index` + 1 of the curve, which
// has as many pieces as its pattern has knots. Below and above all of them x is constant.
struct CurvePiece {
  double from = 0.0, to = 0.0, at = 0.0, slope = 0.0;
  std::size_t index = 0, near = 0;
  [[nodiscard]] bool holds(double y) const { return y > from && y <= to; }
  [[nodiscard]] double along(double y) const { return at + slope * (y - from); }
};
inline constexpr double kFar = 1e30;  // a constant piece's open end
[[nodiscard]] inline std::size_t index_below(const TaxelPattern& p) { return p.x.size() + 1; }
[[nodiscard]] inline std::size_t index_above(const TaxelPattern& p) { return p.x.size() + 2; }
CurvePiece piece_at(const TaxelPattern& pattern, const ComposedCurve& curve, double y, std::size_t near);

}  // namespace tactbench::analysis
