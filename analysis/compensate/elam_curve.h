// ELAM as a curve of the compensator: the target curves of its turning points, Eqs (31)-(38), with memory of turns. A
// branch that turned back from another one leads to the previous turning point. There the loop closes, both turns are
// forgotten and the earlier branch continues. The branch is the paper's curve with its outputs scaled so that it meets
// that point [A10]; a branch that leaves the external loop is the paper's curve unchanged.
#pragma once

#include <array>
#include <cstddef>

#include "analysis/models/elam.h"
#include "analysis/models/piece.h"

namespace tactbench::analysis {

class ElamStack {
  struct Target {
    ElamCurve curve;
    double x_end = 0.0, y_end = 0.0;  // point at which it closes its loop or ends
    double y_from = 0.0, base = 0.0;  // output at the turn, and the curve's output there
    double per = 1.0;                 // scale: output of the curve per output
    bool straight = false;
  };

 public:
  // If the rising curve is nearly flat, an output that is too low by a few thousandths (temperature, creep) moves the
  // turn, and with it the split, several psi below xu. Within this share of the span below yu the split of a turn at xu
  // is used; its weight fades out up to twice that share.
  static constexpr double kDriftShare = 0.01;

  // A branch that began when the first `below` targets were stored.
  struct Way {
    Target target;
    std::size_t below = 0;
  };
  explicit ElamStack(const ElamModel& model) : model_(&model) { start(false); }  // keeps a pointer to `model`
  [[nodiscard]] double top() const { return model_->yu() - model_->y0(); }
  [[nodiscard]] double x_low() const { return model_->x0(); }
  [[nodiscard]] double x_high() const { return model_->xu(); }
  [[nodiscard]] static double place(double y) { return y; }
  [[nodiscard]] static double output(double u) { return u; }
  [[nodiscard]] static double input(double x) { return x; }
  [[nodiscard]] static double stretch(double /*y*/) { return 1.0; }
  void start(bool from_top);
  void go(double y) { below_ = branch_at(targets_[below_], below_, y + model_->y0()).below; }
  [[nodiscard]] Way back_from(double y, const CurvePiece& on) const;
  void turn(const Way& way) { targets_[below_ = way.below] = way.target; }
  [[nodiscard]] CurvePiece piece(double y) const { return piece_of(targets_[below_], below_, y); }
  [[nodiscard]] CurvePiece piece(const Way& way, double y) const { return piece_of(way.target, way.below, y); }

 private:
  static constexpr std::size_t kMost =
      16;  // when full, the last two turns, which form the smallest loop, are forgotten
  // The branch that continues at y, given the previous branch `last` and the first `below` targets.
  struct Branch {
    const Target* target;
    std::size_t below;
  };
  [[nodiscard]] Branch branch_at(const Target& last, std::size_t below, double y) const;
  [[nodiscard]] Target target(const ElamCurve& curve, double x_end, double y_end) const;
  [[nodiscard]] static CurvePiece piece_of(const Target& target, double y);
  [[nodiscard]] CurvePiece piece_of(const Target& last, std::size_t below, double y) const;

  const ElamModel* model_;
  std::size_t below_ = 0;  // number of targets below the present branch
  std::array<Target, kMost> targets_;
};

}  // namespace tactbench::analysis
