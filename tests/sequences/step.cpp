// Lines, spans and extremes of steps.
#include "sequences/step.h"

#include <catch2/catch.hpp>

#include "sequences/recipe.h"
#include "tests/sequences/recipe_text.h"

using namespace tactbench::sequences;
using tactbench::devices::Psi;

namespace {

Recipe three_touches(const std::string& more = {}) {
  return press_of("forces_n = [2, 6]\npositions_mm = [[30, 20], [10, 40], [20, 5]]\n" + more);
}

struct Stretch {
  SpanKind kind;
  std::size_t first, count;
};

void check_stretches(const std::vector<BranchSpan>& spans, const std::vector<Stretch>& wanted) {
  REQUIRE(spans.size() == wanted.size());
  for (std::size_t i = 0; i < spans.size(); ++i) {
    INFO("span " << i);
    CHECK(spans[i].kind == wanted[i].kind);
    CHECK(spans[i].first == wanted[i].first);
    CHECK(spans[i].count == wanted[i].count);
  }
}

}  // namespace

TEST_CASE("frames of steps: only measuring and press steps have one, and no press that only travels") {
  for (const StepKind kind :
       {StepKind::kConditioning, StepKind::kMeasure, StepKind::kPrompt, StepKind::kTare, StepKind::kHome,
        StepKind::kMoveXy, StepKind::kApproach, StepKind::kPress, StepKind::kRetract}) {
    Step step;
    step.kind = kind;
    CHECK(has_frame(step) == (kind == StepKind::kMeasure || kind == StepKind::kPress));
    step.frame = false;
    CHECK(!has_frame(step));
  }
}

TEST_CASE("branch spans: each recipe of a run has its own") {
  const Recipe up = recipe_of("turning_points = [0, 2]\nstep = 2\n");
  const auto spans = branches(compile({up, up}));
  check_stretches(spans, {{SpanKind::kBranch, 0, 2}, {SpanKind::kBranch, 2, 2}});
  CHECK((spans[0].key == BranchKey{0, 0, 0} && spans[1].key == BranchKey{1, 0, 0}));
  const Recipe conditioned = recipe_of("turning_points = [0, 2]\nstep = 2\n[conditioning]\ncycles = 2\npeak = 2\n");
  check_stretches(branches(path_to_branch(conditioned, 3, 0, 0)), {{SpanKind::kConditioning, 0, 4}});
}

TEST_CASE("branch spans: press steps are split into branches, conditioning and travel") {
  const auto steps = compile(three_touches("[conditioning]\ncycles = 2\n"), 0);
  // home, tare | move | 2 x (approach, press, retract) | approach | 2 up | 1 down | retract and so on.
  const auto travel = SpanKind::kTravel, conditioning = SpanKind::kConditioning, branch = SpanKind::kBranch;
  const auto spans = branches(steps);
  check_stretches({spans.begin(), spans.begin() + 5},
                  {{travel, 0, 3}, {conditioning, 3, 6}, {travel, 9, 1}, {branch, 10, 2}, {branch, 12, 1}});
  CHECK((spans[3].key == BranchKey{0, 0, 0} && spans[4].key == BranchKey{0, 0, 1}));
  std::size_t covered = 0;
  for (const BranchSpan& span : spans) covered += span.count;
  CHECK(covered == steps.size());
  // retract, home, tare, move | a cycle | approach | up to the peak without frames: it conditions, too.
  const Recipe once = three_touches("[conditioning]\ncycles = 1\n");
  check_stretches(branches(path_to_branch(once, 0, 0, 1)),
                  {{travel, 0, 4}, {conditioning, 4, 3}, {travel, 7, 1}, {conditioning, 8, 2}});
}

TEST_CASE("step extremes: lowest and highest values are found, also if neither first nor last") {
  const Extremes levels = extremes(compile(recipe_of("turning_points = [4, 8, 2, 6]\nstep = 2\nsettle = \"none\"\n"
                                                     "ramp_psi_per_s = [0.5, 0.75, 0.25]\n"),
                                           0));
  CHECK((levels.lowest == Psi(2.0) && levels.highest == Psi(8.0) && levels.fastest_ramp_psi_per_s == 0.75));
  CHECK((levels.pressurizes && !levels.presses && !levels.moves && levels.largest_force_n == 0.0));
  // Levels of conditioning count.
  const Extremes conditioned =
      extremes(compile(recipe_of("turning_points = [4, 8]\nstep = 2\n[conditioning]\ncycles = 1\npeak = 9\n"), 0));
  CHECK((conditioned.lowest == Psi(0.0) && conditioned.highest == Psi(9.0)));
  CHECK(conditioned.fastest_ramp_psi_per_s == 0.0);
  const Extremes touches = extremes(compile(three_touches(), 0));
  CHECK((touches.presses && touches.moves && !touches.pressurizes && touches.largest_force_n == 6.0));
  CHECK((touches.lowest_x_mm == 10.0 && touches.highest_x_mm == 30.0));
  CHECK((touches.lowest_y_mm == 5.0 && touches.highest_y_mm == 40.0));
  CHECK((touches.lowest == Psi(0.0) && touches.highest == Psi(0.0)));
  Step approach;
  approach.kind = StepKind::kApproach;
  CHECK(extremes({approach}).presses);
  CHECK(!extremes({approach}).moves);
  const Extremes none = extremes({});
  CHECK((!none.presses && !none.moves && !none.pressurizes && none.fastest_ramp_psi_per_s == 0.0));
}
