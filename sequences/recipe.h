// Recipes: measurements as data. A recipe names turning points and a step, or positions and forces; the compiler turns
// it into the steps that the sequencer executes. `plan` and `run` use the same compiler.
#pragma once

#include <cmath>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "devices/units.h"
#include "sequences/step.h"
#include "sequences/toml/strict_toml.h"

namespace tactbench::sequences {

enum class RecipeKind { kLevels, kPress };

// Where frames are taken. kLevels: `frames_per_level` at each level. kTurns: `frames_per_level` at the turning points,
// one at each level between them. kHolds: `frames_per_level` at the turning points only, except the lowest, which has
// one.
enum class FramesAt { kLevels, kTurns, kHolds };

// Cycles 0 -> peak -> 0 without frames: for levels before the first repeat, for press in the first repeat before the
// first branch at each position.
struct Conditioning {
  int cycles = 0;               // at most
  int least = 1;                // at least, if change_percent may end it
  double change_percent = 0.0;  // change from loop to loop in % of full scale below which it ends; 0: always all cycles
  devices::Psi peak{0.0};       // for levels
  double peak_n = 0.0;          // for press
};

struct WarmUp {  // before the first command, until the unloaded output is stable; none when at_most_s is 0
  double drift_percent_per_min = 0.1;
  double at_most_s = 0.0;
};

struct BranchRule {
  devices::Psi tolerance{0.2};   // a step back by more than this breaks a branch
  double tolerance_n = 0.2;      // the same for press recipes
  int redo = 2;                  // further attempts
  bool fail_when_broken = true;  // else the branch is flagged and the run continues
};

struct Suspension {      // beyond `trip` the run waits in the safe state until the value is within `resume` for hold_s
  std::string quantity;  // supply_bar | temperature_c
  bool below = true;     // trips below `trip`, resumes above `resume`; else the reverse
  double trip = 0.0, resume = 0.0;
  double hold_s = 10.0;
  double timeout_s = 3600.0;  // after a longer wait the run ends
};

struct FailFast {  // stops a hopeless run in its first cycle
  double least_response_v =
      0.0;  // least mean output of the array at the first peak, above the unloaded output; 0: no limit
  int most_dead_taxels = -1;  // taxels without response at the first peak; -1: no limit
};

struct Retry {
  int frame = 1;            // further attempts at a frame that failed
  int branch = 0;           // further attempts at a branch in which a device failed
  bool any_passes = false;  // if set, the verdict is pass if any attempt passes; else the worst attempt counts
};

struct PressPlan {
  std::string object;  // ring, point, ...: the pressing object; stored, and the footprint on a simulated rig
  std::vector<std::pair<double, double>> positions_mm;
  std::vector<double> forces_n;  // ascending; run upward, then downward, the peak once
  bool hold_force = false;       // else z does not move during the dwell
  double approach_mm_per_s = 0.5, contact_n = 0.2, servo_mm_per_s = 0.05, clear_mm = 5.0;
  bool registers = false;  // the touches are used to locate the taxels under the stage
  bool tare = true;        // before each repeat and after the last
};

struct Parameter {
  std::string name, unit, help;
  double value = 0.0, standard = 0.0, low = 0.0, high = 0.0;
};

// Levels are exact decimals of the file's unit, to nine places, so that they are equal on rising and falling branches.
inline double exact_decimal(double in_unit) { return std::round(in_unit * 1e9) / 1e9; }

struct Recipe {
  std::string name;
  std::string title;
  RecipeKind kind = RecipeKind::kLevels;
  std::vector<devices::Psi> turning_points;
  std::string drawn;  // text about drawn turning points: "31 turning points drawn, kind wander, seed 1"; empty: they
                      // are listed in the file
  devices::Psi step{2.0};
  double psi_per_unit = 1.0;                // the file's unit
  std::vector<double> dwell_s{2.0};         // from pressure (force) in band to the frame; repeat i uses i % size
  std::vector<double> ramp_psi_per_s{0.0};  // per repeat in the same way; 0: the bench's own rate limit
  bool settle = true;                       // false: frames are taken while the ramp passes the levels
  int frames_per_level = 1;
  double frame_interval_s = 0.0;
  FramesAt frames_at = FramesAt::kLevels;
  int repeats = 1;
  double dwell_tolerance_s = 0.25;  // frames whose dwell deviates by more are flagged
  double rest_restart_s = 3600.0;   // after a longer rest, a resumed run redoes the whole repeat
  double step_timeout_s = 0.0;      // 0: only the bench's own timeouts
  Conditioning conditioning;
  WarmUp warm_up;
  BranchRule guard;
  std::vector<Suspension> suspend;
  FailFast limits;
  Retry retry;
  std::string prompt_before;  // shown before the sequence; empty: no prompt
  PressPlan press;            // RecipeKind::kPress
  std::vector<Parameter> parameters;
  std::string text;  // the file, stored with the run
};

// Reads a recipe file and applies `overrides`: the name of a declared parameter sets it, any other key replaces the
// file's. Throws FileError.
Recipe read_recipe(const std::string& path, const std::vector<Override>& overrides = {});
Recipe parse_recipe(TomlDocument document, const std::vector<Override>& overrides = {});
std::vector<KeyFacts> recipe_keys();

// One recipe; or those that the file names by `recipes = [...]`, one after the other in the same run.
struct RecipeFile {
  std::string name, title, text;
  std::vector<Recipe> recipes;
};
// `find` returns the path of a named recipe. `overrides` are applied to each. Throws FileError.
RecipeFile read_recipe_file(const std::string& path, const std::vector<Override>& overrides,
                            const std::function<std::string(const std::string& name)>& find);

// Greatest number of steps of a run: a step takes about 300 bytes of memory and a row in the store, and with the least
// dwell of 0.1 s a million steps take more than a day.
constexpr double kMaxSteps = 1e6;
// Number of steps that compile() returns, computed without compiling. A recipe from read_recipe() has at most
// kMaxSteps.
double step_count(const Recipe& recipe);

// Per repeat 211 measuring steps for the paper's descending set, 451 for the ascending one.
std::vector<Step> compile(const Recipe& recipe, int sequence);
// Throws FileError when all recipes together have more than kMaxSteps.
std::vector<Step> compile(const std::vector<Recipe>& recipes);

// Travel steps needed before `branch` of `repeat` can be repeated, all without frames: the conditioning cycles (one to
// the highest level if the recipe has none), then the repeat's turning points up to the one at which the branch starts.
// Press: retract, home, tare, move, approach, conditioning, and for a falling branch up to the peak. kHome may be
// skipped if the axes are homed.
std::vector<Step> path_to_branch(const Recipe& recipe, int sequence, int repeat, int branch);

}  // namespace tactbench::sequences
