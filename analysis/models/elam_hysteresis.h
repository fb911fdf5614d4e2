// ELAM as a HysteresisModel: the plain ElamModel (Sanchez-Duran et al., Sensors 2015, Eqs (9)-(39)) walked along a
// history, with return-point memory as an option of ours.
#pragma once

#include <array>
#include <vector>

#include "analysis/models/elam.h"
#include "analysis/models/model.h"

namespace tactbench::analysis {

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
