// What to do, as data: a recipe names turning points and a step; the compiler turns it into the very steps that the
// sequencer carries out. `plan` and `run` use the same compiler.
#pragma once

#include <string>
#include <vector>

#include "devices/units.h"
#include "sequences/strict_toml.h"

namespace tactbench::sequences {

struct Recipe {
  std::string name;
  std::string title;
  std::vector<devices::Psi> turning_points;
  devices::Psi step{2.0};
  double dwell_s = 2.0;  // from pressure in band to the frame
  int repeats = 1;
  int conditioning_cycles = 0;  // 0 -> peak -> 0 before the first repeat, without frames
  devices::Psi conditioning_peak{0.0};
  std::string text;  // the file, stored with the run
};

// Reads a recipe file, `overrides` applied. Throws FileError.
Recipe read_recipe(const std::string& path, const std::vector<Override>& overrides = {});
Recipe parse_recipe(const TomlDocument& document);

enum class StepKind { kConditioning, kMeasure };

struct Step {
  StepKind kind = StepKind::kMeasure;
  int sequence = 0;  // index of the recipe within the run
  int repeat = 0;
  int branch = 0;   // within the repeat; the frame at a turning point belongs to the branch that reaches it
  int ordinal = 0;  // within the repeat
  devices::Psi setpoint;
  devices::Psi branch_from, branch_to;
  double dwell_s = 0.0;
};

// 211 measuring steps a repeat for the paper's descending set, 451 for the ascending one.
std::vector<Step> compile(const Recipe& recipe, int sequence);
std::vector<Step> compile(const std::vector<Recipe>& recipes);

struct Estimate {
  int steps = 0;
  int frames = 0;
  devices::Psi lowest, highest;
  double seconds = 0.0;  // process time
  double bytes = 0.0;    // in the store
};

// `slew_psi_per_s` and `settle_s` model the chamber between levels; `frame_bytes` is one stored frame's blob.
Estimate estimate(const std::vector<Step>& steps, double slew_psi_per_s, double settle_s, double frame_bytes);

}  // namespace tactbench::sequences
