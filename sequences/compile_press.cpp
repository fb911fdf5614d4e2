#include "sequences/compile_press.h"

namespace tactbench::sequences {

namespace {

// Appends steps one after another; the values that persist from step to step are in `now`.
class PressWriter {
 public:
  PressWriter(std::vector<Step>& steps, const Recipe& recipe, int sequence)
      : steps_(steps), recipe_(recipe), plan_(recipe.press) {
    now_.sequence = sequence;
    now_.hold_force = plan_.hold_force;
  }

  void begin_repeat(int repeat) {
    now_.repeat = repeat;
    now_.ordinal = 0;
    now_.dwell_s = recipe_.dwell_s[static_cast<std::size_t>(repeat) % recipe_.dwell_s.size()];
    place(0);
  }
  void place(std::size_t position) {
    now_.branch = static_cast<int>(2 * position);
    now_.x_mm = plan_.positions_mm[position].first;
    now_.y_mm = plan_.positions_mm[position].second;
  }
  void skip_to_frame(int ordinal) { now_.ordinal = ordinal; }

  void plain(StepKind kind) {
    Step step = now_;
    step.kind = kind;
    if (kind == StepKind::kHome || kind == StepKind::kTare) step.x_mm = step.y_mm = 0.0;
    step.dwell_s = 0.0;
    step.hold_force = false;
    steps_.push_back(step);
  }

  void condition() {
    const Step before = now_;
    now_.branch = -1;
    for (now_.repeat = 0; now_.repeat < recipe_.conditioning.cycles; ++now_.repeat) {
      plain(StepKind::kApproach);
      press(recipe_.conditioning.peak_n, 0.0, recipe_.conditioning.peak_n, false);
      plain(StepKind::kRetract);
    }
    now_ = before;
  }

  void up(bool frames) {
    for (const double force : plan_.forces_n) press(force, 0.0, plan_.forces_n.back(), frames);
  }
  void down() {
    ++now_.branch;
    for (std::size_t i = plan_.forces_n.size() - 1; i-- > 0;) {
      press(plan_.forces_n[i], plan_.forces_n.back(), plan_.forces_n.front(), true);
    }
  }

 private:
  void press(double force, double from, double to, bool frame) {
    Step step = now_;
    step.kind = StepKind::kPress;
    step.force_n = force;
    step.force_from_n = from;
    step.force_to_n = to;
    step.frame = frame;
    steps_.push_back(step);
    if (frame) ++now_.ordinal;
  }

  std::vector<Step>& steps_;
  const Recipe& recipe_;
  const PressPlan& plan_;
  Step now_;
};

}  // namespace

void add_press(std::vector<Step>& steps, const Recipe& recipe, int sequence) {
  PressWriter writer(steps, recipe, sequence);
  for (int repeat = 0; repeat < recipe.repeats; ++repeat) {
    writer.begin_repeat(repeat);
    if (repeat == 0) writer.plain(StepKind::kHome);
    if (recipe.press.tare) writer.plain(StepKind::kTare);
    for (std::size_t position = 0; position < recipe.press.positions_mm.size(); ++position) {
      writer.place(position);
      writer.plain(StepKind::kMoveXy);
      if (repeat == 0) writer.condition();
      writer.plain(StepKind::kApproach);
      writer.up(true);
      writer.down();
      writer.plain(StepKind::kRetract);
    }
  }
  if (recipe.press.tare) writer.plain(StepKind::kTare);
}

std::vector<Step> press_way_back(const Recipe& recipe, int sequence, int repeat, int branch) {
  std::vector<Step> steps;
  PressWriter writer(steps, recipe, sequence);
  const auto position = static_cast<std::size_t>(branch / 2);
  const bool falling = branch % 2 == 1;
  const int frames_up = static_cast<int>(recipe.press.forces_n.size());
  const int frames_a_position = 2 * frames_up - 1;
  writer.begin_repeat(repeat);
  writer.place(position);
  writer.skip_to_frame(branch / 2 * frames_a_position + (falling ? frames_up : 0));
  writer.plain(StepKind::kRetract);
  writer.plain(StepKind::kHome);
  if (recipe.press.tare) writer.plain(StepKind::kTare);
  writer.plain(StepKind::kMoveXy);
  writer.condition();
  writer.plain(StepKind::kApproach);
  if (falling) writer.up(false);
  return steps;
}

}  // namespace tactbench::sequences
