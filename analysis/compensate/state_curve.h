// Any model as a curve of the compensator: a state that stands at the last remembered turn.
#pragma once

#include <algorithm>
#include <memory>

#include "analysis/models/model.h"
#include "analysis/models/piece.h"

namespace tactbench::analysis {

class StateCurve {
 public:
  // `highest`: output of the loop as measured, where the model's own may be off.
  StateCurve(const HysteresisModel& model, double highest) : model_(&model), state_(model.state()) {
    low_ = state_->output_at(model.x_low());
    top_ = std::max(highest, state_->output_at(model.x_high())) - low_;
    start(false);
  }
  StateCurve(const StateCurve& other) { *this = other; }
  StateCurve(StateCurve&&) noexcept = default;
  StateCurve& operator=(const StateCurve& other) {
    if (this == &other) return *this;
    model_ = other.model_;
    state_ = other.state_->clone();
    low_ = other.low_;
    top_ = other.top_;
    rises_ = other.rises_;
    corner_ = other.corner_;
    return *this;
  }
  StateCurve& operator=(StateCurve&&) noexcept = default;
  ~StateCurve() = default;

  [[nodiscard]] double low() const { return low_; }  // output at the lowest input
  [[nodiscard]] double top() const { return top_; }
  [[nodiscard]] double x_low() const { return model_->x_low(); }
  [[nodiscard]] double x_high() const { return model_->x_high(); }
  [[nodiscard]] static double place(double y) { return y; }
  [[nodiscard]] static double stretch(double /*y*/) { return 1.0; }
  void start(bool from_top) {
    state_->reset();
    rises_ = !from_top;
    if (from_top) state_->go(model_->x_high());
    corner_ = {0.0, 0.0, from_top ? top_ : 0.0, from_top ? x_high() : x_low(), 0.0};
  }
  // Loops are closed by the state itself, at the next turn.
  void go(double /*y*/) {}
  void turn(double y) {
    const double x = piece(y).x_a;
    state_->go(x);
    rises_ = !rises_;
    corner_ = {0.0, 0.0, y, x, 0.0};
  }
  // Of no length: the branch's inverse at y.
  [[nodiscard]] CurvePiece piece(double y) const {
    if (rises_ ? y <= corner_.y_a : y >= corner_.y_a) return {y, y, y, corner_.x_a, 0.0};
    return {y, y, y, state_->input_at(low_ + y), 0.0};
  }

 private:
  const HysteresisModel* model_ = nullptr;
  std::unique_ptr<ModelState> state_;
  double low_ = 0.0, top_ = 0.0;
  bool rises_ = true;
  CurvePiece corner_;
};

}  // namespace tactbench::analysis
