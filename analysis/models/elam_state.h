// State of an ELAM model along a history, with or without return-point memory.
#pragma once

#include <vector>

#include "analysis/models/elam_pieces.h"
#include "analysis/models/model.h"

namespace tactbench::analysis {

struct ElamPoint {
  double x = 0.0, y = 0.0;
};

// A target curve from a turning point to the point where it closes a loop or ends. Its ordinates are scaled so that it
// meets both points; where it already does it is the plain curve.
class ElamSegment {
 public:
  ElamSegment(const ElamModel& model, const ElamPieces& pieces, bool ascending, ElamPoint from, ElamPoint to);
  [[nodiscard]] bool ascending() const { return curve_.ascending(); }
  [[nodiscard]] ElamPoint to() const { return to_; }
  [[nodiscard]] double output(double x) const;
  [[nodiscard]] double input(double y) const;
  void go_on_from(ElamPoint here);  // the rest of it now runs from here to the same end

  ElamPoint origin;  // the turning point at which the loop that a branch leaves here closes

 private:
  enum class Kind { kPlain, kScaled, kStraight };
  ElamPiecedCurve curve_;
  ElamPoint from_, to_;
  Kind kind_ = Kind::kPlain;
  double base_ = 0.0, scale_ = 1.0;  // kScaled: the curve's ordinate at from_; ordinates per the curve's
  double smallest_rise_;             // of the curve that can be scaled
};

class ElamState final : public ModelState {
 public:
  ElamState(const ElamModel& model, const ElamPieces& pieces, bool memory);  // keeps pointers to both
  void reset() override;
  [[nodiscard]] double output_at(double x) const override;
  [[nodiscard]] double input_at(double y) const override;
  [[nodiscard]] std::unique_ptr<ModelState> clone() const override { return std::make_unique<ElamState>(*this); }
  void go(double x) override;
  void measured(double y) override;

 private:
  [[nodiscard]] ElamSegment outer(bool ascending) const;
  [[nodiscard]] ElamSegment turned(bool ascending) const;
  [[nodiscard]] bool goes_on(bool ascending) const { return ascending == segments_.back().ascending() && !anchored_; }
  [[nodiscard]] double follow(bool up, double value, double ElamPoint::*along,
                              double (ElamSegment::*read)(double) const) const;
  const ElamModel* model_;
  const ElamPieces* pieces_;
  bool memory_;
  std::vector<ElamSegment> segments_;  // directions alternate; the last is the current one
  ElamPoint here_;
  bool anchored_ = false;  // a measured point: any continuation is a new branch
};

}  // namespace tactbench::analysis
