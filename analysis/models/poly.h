// Polynomial model (POLY): Eqs (6)-(8), (47), (48) of Sanchez-Duran et al., Sensors 2015, after Bashash and Jalili (the
// paper's [31]): every branch is a dominant sixth-order polynomial, stretched between its turning point and the end at
// which all branches of that direction converge.
#pragma once

#include <array>

#include "analysis/models/model.h"

namespace tactbench::analysis {

inline constexpr std::size_t kPolyOrder = 6;

// a[i], b[i]: of (x - x_low)^(6 - i) in f_ra and f_rd, y/x^(6-i), Eqs (47), (48). A polynomial times a constant plus a
// constant is the same model [A2]; fits are given with f(x_low) = y_low and f(x_high) = y_high.
struct PolyParameters {
  std::array<double, kPolyOrder + 1> a{}, b{};
};

// The bracket of Eqs (6), (7) is read so that a branch starts at its turning point and ends at the converging point
// [A1]: rising y = y1 + (yu - y1) F_a((x - x1) / (xu - x1)), falling y = y0 + (y1 - y0) F_d((x - x0) / (x1 - x0)), F
// being f over x0..xu scaled to 0..1. (x0, y0) and (xu, yu) are the measured ends of the external loop [A3]. Equal
// inputs keep the direction [A8].
//
// A sixth-order polynomial that is fitted to a flat curve wavers: the output then falls in places where the input
// rises. The direct model is the plain formula all the same. The inverse goes up when the output lies above the present
// one and down when below, to the FIRST input that gives it: outputs are always met, an input beyond a fall is read as
// the one before it.
class PolyModel final : public HysteresisModel {
 public:
  static constexpr const char* kName = "poly";
  static constexpr bool kOfLoop = true;
  static constexpr double kFitShare = 4.0;
  static std::unique_ptr<HysteresisModel> from(const ModelSource& source);
  static std::unique_ptr<Identifier> prepare(const FitData& like, const IdentifyOptions& options);
  static KnownModel known();

  // Throws std::invalid_argument when a number is not finite, a polynomial is the same at both ends, x_low >= x_high
  // or y_low >= y_high.
  PolyModel(const PolyParameters& parameters, double x_low, double x_high, double y_low, double y_high);

  [[nodiscard]] std::string name() const override { return kName; }
  [[nodiscard]] ModelMembers members() const override;
  [[nodiscard]] std::vector<ModelParameter> parameters() const override;
  [[nodiscard]] double x_low() const override { return x_low_; }
  [[nodiscard]] double x_high() const override { return x_high_; }
  [[nodiscard]] int operations_per_sample() const override;
  // measured(y) within 1 % of the span from x_low or x_high belongs to an external branch: the state is on the external
  // curve for every y. Elsewhere any continuation is a new branch that starts at y.
  [[nodiscard]] std::unique_ptr<ModelState> state() const override;

  struct Turn {
    bool ascending = true;
    double x = 0.0, y = 0.0;
  };
  [[nodiscard]] double output(const Turn& turn, double x) const;  // Eqs (6), (7)
  // Places where f_ra or f_rd changes direction, in 0..1 of a branch from its low end, rising.
  [[nodiscard]] std::vector<double> extremes(bool ascending) const;
  [[nodiscard]] Turn external(bool ascending) const;

 private:
  using Shape = std::array<double, kPolyOrder>;  // F(t) = sum of shape[k] t^(k+1); its sum is 1
  [[nodiscard]] static double value(const Shape& shape, double t);
  PolyParameters p_;
  double x_low_, x_high_, y_low_, y_high_;
  Shape up_, down_;
};

// A branch that starts within this share of the span of x0 or xu is an external one.
inline constexpr double kPolyOuterShare = 0.01;

}  // namespace tactbench::analysis
