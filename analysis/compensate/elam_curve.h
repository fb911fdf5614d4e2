// ELAM as a curve of the compensator: the target curves of its turning points, Eqs (31)-(38), with memory of turns. A
// branch that turned back from another runs to the turning point before, where the loop closes, both are forgotten and
// the branch that was left there goes on; the paper's own curve, its outputs scaled so that it meets that point [A10].
// On branches that leave the external loop it is the paper's curve itself.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "analysis/models/elam.h"
#include "analysis/models/piece.h"

namespace tactbench::analysis {

class ElamStack {
 public:
  // Where the rising curve is nearly flat, an output a few thousandths low (temperature, creep) puts the turn psi below
  // xu, and the split with it. Within this share of the span below yu the split is taken as that of a turn at xu,
  // fading out to twice that.
  static constexpr double kDriftShare = 0.01;

  explicit ElamStack(const ElamModel& model) : model_(&model) { start(false); }  // keeps a pointer to `model`
  ElamStack(const ElamStack& other) { *this = other; }
  ElamStack& operator=(const ElamStack& other) {  // of those in use alone: each way back is a copy
    model_ = other.model_;
    count_ = other.count_;
    std::copy_n(other.targets_.begin(), count_, targets_.begin());
    return *this;
  }
  ~ElamStack() = default;
  [[nodiscard]] double top() const { return model_->yu() - model_->y0(); }
  [[nodiscard]] double x_low() const { return model_->x0(); }
  [[nodiscard]] double x_high() const { return model_->xu(); }
  [[nodiscard]] static double place(double y) { return y; }
  [[nodiscard]] static double stretch(double /*y*/) { return 1.0; }
  void start(bool from_top);
  void go(double y) { count_ = left_at(y + model_->y0()); }
  void turn(double y);
  [[nodiscard]] CurvePiece piece(double y) const;

 private:
  static constexpr std::uint8_t kMost = 16;  // when full, the last two, the smallest loop, are forgotten
  struct Target {
    ElamCurve curve;
    double x_end = 0.0, y_end = 0.0;  // where it closes its loop or ends
    double y_from = 0.0, base = 0.0;  // output of the turn, and the curve's there
    double per = 1.0;                 // outputs of the curve per output
    bool straight = false;
  };
  [[nodiscard]] Target target(const ElamCurve& curve, double x_end, double y_end) const;
  [[nodiscard]] static CurvePiece piece_of(const Target& target, double y);
  [[nodiscard]] std::uint8_t left_at(double y) const;

  const ElamModel* model_ = nullptr;
  std::array<Target, kMost> targets_;
  std::uint8_t count_ = 0;
};

}  // namespace tactbench::analysis
