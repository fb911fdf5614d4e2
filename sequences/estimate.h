// Time of compiled steps, estimated from a model before any measurement, and the size of their rows in the store.
#pragma once

#include <vector>

#include "sequences/recipe.h"

namespace tactbench::sequences {

struct TimeModel {
  double rise_psi_per_s = 60.0, fall_psi_per_s = 60.0;  // of the chamber
  double settle_s = 0.65;                               // from the end of the ramp to pressure in band
  double frame_s = 0.0;                                 // to read one frame
  double prompt_s = 30.0, home_s = 20.0, tare_s = 2.0, move_s = 5.0;
  double stiffness_n_per_mm = 20.0;  // of the contact: converts the servo's travel to newtons
};

// 10 % of the runs should be shorter than `low`, 10 % longer than `high`. The model's bounds are estimates: settling
// takes 0.7 to 2 times its time; `low` omits cycles and warm-up that a criterion may end.
struct StepTime {
  double low_s = 0.0, likely_s = 0.0, high_s = 0.0;
};

// One per step, in process time.
std::vector<StepTime> step_times(const std::vector<Recipe>& recipes, const std::vector<Step>& steps,
                                 const TimeModel& model);

struct Estimate {
  int steps = 0;
  int frames = 0;
  StepTime time;
  double bytes = 0.0;  // in the store
};

// `frame_bytes`: size of one stored frame's blob.
Estimate estimate(const std::vector<Recipe>& recipes, const std::vector<Step>& steps, const TimeModel& model,
                  double frame_bytes);

}  // namespace tactbench::sequences
