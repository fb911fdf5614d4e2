// What compile() in recipe.h makes of recipes: the steps in order; and their lowest and highest set-points. `plan`
// prints the steps, `run` carries them out.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "devices/units.h"

namespace tactbench::sequences {

enum class StepKind {
  kConditioning,  // travel to a chamber level, no frame
  kMeasure,       // a chamber level: ramp, settle, dwell, frame
  kPrompt,        // asks the operator `text` and waits
  kTare,          // without contact: reads the force (its drift since the last tare), then biases the sensor
  kHome,          // axes z, x, y
  kMoveXy,        // without contact, to x_mm, y_mm
  kApproach,      // z down until contact is detected
  kPress,         // servo to force_n, dwell, frame (none where `frame` is false)
  kRetract,       // z back to the clear position
};
const char* to_string(StepKind kind);

struct Step {
  StepKind kind = StepKind::kMeasure;
  int sequence = 0;  // index of the recipe within the run
  int repeat = 0;    // for conditioning: the cycle
  int branch = 0;    // within the repeat; the frame of a turning point belongs to the branch that reaches it; -1: a
                     // conditioning cycle, which a criterion may skip
  int ordinal = 0;   // of the frame within the repeat; of a step without a frame: of the next frame
  devices::Psi setpoint;
  devices::Psi branch_from, branch_to;
  double dwell_s = 0.0;         // from in band to the frame
  double ramp_psi_per_s = 0.0;  // 0: the bench's own rate limit
  bool settle = true;           // false: the frame is taken as the ramp passes the level, without a band
  bool hold = false;            // a further frame at the same level: no new command, dwell_s after the previous frame
  bool frame = true;            // kPress only: false means travel to the force without a frame
  double force_n = 0.0, force_from_n = 0.0, force_to_n = 0.0;  // 0 in pressure steps
  bool hold_force = false;                                     // servo continues during the dwell; else z does not move
  double x_mm = 0.0, y_mm = 0.0;
  std::string text;
  bool operator==(const Step&) const = default;
};

[[nodiscard]] bool has_frame(const Step& step);

// One line that describes a step completely: equal steps give equal lines, different steps different lines. In another
// unit than psi, to six digits.
std::string step_line(const Step& step, const char* unit = "psi", double per_psi = 1.0);

struct BranchKey {
  int sequence = 0, repeat = 0, branch = 0;
  auto operator<=>(const BranchKey&) const = default;
};

// Steps that belong together: a branch (with frames, repeated as a whole), the conditioning cycles of one sequence, or
// the other steps (prompt, tare, home, move, approach, retract). Spans cover all steps, in order.
enum class SpanKind { kBranch, kConditioning, kTravel };
struct BranchSpan {
  SpanKind kind = SpanKind::kBranch;
  BranchKey key;  // kBranch: the branch; else only `sequence` and `repeat` are set
  std::size_t first = 0, count = 0;
};
std::vector<BranchSpan> branches(const std::vector<Step>& steps);

// Extremes of the steps, which a preflight compares with the limits.
struct Extremes {
  devices::Psi lowest{0.0}, highest{0.0};
  double largest_force_n = 0.0;
  bool moves = false;  // x and y below are set
  double lowest_x_mm = 0.0, highest_x_mm = 0.0, lowest_y_mm = 0.0, highest_y_mm = 0.0;
  double fastest_ramp_psi_per_s = 0.0;  // 0: only the bench's own
  bool pressurizes = false, presses = false;
};
Extremes extremes(const std::vector<Step>& steps);

}  // namespace tactbench::sequences
