// A single-valued monotone curve without hysteresis: the usual practice today, and the baseline error that every model
// has to beat.
#pragma once

#include "analysis/models/model.h"
#include "analysis/models/pattern_curve.h"

namespace tactbench::analysis {

class MonotoneModel final : public HysteresisModel {
 public:
  static constexpr const char* kName = "monotone";
  static constexpr double kFitShare = 0.5;
  static std::unique_ptr<HysteresisModel> from(const ModelSource& source);
  static std::unique_ptr<Identifier> prepare(const FitData& like, const IdentifyOptions& options);

  // Throws std::invalid_argument when the curve is empty.
  explicit MonotoneModel(PatternCurve curve);

  [[nodiscard]] std::string name() const override { return kName; }
  [[nodiscard]] ModelMembers members() const override;
  [[nodiscard]] std::vector<ModelParameter> parameters() const override;  // y0, y1, ...: the knots' outputs
  [[nodiscard]] double x_low() const override { return curve_.x().front(); }
  [[nodiscard]] double x_high() const override { return curve_.x().back(); }
  [[nodiscard]] int operations_per_sample() const override { return 3; }  // a table access and a multiply-add
  [[nodiscard]] std::unique_ptr<ModelState> state() const override;

  [[nodiscard]] const PatternCurve& curve() const { return curve_; }

 private:
  PatternCurve curve_;
};

}  // namespace tactbench::analysis
