// Carries out the stage's steps of a run that presses: home, move, approach, press, retract. Passes recipe steps to
// Press and its results to the recorder. The chamber is disarmed and vented meanwhile.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "bench/run/press/press.h"
#include "bench/run/press/registration.h"
#include "bench/run/recorder.h"
#include "bench/run/sequencer.h"

namespace tactbench::bench {

// Options from the bench, its limits and the recipe.
PressOptions press_options(const BenchConfig& config, const sequences::Recipe& recipe);
// Conflicts of the recipe with bench and force sensor, including the overshoot (press.h); empty: none.
// Requires a bench with stage and force sensor.
std::vector<std::string> press_complaints(const sequences::Recipe& recipe, const BenchConfig& config,
                                          const std::array<double, 6>& force_range);

class StageSteps {
 public:
  StageSteps(Sequencer& sequencer, Recorder& recorder) : sequencer_(sequencer), recorder_(recorder) {}
  // Opens stage and force sensor at the first step. Throws Fault, RunEndRequested, PathBroken (a level was overshot),
  // and Error TB-BENCH-NO-STAGE when the bench has none.
  void carry_out(const sequences::Step& step, const sequences::Recipe& recipe);
  // To be called after the rig was made safe, when there is no contact any more.
  void forget();
  // Registration from the touches so far; stored as a check of kind "mount". Throws Fault TB-MOUNT-*.
  void register_mount(double pitch_mm, const std::vector<double>& baseline);

 private:
  void open(const sequences::Recipe& recipe);
  void press(const sequences::Step& step, const sequences::Recipe& recipe);
  struct TouchFrame {
    double x_mm = 0.0, y_mm = 0.0;
    std::vector<double> counts;
  };
  Sequencer& sequencer_;
  Recorder& recorder_;
  std::unique_ptr<Press> press_;
  double x_mm_ = 0.0, y_mm_ = 0.0;
  std::vector<TouchFrame> touches_;
};

}  // namespace tactbench::bench
