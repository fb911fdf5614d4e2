// Brings the force to a level from one side only: a loading branch never moves back, an unloading one never forward,
// since a correction in the other direction would start a minor loop in a hysteretic specimen. A layer between press.h
// (above) and press_axis.h (below).
#pragma once

#include <optional>

#include "bench/run/press/approach.h"
#include "bench/run/press/press_axis.h"

namespace tactbench::bench {

enum class Branch { kLoading, kUnloading };

struct BranchBroken {  // a level was passed by more than its tolerance: the branch must be repeated
  double target_n = 0.0, force_n = 0.0;
  double overshoot_n = 0.0;  // beyond the target, in the branch's direction
};

struct ServoResult {
  ForceSample reading;  // the last
  int moves = 0;
  std::optional<BranchBroken> broken;
};

class ForceServo {
 public:
  explicit ForceServo(PressAxis& axis) : axis_(axis) {}
  // Resets to a new contact, at the present z, approached from above.
  void begin(const ContactPoint& contact);
  // Moves z in steps, each followed by a reading at rest, until the force is at most `band_n` short of the target or
  // beyond it; beyond by more than the level's tolerance sets `broken`. A step is the remaining force divided by the
  // stiffness of the last step and by a factor for stiffness that increases ahead. Throws TB-PRESS-TIMEOUT (moves or
  // time used up), TB-PRESS-NO-FORCE (z at its end without the force), and the faults of PressAxis.
  [[nodiscard]] ServoResult to(double target_n, Branch branch, double band_n);
  [[nodiscard]] double stiffness_n_per_mm() const { return stiffness_; }

 private:
  void turn(Branch branch, double force_n);
  [[nodiscard]] double step(double force_n, double target_n, double left_n) const;
  void learn(const ForceSample& before, const ForceSample& after);
  void check_bounds(double target_n, double force_n, int moves, devices::Nanoseconds deadline) const;
  [[nodiscard]] double next_z(double target_n, double force_n, double step_mm, Branch branch) const;
  PressAxis& axis_;
  double contact_z_mm_ = 0.0;
  double stiffness_ = 0.0;  // N/mm, from the last step that was large enough to measure it
  double span_n_ = 0.0;     // change of force over which it was measured
  double seen_at_n_ = 0.0;  // the mean force of that step
  double power_ = 0.0;      // stiffness grows as this power of the force
  double since_turn_mm_ = 0.0;
  double turned_at_n_ = 0.0;
  double last_step_mm_ = 0.0;  // last step at this level
  Branch branch_ = Branch::kLoading;
};

}  // namespace tactbench::bench
