// Taxels of every kind of model, with simulated plants of known truth: the direct model itself, driven by inputs.
#pragma once

#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "analysis/compensate/compensator.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/models/elam.h"
#include "analysis/models/linearised.h"
#include "tests/analysis/support/dynamic_runs.h"
#include "tests/analysis/support/synthetic.h"

namespace synthetic {

inline constexpr double kOutputZero = 0.2, kOutputGain = 1.3;  // output = zero + gain x the model's

struct Kind {
  std::string name;
  std::shared_ptr<const HysteresisModel> model, truth;  // ELAM's truth has memory of turns
  bool in_time = false;

  [[nodiscard]] double span() const { return model->x_high() - model->x_low(); }
  [[nodiscard]] double full() const {  // of the model's outputs
    const auto state = model->state();
    return state->output_at(model->x_high()) - state->output_at(model->x_low());
  }
  [[nodiscard]] double measured(double y) const { return kOutputZero + kOutputGain * y; }
  [[nodiscard]] DynamicTaxel taxel() const { return in_time ? DynamicTaxel{{}, 1.2, 0.06} : DynamicTaxel{}; }
  [[nodiscard]] Dynamics dynamics() const {
    Dynamics own;
    if (in_time) own.creep_share = {0.015, 0.012, 0.01};
    own.creep_half = 6.0;
    return own;
  }
  [[nodiscard]] DynamicPlant plant() const { return {*truth, dynamics(), taxel(), 1}; }
  // `noise`: a share of the full output.
  [[nodiscard]] CompensatorSetup setup(double noise) const {
    CompensatorSetup own;
    own.zero = kOutputZero;
    own.gain = kOutputGain;
    own.noise = noise * kOutputGain * full();
    if (!in_time) return own;
    own.time = std::make_shared<PassedTime>();
    own.time->dynamics = dynamics();
    own.creep_scale = taxel().creep_scale;
    own.lag_share = taxel().lag_share;
    return own;
  }
  [[nodiscard]] std::unique_ptr<Compensator> stream(double noise) const {
    return make_compensator(*model, setup(noise));
  }
};

inline std::vector<Kind> kinds() {
  ElamModel elam = Array({.rows = 1, .columns = 1}).taxels.front();
  elam.options.exact_outer = false;
  std::vector<Kind> list;
  const auto add = [&](const std::string& name, auto model, bool in_time = false) {
    auto own = std::make_shared<decltype(model)>(std::move(model));
    list.push_back({name, own, own, in_time});
  };
  add("elam", ElamHysteresis(elam));
  list.back().truth = std::make_shared<ElamHysteresis>(elam, true);
  add("elam with memory", ElamHysteresis(elam, true));
  add("gpi", GpiModel(kGpiTable2, 0.0, 60.0, 0.0));
  add("mpi", MpiModel(kRisingMpi, 5.0, 65.0, 0.4));
  add("poly", rising_poly());
  add("preisach", random_preisach(4, 20, -20.0));
  const std::vector<double> x{0, 10, 30, 60}, y{0.0, 1.5, 2.8, 3.49};
  add("monotone", MonotoneModel(PatternCurve(x, y, 0.0, 3.49)));
  const LinearisedModel linearised(Divider{0.02, 0.23}, std::make_shared<PreisachModel>(film_of(1, 20)));
  add("linearised", linearised);
  add("linearised in time", linearised, true);
  add("gpi in time", GpiModel(kGpiTable2, 0.0, 60.0, 0.0), true);
  return list;
}

// From rest to drawn turning points of 0 to 60, `step` at most between samples. Of ELAM none lies between 50 and 60:
// there its stream takes the split of a turn at 60 (ElamStack::kDriftShare).
inline std::vector<double> reversals(const Kind& kind, std::size_t samples, double step, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> level(0.0, 60.0);
  std::vector<double> way{0.0};
  double target = 60.0;
  while (way.size() < samples) {
    const double now = way.back();
    if (now == target) target = level(random);
    if (target > 50.0 && kind.truth != kind.model) target = 60.0;
    way.push_back(std::abs(target - now) <= step ? target : now + std::copysign(step, target - now));
  }
  return way;
}

// Inputs and outputs along a way, and by how much an input is hidden at each sample by outputs `band` noises off.
struct Walk {
  std::vector<double> x, output, hidden;
  double seconds = 0.0;  // between two samples
};

class Walker {
 public:
  Walker(Kind kind, double noise, unsigned seed, double seconds = 0.4, double band = 9.0)
      : kind_(std::move(kind)), plant_(kind_.plant()), noise_(noise * kind_.full()), band_(band), random_(seed) {
    walk.seconds = seconds;
  }
  // `to`: on a range of 0 to 60, whatever the model's.
  void go(double to) {
    const double x = kind_.model->x_low() + kind_.span() * to / 60.0;
    const double y = plant_.step(x, walk.seconds);
    walk.x.push_back(x);
    walk.output.push_back(kind_.measured(y + noise_ * normal_(random_)));
    walk.hidden.push_back(plant_.hidden(band_ * noise_) + 1e-6 * kind_.span());
  }
  void go_along(const std::vector<double>& way) {
    for (const double to : way) go(to);
  }
  Walk walk;

 private:
  Kind kind_;
  DynamicPlant plant_;
  double noise_, band_;
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
};

inline Walk walk_of(const Kind& kind, const std::vector<double>& way, double noise, unsigned seed) {
  Walker walker(kind, noise, seed);
  walker.go_along(way);
  return walker.walk;
}

inline constexpr std::size_t kThree = 3;  // taxels of sensor_of()

// Two taxels of one kind, with different gain and noise, a dead one between them, and their mean.
inline SensorModel sensor_of(const Kind& kind, bool falling = false) {
  SensorModel model;
  model.model = kind.name;
  model.source = "run 1";
  model.input_unit = "psi";
  model.output_unit = std::string("V");
  model.rows = 1;
  model.columns = kThree;
  model.scans = 2;
  model.falling = falling;
  for (int i = 0; i <= 30; ++i) model.pressure_psi.push_back(kind.model->x_low() + kind.span() * i / 30.0);
  if (kind.in_time) {
    model.dynamics.emplace();
    model.dynamics->shared = kind.dynamics();
    model.dynamics->residual_shape = {0.5, 1.0, 1.5, 2.0};
  }
  for (const int number : {0, 1, 2, kMeanTaxel}) {
    ModelTaxel& taxel = model.taxels.emplace_back();
    taxel.taxel = number;
    if (number == 1) {
      taxel.status = TaxelStatus::kDead;
      continue;
    }
    taxel.status = TaxelStatus::kFitted;
    taxel.zero = kOutputZero;
    taxel.gain = number == 2 ? 0.9 * kOutputGain : kOutputGain;
    taxel.noise = kind.full() / (number == 2 ? 900.0 : 2000.0);
    taxel.residual_psi = 0.4;
    taxel.creep_scale = kind.taxel().creep_scale;
    taxel.lag_share = kind.taxel().lag_share;
    taxel.fit.model = kind.model;
    taxel.fit.full_scale = kind.full();
    taxel.loop_low = kind.model->state()->output_at(kind.model->x_low());
    const ElamModel* const elam = elam_of(taxel);  // whose loop is its patterns
    elam != nullptr ? set_loop(taxel, model.pressure_psi, elam->ascending.y(), elam->descending.y())
                    : set_loop(taxel, model.pressure_psi);
  }
  return model;
}

}  // namespace synthetic
