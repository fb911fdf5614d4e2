// Adapts any hysteresis model to the compensator's curve interface, by a model state at the last remembered turn.
#pragma once

#include <algorithm>
#include <memory>

#include "analysis/models/model.h"
#include "analysis/models/piece.h"

namespace tactbench::analysis {

class StateCurve {
 public:
  // A branch that starts at a turn at y and x, the position of the state.
  struct Way {
    std::shared_ptr<const ModelState> state;
    bool rises = true;
    double y = 0.0, x = 0.0;
  };
  // `highest`: output of the measured loop, because the model's own may be wrong.
  StateCurve(const HysteresisModel& model, double highest) : model_(&model) {
    const auto virgin = model.state();
    low_ = virgin->output_at(model.x_low());
    top_ = std::max(highest, virgin->output_at(model.x_high())) - low_;
    start(false);
  }

  [[nodiscard]] double low() const { return low_; }  // output at the lowest input
  [[nodiscard]] double top() const { return top_; }
  [[nodiscard]] double x_low() const { return model_->x_low(); }
  [[nodiscard]] double x_high() const { return model_->x_high(); }
  [[nodiscard]] static double place(double y) { return y; }
  [[nodiscard]] static double output(double u) { return u; }
  [[nodiscard]] static double input(double x) { return x; }
  [[nodiscard]] static double stretch(double /*y*/) { return 1.0; }
  void start(bool from_top) {
    const std::shared_ptr<ModelState> state = model_->state();
    if (from_top) state->go(x_high());
    at_ = {state, !from_top, from_top ? top_ : 0.0, from_top ? x_high() : x_low()};
  }
  // Loops are closed by the state itself, at the next turn.
  void go(double /*y*/) {}
  [[nodiscard]] Way back_from(double y, const CurvePiece& on) const {
    const double x = on.x_a;
    const std::shared_ptr<ModelState> state = at_.state->clone();
    state->go(x);
    return {state, !at_.rises, y, x};
  }
  void turn(const Way& way) { at_ = way; }
  [[nodiscard]] CurvePiece piece(double y) const { return piece(at_, y); }
  // A piece of length zero: the branch's inverse at y.
  [[nodiscard]] CurvePiece piece(const Way& way, double y) const {
    if (way.rises ? y <= way.y : y >= way.y) return {y, y, y, way.x, 0.0};
    return {y, y, y, way.state->input_at(low_ + y), 0.0};
  }

 private:
  const HysteresisModel* model_;
  double low_ = 0.0, top_ = 0.0;
  Way at_;
};

}  // namespace tactbench::analysis
