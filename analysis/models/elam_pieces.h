// ELAM with more than one split point a branch, which the conclusion of Sanchez-Duran et al., Sensors 2015, mentions
// without equations. The parametrisation is ours, not the paper's.
#pragma once

#include <array>
#include <vector>

#include "analysis/models/elam.h"

namespace tactbench::analysis {

inline constexpr int kMostSplits = 8;
inline constexpr double kMostPieceLog = 2.0;  // a piece is at most e^2 times larger or smaller than its neighbours

// The paper's split point stays, and each of the two sides it makes is divided again: a side with k numbers into k + 1
// pieces, evenly in x where the curve descends and evenly in y where it ascends. Pieces of the paper's curve are then
// resized: descending, each rises by its own weight times what it rose, ascending, each is its own weight times as
// long, and all of a side by the common factor that keeps the side's ends in place. So every piece is a linear map of
// its piece of the pattern, as with one split, and the curve is monotone for any numbers. The numbers are logarithms of
// the weights from the second piece on, the first one's is 0; with all of them 0 it is the paper's curve.
struct ElamPieces {
  std::vector<double> descending_low, descending_high, ascending_low, ascending_high;  // low: the side nearer x0
  [[nodiscard]] int splits() const { return 1 + static_cast<int>(descending_low.size() + descending_high.size()); }
};

// ElamCurve with its pieces resized. With one split it is ElamCurve, bit for bit; so are external branches that follow
// the pattern (ElamOptions::exact_outer).
class ElamPiecedCurve {
 public:
  ElamPiecedCurve(const ElamModel& model, const ElamPieces& pieces, bool ascending, double x_turn, double y_turn);
  [[nodiscard]] double output(double x) const;
  [[nodiscard]] double input(double y) const;  // clamped to the curve's range
  [[nodiscard]] double turn_x() const { return curve_.turn_x(); }
  [[nodiscard]] double turn_y() const { return curve_.turn_y(); }
  [[nodiscard]] bool ascending() const { return curve_.ascending(); }

 private:
  using Knots = std::array<double, kMostSplits + 2>;
  template <class Place>
  void divide(const std::vector<double>& logs, double end, const Place& place);
  [[nodiscard]] double mapped(double value, const Knots& from, const Knots& to) const;
  ElamCurve curve_;
  std::size_t last_ = 0;     // knot; 0: nothing is resized
  Knots plain_{}, sized_{};  // ordinates of a descending curve, abscissae of an ascending one
};

}  // namespace tactbench::analysis
