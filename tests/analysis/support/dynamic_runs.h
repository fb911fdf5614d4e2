// Runs of small arrays that follow the dynamic model: the paper's sequences, rates, held levels, and one further
// trajectory.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "analysis/dataset.h"
#include "analysis/identify/dynamic/dynamics_search.h"
#include "analysis/identify/fit_models.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/models/dynamics.h"
#include "analysis/models/linearised.h"
#include "analysis/models/preisach.h"
#include "tests/analysis/support/models.h"

namespace synthetic {

// Films with lag and creep, simulated independently of the compensators that remove them: the direct model's state,
// creep and lag by small steps. dynamic_array() has relays behind a divider.

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

inline constexpr std::size_t kTaxels = 4;

struct Timed {
  std::vector<double> levels;
  double seconds = 2.6;  // at each
  int frames = 1;
};

// Plants that begin at rest, without conditioning.
inline Dataset run_of(const DynamicArray& array,
                      const std::vector<std::pair<std::string, std::vector<Timed>>>& sequences, std::int64_t number,
                      double sign = 1.0) {
  std::vector<DynamicPlant> plants;
  for (std::size_t t = 0; t < kTaxels; ++t) plants.emplace_back(array.films[t], array.dynamics, array.taxels[t], 40);
  Dataset data;
  data.run = number;
  data.origin = "simulated";
  data.sensor_serial = "S";
  data.scanner_serial = "C";
  data.rows = 1;
  data.columns = kTaxels;
  data.noise_v.assign(kTaxels, 0.0005);
  data.at_limit.assign(kTaxels, false);
  std::mt19937 random(static_cast<unsigned>(number) + 70);
  std::normal_distribution<double> noise(0.0, 0.0005);
  double now = 0.0;
  for (const auto& [name, repeats] : sequences) {
    SequenceData& sequence = data.sequences.emplace_back(SequenceData{name, {}});
    for (const Timed& timed : repeats) {
      Repeat& repeat = sequence.repeats.emplace_back();
      for (const double psi : timed.levels)
        for (int f = 1; f <= timed.frames; ++f) {
          now += timed.seconds;
          repeat.steps.push_back({psi, psi, now, f * timed.seconds});
          for (DynamicPlant& plant : plants)
            repeat.volts.push_back(sign * (plant.step(psi, timed.seconds) + noise(random)));
        }
    }
  }
  return data;
}

inline std::vector<double> way_along(const std::vector<double>& turns, double step) {
  std::vector<double> way{turns.front()};
  for (const double turn : turns)
    while (way.back() != turn) way.push_back(way.back() + (turn > way.back() ? step : -step));
  return way;
}

struct Runs {
  Dataset fitted, rate, creep, other;
};

inline Runs runs_of(const DynamicArray& array, double sign = 1.0) {
  const std::vector<double> down = way_along({0, 60, 0, 50, 0, 40, 0, 30, 0, 20, 0, 10, 0}, 2.0);
  const std::vector<double> up =
      way_along({0, 60, 10, 60, 0, 60, 20, 60, 0, 60, 30, 60, 0, 60, 40, 60, 0, 60, 50, 60, 0}, 2.0);
  const std::vector<double> loop = way_along({0, 60, 0}, 4.0);
  const std::vector<double> elsewhere = way_along({0, 60, 0, 46, 14, 38, 22, 56, 8, 52, 30, 44, 0}, 2.0);
  return {run_of(array, {{"descending", {{down}}}, {"ascending", {{up}}}}, 1, sign),
          run_of(array, {{"rate", {{loop, 0.8}, {loop, 2.6}, {loop, 20.0}}}}, 2, sign),
          run_of(array, {{"creep-levels", {{{0, 20, 40, 60, 40, 20, 0}, 2.0, 151}}}}, 3, sign),
          run_of(array, {{"elsewhere", {{elsewhere}}}}, 4, sign)};
}

// Runs generated by the formulas of the dynamic model (analysis/models/dynamics.h), whose outputs are straight lines of
// the pressure that has arrived, so that the result of identification is known exactly.

using namespace tactbench::analysis;

// A taxel: zero + volts_per_psi x what has arrived x the creep's factor.
struct WalkedTaxel {
  double zero = 0.0, volts_per_psi = 0.1, creep_scale = 1.0, lag_share = 0.0;
};

struct WalkedRepeat {
  std::vector<double> psi;
  double seconds = 1.0;   // at each level
  double worked_s = 0.0;  // conditioning before its first level
  double off = 0.0;       // of the reference from the set-point
};

struct WalkedSequence {
  std::string name;
  std::vector<WalkedRepeat> repeats;
};

// Neither creep nor lag is known yet.
inline ArrayDynamics nothing_known(std::size_t taxels) {
  ArrayDynamics none;
  none.creep_scale.assign(taxels, 1.0);
  none.lag_share.assign(taxels, 0.0);
  return none;
}

inline Dataset walked_run(const Dynamics& d, const std::vector<WalkedTaxel>& taxels,
                          const std::vector<WalkedSequence>& sequences, double span) {
  Dataset data;
  data.run = 1;
  data.origin = "simulated";
  data.rows = 1;
  data.columns = static_cast<int>(taxels.size());
  data.noise_v.assign(taxels.size(), 0.001);
  data.at_limit.assign(taxels.size(), false);
  DynamicsState state;
  double now = 0.0;
  for (const WalkedSequence& sequence : sequences) {
    SequenceData& own = data.sequences.emplace_back(SequenceData{sequence.name, {}});
    for (const WalkedRepeat& walked : sequence.repeats) {
      Repeat& repeat = own.repeats.emplace_back();
      for (std::size_t i = 0; i < walked.psi.size(); ++i) {
        if (i == 0 && walked.worked_s > 0.0) {
          now += walked.worked_s;
          work_unseen(d, state, walked.worked_s, span);
        }
        now += walked.seconds;
        const DynamicsStep step(d, walked.seconds);
        const double psi = walked.psi[i] + walked.off;
        repeat.steps.push_back({walked.psi[i], psi, now, walked.seconds});
        for (const WalkedTaxel& taxel : taxels)
          repeat.volts.push_back(taxel.zero + taxel.volts_per_psi * arrived(taxel.lag_share, state, step, psi) *
                                                  creep_factor(d, state, step, psi, taxel.creep_scale));
        advance(d, state, step, psi);
      }
    }
  }
  return data;
}

}  // namespace synthetic

namespace tactbench::creeping {

// A sensor of one taxel whose model has lag and creep: a film of three cells.

// Two intervals from 10 to 50 psi: cells of 1, 2 and 4 V behind a divider.
inline analysis::SensorModel creeping_film(bool falling = false) {
  using namespace analysis;
  SensorModel model;
  model.source = "run 5";
  model.rows = model.columns = 1;
  model.falling = falling;
  model.dynamics.emplace();
  model.dynamics->shared.creep_share = {0.03, 0.02, 0.01};
  model.dynamics->shared.lag_share = 0.1;
  model.dynamics->shared.lag_s = 3.0;
  ModelTaxel& taxel = model.taxels.emplace_back();
  taxel.taxel = 0;
  taxel.status = TaxelStatus::kFitted;
  taxel.noise = 0.002;
  taxel.creep_scale = 1.5;
  taxel.lag_share = 0.1;
  taxel.fit.full_scale = 7.0 / (1.0 + 7.0 / 8.0);
  taxel.loop_low = 0.5;
  taxel.fit.model = std::make_shared<LinearisedModel>(
      Divider{0.5, 0.125}, std::make_shared<PreisachModel>(10.0, 50.0, 0.0, std::vector<double>{1, 2, 4}));
  return model;
}

}  // namespace tactbench::creeping
