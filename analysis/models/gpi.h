// Generalized Prandtl-Ishlinskii model (GPI): Eqs (2), (3), (40)-(43) of Sanchez-Duran et al., Sensors 2015, with the
// operators of Al Janaideh, Rakheja and Su (the paper's [28]). Five operators (i = 0..4), initial states 0 ([A14] of
// docs/elam-readings.md).
#pragma once

#include <array>

#include "analysis/models/model.h"

namespace tactbench::analysis {

inline constexpr int kGpiOperators = 5;

// y = y_low + sum of p(r_i) H_i, r_i = alpha i, p(r) = rho e^(-tau r), gamma_l(x) = a3 - a0 e^(a2 - a1 (x - x_low)),
// gamma_r the same with b. The paper's rig has x_low = y_low = 0. a0 and a2 occur only as a0 e^a2, b0 and b2 the same,
// and (a0, a3, b0, b3, alpha, 1/rho, 1/tau) share a scale: 8 of the 11 numbers are independent [A16].
struct GpiParameters {
  double a0 = 1.0, a1 = 1.0, a2 = 0.0, a3 = 1.0;  // a0 > 0 and a3 in y, a1 > 0 in 1/x
  double b0 = 1.0, b1 = 1.0, b2 = 0.0, b3 = 1.0;  // b0 > 0 and b3 in y, b1 > 0 in 1/x
  double alpha = 1.0;                             // > 0, y
  double rho = 1.0;                               // > 0
  double tau = 0.0;                               // 1/y, either sign
};

class GpiModel final : public HysteresisModel {
 public:
  static constexpr const char* kName = "gpi";
  static constexpr double kFitShare = 85.0;
  static std::unique_ptr<HysteresisModel> from(const ModelSource& source);
  static std::unique_ptr<Identifier> prepare(const FitData& like, const IdentifyOptions& options);
  static KnownModel known();

  // Throws std::invalid_argument when a number is not finite, not positive where it must be, or x_low >= x_high.
  GpiModel(const GpiParameters& parameters, double x_low, double x_high, double y_low);

  [[nodiscard]] std::string name() const override { return kName; }
  [[nodiscard]] ModelMembers members() const override;
  [[nodiscard]] std::vector<ModelParameter> parameters() const override;
  [[nodiscard]] double x_low() const override { return x_low_; }
  [[nodiscard]] double x_high() const override { return x_high_; }
  [[nodiscard]] int operations_per_sample() const override;
  [[nodiscard]] std::unique_ptr<ModelState> state() const override;

  using Operators = std::array<double, kGpiOperators>;
  [[nodiscard]] Operators moved(const Operators& before, double x) const;  // Eq. (3) for each operator
  [[nodiscard]] double output(const Operators& operators) const;           // Eq. (2)

 private:
  GpiParameters p_;
  double x_low_, x_high_, y_low_;
  double a_, b_;                   // a0 e^a2, b0 e^b2
  Operators threshold_, density_;  // Eqs (40), (41)
};

}  // namespace tactbench::analysis
