// Films with lag and creep, simulated independently of the compensators that remove them: the direct model's state,
// creep and lag by small steps. dynamic_array() has relays behind a divider.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "analysis/identify/fit_models.h"
#include "analysis/models/dynamics.h"
#include "analysis/models/linearised.h"
#include "tests/analysis/support/models.h"

namespace synthetic {

// One taxel's model in volts before the divider; full output about 6 V there.
inline PreisachModel film_of(unsigned seed, std::size_t n) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform;
  std::vector<double> weights;
  double sum = 0.0;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j <= i; ++j) {
      const double apart = static_cast<double>(i - j) / static_cast<double>(n);
      weights.push_back((0.2 + uniform(random)) * std::exp(-8.0 * apart));
      sum += weights.back();
    }
  for (double& weight : weights) weight *= 6.0 / sum;
  return {0.0, 60.0, 0.0, weights};
}

struct DynamicTaxel {
  Divider divider;
  double creep_scale = 1.0, lag_share = 0.0;
};

class DynamicPlant {
 public:
  DynamicPlant(const HysteresisModel& film, const Dynamics& dynamics, const DynamicTaxel& taxel, int steps = 500)
      : film_(film.state()), x_low_(film.x_low()), d_(dynamics), taxel_(taxel), steps_(steps), at_(x_low_) {
    u_low_ = film_->output_at(x_low_);
  }
  // The pressure jumps to `psi` and is held for `seconds`; the output then.
  double step(double psi, double seconds) {
    const double p = psi - x_low_;
    for (int i = 0; i < steps_ && seconds > 0.0; ++i) {
      const double dt = seconds / steps_;
      late_ += (p - late_) * -std::expm1(-dt / d_.lag_s);
      for (std::size_t j = 0; j < kCreepElements; ++j)
        psi_[j] += (p / (p + d_.creep_half) - psi_[j]) * -std::expm1(-dt / d_.creep_s[j]);
    }
    at_ = x_low_ + (1.0 - taxel_.lag_share) * p + taxel_.lag_share * late_;
    film_->go(at_);
    double factor = 1.0;
    for (std::size_t j = 0; j < kCreepElements; ++j) factor += taxel_.creep_scale * d_.creep_share[j] * (psi_[j] - 1.0);
    const double u = film_->output_at(at_) - u_low_, v = u / (1.0 + taxel_.divider.per_amplitude * u);
    return taxel_.divider.zero + u_low_ + v * factor;
  }
  // By how much the input may differ where the film's output is `off` higher or lower.
  [[nodiscard]] double hidden(double off) const {
    const double u = film_->output_at(at_);
    return std::max(film_->input_at(u + off) - at_, at_ - film_->input_at(u - off));
  }

 private:
  std::unique_ptr<ModelState> film_;
  double x_low_, u_low_ = 0.0;
  Dynamics d_;
  DynamicTaxel taxel_;
  int steps_;
  double at_, late_ = 0.0;
  std::array<double, kCreepElements> psi_ = {};
};

struct DynamicArray {
  Dynamics dynamics;
  std::vector<DynamicTaxel> taxels;
  std::vector<PreisachModel> films;
};

inline DynamicArray dynamic_array(std::size_t taxels, std::size_t intervals = 20) {
  DynamicArray array;
  array.dynamics.creep_share = {0.015, 0.012, 0.01};
  array.dynamics.creep_half = 6.0;
  array.dynamics.lag_share = 0.07;
  for (std::size_t t = 0; t < taxels; ++t) {
    array.films.push_back(film_of(static_cast<unsigned>(t) + 1, intervals));
    array.taxels.push_back({{0.02, 1.0 / (4.0 + 0.05 * static_cast<double>(t % 8))},
                            0.8 + 0.05 * static_cast<double>(t % 9),
                            0.05 + 0.005 * static_cast<double>(t % 5)});
  }
  return array;
}

// From rest at 0 to random turning points, `step` at most between samples.
inline std::vector<double> random_way(std::size_t samples, double step, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> level(0.0, 60.0);
  std::vector<double> way{0.0};
  double target = 60.0;
  while (way.size() < samples) {
    const double now = way.back();
    if (now == target) target = level(random);
    way.push_back(std::abs(target - now) <= step ? target : now + std::copysign(step, target - now));
  }
  return way;
}

// The paper's two sequences along a model, on a grid of 2 psi.
inline FitData two_sequences(const HysteresisModel& model) {
  FitData data;
  const auto history = [&](const std::string& name, const std::vector<double>& turns) {
    History own{name, {turns.front()}, {}, {}, {}, {}};
    for (std::size_t i = 0; i + 1 < turns.size(); ++i) {
      const auto first = static_cast<int>(own.x.size()) - 1;
      const double step = turns[i + 1] > turns[i] ? 2.0 : -2.0;
      while (own.x.back() != turns[i + 1]) own.x.push_back(own.x.back() + step);
      own.branches.push_back({first, static_cast<int>(own.x.size()) - 1, step > 0.0});
    }
    own.y = predict(model, own.x);
    data.histories.push_back(own);
  };
  history("descending", {0, 60, 0, 50, 0, 40, 0, 30, 0, 20, 0, 10, 0});
  history("ascending", {0, 60, 10, 60, 0, 60, 20, 60, 0, 60, 30, 60, 0, 60, 40, 60, 0, 60, 50, 60, 0});
  std::vector<double> x, up, down;
  const History& first = data.histories.front();
  for (std::size_t i = 0; i <= 30; ++i) {
    x.push_back(first.x[i]);
    up.push_back(first.y[i]);
    down.push_back(first.y[60 - i]);
  }
  data.ascending = PatternCurve(x, up, up.front(), up.back());
  data.descending = PatternCurve(x, down, up.front(), up.back());
  return data;
}

}  // namespace synthetic
