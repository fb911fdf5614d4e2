// The hysteresis curves that the compensator follows: ELAM, Preisach's model, and any other model by its state at the
// last remembered turn. All have the same functions; turning.h is their template.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <vector>

#include "analysis/models/elam.h"
#include "analysis/models/linearised.h"
#include "analysis/models/model.h"
#include "analysis/models/pattern_curve.h"
#include "analysis/models/preisach.h"

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

// ELAM as a curve of the compensator: the target curves of its turning points, Eqs (31)-(38), with memory of turns. A
// branch that turned back from another one leads to the previous turning point. There the loop closes, both turns are
// forgotten and the earlier branch continues. The branch is the paper's curve with its outputs scaled so that it meets
// that point [A10]; a branch that leaves the external loop is the paper's curve unchanged.
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

// Preisach's model as a curve of the compensator: Everett's function at grid points, linear pieces of the branches, and
// the staircase of turning points. Internally, inputs are in grid intervals, from 0 to n, and outputs are u, with the
// readout divider inverted.
class PreisachCurve {
 public:
  // `everett`: the output's rise from grid point j to i >= j at i (i + 1) / 2 + j, (n + 1) (n + 2) / 2 values.
  struct Film {
    double x_low = 0.0, x_high = 1.0;
    std::size_t n = 0;
    Divider divider;  // zero 0
    std::vector<double> everett;
    [[nodiscard]] double at(std::size_t i, std::size_t j) const { return everett[i * (i + 1) / 2 + j]; }
    [[nodiscard]] double top() const { return at(n, 0); }
  };
  // From a model of the divider's u. Throws std::invalid_argument if the model cannot be used for streaming.
  static std::shared_ptr<const Film> film_of(const PreisachModel& model, const Divider& divider);
  struct Corner {
    double x = 0.0, u = 0.0;
  };
  // The branch that starts at a corner, after the first `below` corners.
  struct Way {
    Corner corner;
    std::size_t below = 0;
    [[nodiscard]] bool rises() const { return below % 2 == 0; }
  };
  explicit PreisachCurve(std::shared_ptr<const Film> film)
      : film_(std::move(film)), per_interval_((film_->x_high - film_->x_low) / static_cast<double>(film_->n)) {}

  [[nodiscard]] double top() const { return film_->divider.output(film_->top()); }
  [[nodiscard]] double x_low() const { return film_->x_low; }
  [[nodiscard]] double x_high() const { return film_->x_high; }
  [[nodiscard]] double place(double y) const { return film_->divider.linear(y); }
  [[nodiscard]] double output(double u) const { return film_->divider.output(u); }
  [[nodiscard]] double stretch(double y) const {
    const double share = 1.0 - std::min(y * film_->divider.per_amplitude, Divider::kMost);
    return per_interval_ / (share * share);
  }
  [[nodiscard]] double input(double x) const { return film_->x_low + per_interval_ * x; }
  void start(bool from_top) {
    last_ = {};
    if (from_top) turn({{static_cast<double>(film_->n), film_->top()}, 1});
  }
  void go(double at) { last_ = branch_at(last_, at); }
  [[nodiscard]] Way back_from(double at, const CurvePiece& on) const {
    const double x = on.along(at);
    const std::size_t below = branch_at(last_, at).below + 1;
    if (below % 2 == 0 && x <= 0.0) return {};
    return {{x, at}, below < kMost ? below : below - 2};
  }
  void turn(const Way& way) {
    corners_[way.below] = way.corner;
    last_ = way;
  }
  [[nodiscard]] CurvePiece piece(double at) const { return piece(last_, at); }
  [[nodiscard]] CurvePiece piece(const Way& way, double at) const;

 private:
  static constexpr std::size_t kMost =
      24;  // when full, the last two turning points, which form the smallest loop, are forgotten

  // The branch that continues at u.
  [[nodiscard]] Way branch_at(Way way, double at) const {
    while (way.below >= (way.rises() ? 2U : 3U) &&
           (way.rises() ? at > corners_[way.below - 1].u : at < corners_[way.below - 1].u))
      way = {corners_[way.below - 2], way.below - 2};
    return way;
  }

  std::shared_ptr<const Film> film_;
  double per_interval_;
  Way last_;  // the present branch
  std::array<Corner, kMost>
      corners_{};  // turning points: even indices minima, odd ones maxima; the first is the low end
};

}  // namespace tactbench::analysis
