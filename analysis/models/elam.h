// External Loop Adaptation Method, Sanchez-Duran et al., Sensors 2015: direct model Eqs (9)-(28) and inverse (29)-(39)
// in the general form with (x0, y0) [A4], [A5]. Pressure in psi, output in volts; x0, xu are the ends of the pattern
// grid, y0, yu the measured ends common to both patterns.
#pragma once

#include <array>
#include <vector>

#include "analysis/models/model.h"
#include "analysis/models/pattern_curve.h"

namespace tactbench::analysis {

struct ElamParameters {
  double alpha_d = 0.5;   // Eq. (14), 0..1
  double beta_d = 0.5;    // Eq. (15), 0..1
  double alpha_a1 = 0.0;  // Eq. (21), 1/psi [A17]
  double alpha_a0 = 0.5;  // Eq. (21)
  double beta_a = 0.5;    // Eq. (22), 0..1
};
inline constexpr std::array<const char*, 5> kElamParameterNames = {"alpha_d", "beta_d", "alpha_a1", "alpha_a0",
                                                                   "beta_a"};

// A branch that starts within this share of the pressure span of x0 or xu is an external one.
inline constexpr double kOuterShare = 0.01;

// A pattern that rises less than this share of its span over a piece is saturated there: PatternCurve made it a
// straight line of the minimum slope, and linear between the piece's ends [A12] is the same curve without the
// cancellation.
inline constexpr double kSaturatedShare = 2e-9;

struct ElamOptions {
  bool exact_outer = false;  // true: the split of external branches lies on the pattern, so that they follow it [A6]
};

// One taxel.
struct ElamModel {
  PatternCurve ascending;   // P_a
  PatternCurve descending;  // P_d
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
  ElamCurve() = default;  // of no model: to be assigned to
  // Descending from (x_M, y_M) towards (x0, y0), or ascending from (x_m, y_m) towards (xu, yu). x_turn is clamped to
  // x0..xu; y_turn to at least y0, ascending also to at most yu (noise at the ends). Keeps a pointer to `model`. Throws
  // std::invalid_argument when a coordinate is not finite.
  // A descending curve may take its split x_sd from another pressure than x_turn (`x_split_turn`, not below x_turn).
  ElamCurve(const ElamModel& model, bool ascending, double x_turn, double y_turn);
  ElamCurve(const ElamModel& model, bool ascending, double x_turn, double y_turn, double x_split_turn);
  // Eqs (17), (19), (24), (26). The ends are met whatever the split: (x_turn, y_turn) and (x0, y0) or (xu, yu).
  [[nodiscard]] double output(double x) const;
  // Eqs (32), (34), (36), (38), as the linear piece that has output y; constant beyond the curve's ends.
  [[nodiscard]] CurvePiece piece(double y) const;
  [[nodiscard]] double input(double y) const;  // the same at y, clamped to the curve's range
  [[nodiscard]] double turn_x() const { return x_turn_; }
  [[nodiscard]] double turn_y() const { return y_turn_; }
  [[nodiscard]] double split_x() const { return xs_; }
  [[nodiscard]] double split_y() const { return ys_; }
  [[nodiscard]] bool ascending() const { return ascending_; }

 private:
  [[nodiscard]] double descending_output(double x) const;
  [[nodiscard]] double ascending_output(double x) const;
  [[nodiscard]] CurvePiece descending_piece(double y) const;
  [[nodiscard]] CurvePiece ascending_piece(double y) const;
  const ElamModel* model_ = nullptr;
  bool ascending_ = true;
  double x_turn_ = 0, y_turn_ = 0;
  double xs_ = 0, ys_ = 0;              // split point of the target curve
  double xsp_ = 0, xmp_ = 0, ysp_ = 0;  // split and turn on the pattern
};

// More than one split point a branch, which the paper's conclusion mentions without equations. The parametrisation is
// ours, not the paper's.
inline constexpr int kMaxSplits = 8;
inline constexpr double kMaxPieceLog = 2.0;  // a piece is at most e^2 times larger or smaller than its neighbours

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
  using Knots = std::array<double, kMaxSplits + 2>;
  template <class Place>
  void divide(const std::vector<double>& logs, double end, const Place& place);
  [[nodiscard]] double mapped(double value, const Knots& from, const Knots& to) const;
  ElamCurve curve_;
  std::size_t last_ = 0;     // knot; 0: nothing is resized
  Knots plain_{}, sized_{};  // ordinates of a descending curve, abscissae of an ascending one
};

// ELAM as a HysteresisModel: the plain ElamModel (Sanchez-Duran et al., Sensors 2015, Eqs (9)-(39)) walked along a
// history, with return-point memory as an option of ours.
// Without `memory` (the paper, [A10]) a turn forgets all older ones: every branch runs to (x0, y0) or (xu, yu). With
// it, turning points are kept on a stack: a branch runs to the turning point before the last, where it closes the inner
// loop, forgets both (wiping-out) and continues along the branch that was left there. The closing branch is the paper's
// curve, its ordinates scaled linearly so that it meets that point.
inline constexpr std::array<std::vector<double> ElamPieces::*, 4> kElamSides = {
    &ElamPieces::descending_low, &ElamPieces::descending_high, &ElamPieces::ascending_low, &ElamPieces::ascending_high};

class ElamHysteresis final : public HysteresisModel {
 public:
  static constexpr const char* kName = "elam";
  static constexpr bool kOfLoop = true;
  static std::unique_ptr<HysteresisModel> from(const ModelSource& source);
  static std::unique_ptr<Identifier> prepare(const FitData& like, const IdentifyOptions& options);
  static KnownModel known();

  // Throws std::invalid_argument when the patterns do not share their grid and ends, a parameter is not finite, or
  // `pieces` have more than kMaxSplits split points or another number of them down than up.
  explicit ElamHysteresis(ElamModel model, bool memory = false, ElamPieces pieces = {});

  [[nodiscard]] std::string name() const override { return kName; }
  [[nodiscard]] ModelMembers members() const override;
  // alpha_d, beta_d, beta_a: 0..1, Eqs (14), (15), (22). alpha_a1 (1/x), alpha_a0: Eq. (21); identification keeps
  // alpha_a1 L + alpha_a0 in 0..1 for every branch length L up to X = xu - x0, so alpha_a0 is in 0..1 and alpha_a1 in
  // -1/X..1/X. Further split points add log_d1.. and log_a1.., the numbers of ElamPieces, low side first.
  [[nodiscard]] std::vector<ModelParameter> parameters() const override;
  [[nodiscard]] double x_low() const override { return model_.x0(); }
  [[nodiscard]] double x_high() const override { return model_.xu(); }
  [[nodiscard]] int operations_per_sample() const override;
  // measured(y) within 1 % of the span from x0 or xu belongs to an external branch: the state is on the external curve
  // for every y, as in identification.
  [[nodiscard]] std::unique_ptr<ModelState> state() const override;

  [[nodiscard]] const ElamModel& elam() const { return model_; }
  [[nodiscard]] const ElamPieces& pieces() const { return pieces_; }
  [[nodiscard]] bool memory() const { return memory_; }
  // One split point a branch and no memory: the only form of the streaming compensator.
  [[nodiscard]] bool is_paper() const { return !memory_ && pieces_.splits() == 1; }

 private:
  ElamModel model_;
  bool memory_;
  ElamPieces pieces_;
};

// Throws std::invalid_argument that names the missing or wrong member.

}  // namespace tactbench::analysis
