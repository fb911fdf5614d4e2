// The very steps that a recipe of levels becomes, all their fields, against lists written out by hand.

#include <catch2/catch.hpp>

#include <cmath>
#include <map>
#include <set>
#include <string>

#include "sequences/recipe.h"
#include "sequences/step.h"
#include "tests/sequences/refusal.h"

using namespace tactbench::sequences;
using tactbench::devices::Psi;

namespace {

struct Level {
  int branch;
  double from_psi, to_psi, psi;
};

Step step_of(StepKind kind, int sequence, int repeat, const Level& level, double dwell_s) {
  Step step;
  step.kind = kind;
  step.sequence = sequence;
  step.repeat = repeat;
  step.branch = level.branch;
  step.branch_from = Psi(level.from_psi);
  step.branch_to = Psi(level.to_psi);
  step.setpoint = Psi(level.psi);
  step.dwell_s = dwell_s;
  return step;
}

void check_same(const std::vector<Step>& steps, const std::vector<Step>& wanted) {
  REQUIRE(steps.size() == wanted.size());
  for (std::size_t i = 0; i < steps.size(); ++i) {
    INFO("step " << i << ": " << step_line(steps[i]) << "\n wanted " << step_line(wanted[i]));
    CHECK(steps[i] == wanted[i]);
  }
}

// Cycles of conditioning 0 -> peak -> 0.
void append_cycles(std::vector<Step>& steps, int sequence, int cycles, double peak_psi, double dwell_s) {
  for (int cycle = 0; cycle < cycles; ++cycle) {
    steps.push_back(step_of(StepKind::kConditioning, sequence, cycle, {-1, 0.0, peak_psi, peak_psi}, dwell_s));
    steps.push_back(step_of(StepKind::kConditioning, sequence, cycle, {-1, peak_psi, 0.0, 0.0}, dwell_s));
  }
}

const std::string kUpAndDown =
    "turning_points = [2, 6, 4]\nstep = 2\ndwell_s = [1, 3]\nramp_psi_per_s = [0.5, 0.25]\nrepeats = 3\n"
    "frames_per_level = 2\nframe_interval_s = 0.125\n";

}  // namespace

TEST_CASE("compile: a levels recipe gives the expected steps, field by field") {
  const Recipe recipe =
      recipe_of(kUpAndDown + "[conditioning]\ncycles = 2\npeak = 8\n[prompt]\nbefore = \"loaded?\"\n");
  std::vector<Step> wanted;
  Step prompt;
  prompt.kind = StepKind::kPrompt;
  prompt.sequence = 5;
  prompt.text = "loaded?";
  wanted.push_back(prompt);
  append_cycles(wanted, 5, 2, 8.0, 1.0);
  // The frame of a turning point belongs to the branch that reaches it; the start belongs to the first branch.
  const std::vector<Level> levels = {{0, 2, 6, 2}, {0, 2, 6, 4}, {0, 2, 6, 6}, {1, 6, 4, 4}};
  const std::vector<double> dwell_s = {1.0, 3.0, 1.0}, ramp = {0.5, 0.25, 0.5};
  for (int repeat = 0; repeat < 3; ++repeat) {
    int ordinal = 0;
    for (const Level& level : levels) {
      for (const bool hold : {false, true}) {
        Step step = step_of(StepKind::kMeasure, 5, repeat, level, hold ? 0.125 : dwell_s[repeat]);
        step.ramp_psi_per_s = ramp[repeat];
        step.hold = hold;
        step.ordinal = ordinal++;
        wanted.push_back(step);
      }
    }
  }
  check_same(compile(recipe, 5), wanted);
}

TEST_CASE("compile: a recipe of one level gives its frames only") {
  const Recipe recipe = recipe_of("turning_points = [3]\nstep = 1\nframes_per_level = 3\nframe_interval_s = 4\n");
  std::vector<Step> wanted;
  for (int i = 0; i < 3; ++i) {
    wanted.push_back(step_of(StepKind::kMeasure, 0, 0, {0, 3, 3, 3}, i == 0 ? 2.0 : 4.0));
    wanted.back().hold = i > 0;
    wanted.back().ordinal = i;
  }
  check_same(compile(recipe, 0), wanted);
  const auto back =
      path_to_branch(recipe, 0, 0, 0);  // a cycle to the highest level, for the recipe has none of its own
  std::vector<Step> cycle;
  append_cycles(cycle, 0, 1, 3.0, 2.0);
  check_same(back, cycle);
}

TEST_CASE("compile: levels between turning points lie on the grid, turning points are exact") {
  // Three steps of 0.1 from 0.1 are 0.4 on paper; as sums of doubles they are not.
  const auto steps = compile(recipe_of("turning_points = [0.1, 0.4]\nstep = 0.1\n"), 0);
  REQUIRE(steps.size() == 4);
  CHECK((steps[0].branch_from == Psi(0.1) && steps[0].branch_to == Psi(0.4)));
  CHECK(steps[1].setpoint.value() == Approx(0.2).epsilon(1e-12));
  CHECK(steps[2].setpoint.value() == Approx(0.3).epsilon(1e-12));
  CHECK(steps[3].setpoint == Psi(0.4));
}

TEST_CASE("way back: to a branch of a later repeat has the expected steps, field by field") {
  const Recipe recipe = recipe_of(kUpAndDown + "[conditioning]\ncycles = 2\npeak = 8\n");
  std::vector<Step> wanted;
  append_cycles(wanted, 4, 2, 8.0, 1.0);
  // Repeat 1 dwells 3 s and ramps at 0.25 psi/s. To branch 1: the start, then the turning point that branch 0 ends in.
  for (const Level& level : std::vector<Level>{{0, 2, 2, 2}, {0, 2, 6, 6}}) {
    wanted.push_back(step_of(StepKind::kConditioning, 4, 1, level, 3.0));
    wanted.back().ramp_psi_per_s = 0.25;
  }
  check_same(path_to_branch(recipe, 4, 1, 1), wanted);
}

TEST_CASE("way back: uses the recipe's own conditioning cycles, even a single one") {
  std::vector<Step> wanted;
  append_cycles(wanted, 0, 1, 8.0, 1.0);
  check_same(path_to_branch(recipe_of(kUpAndDown + "[conditioning]\ncycles = 1\npeak = 8\n"), 0, 0, 0), wanted);
}

TEST_CASE("way back: of a press recipe starts with a retraction, of a levels recipe with conditioning") {
  const Recipe press = press_of("forces_n = [1]\npositions_mm = [[1, 1]]\n");
  CHECK(path_to_branch(press, 0, 0, 0).front().kind == StepKind::kRetract);
  CHECK(path_to_branch(recipe_of(kUpAndDown), 0, 0, 0).front().kind == StepKind::kConditioning);
}

TEST_CASE("compile: the steps of a run are those of its recipes in order, numbered by sequence") {
  const Recipe first = recipe_of("turning_points = [0, 2]\nstep = 1\n"), second = recipe_of(kUpAndDown);
  std::vector<Step> wanted = compile(first, 0);
  for (const Step& step : compile(second, 1)) wanted.push_back(step);
  check_same(compile({first, second}), wanted);
}

TEST_CASE("compile: a million steps in total are accepted, more are refused with the recipes' names") {
  // 2 levels x 500 repeats x 1000 frames.
  const std::string million = "turning_points = [0, 2]\nstep = 2\nrepeats = 500\nframes_per_level = 1000\n";
  CHECK(compile({recipe_of(million)}).size() == 1'000'000);
  check_refusal(
      [&] {
        (void)compile({recipe_of(million), recipe_of("turning_points = [0]\nstep = 2\nframes_per_level = 2\n")});
      },
      {"two steps more", "TB-FILE-VALUE", " t, t", " 1000002 "});
}

namespace {

struct Touch {
  StepKind kind;
  int repeat, branch, ordinal;
  double x_mm, y_mm;
  double force_n = 0.0, from_n = 0.0, to_n = 0.0;
  bool frame = true;
};

// Steps that press dwell; `dwell_s` of each repeat.
void check_touches(const std::vector<Step>& steps, const std::vector<Touch>& touches,
                   const std::vector<double>& dwell_s) {
  REQUIRE(steps.size() == touches.size());
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const Touch& touch = touches[i];
    const bool press = touch.kind == StepKind::kPress;
    Step wanted;
    wanted.kind = touch.kind;
    wanted.sequence = 2;
    wanted.repeat = touch.repeat;
    wanted.branch = touch.branch;
    wanted.ordinal = touch.ordinal;
    wanted.x_mm = touch.x_mm;
    wanted.y_mm = touch.y_mm;
    wanted.force_n = touch.force_n;
    wanted.force_from_n = touch.from_n;
    wanted.force_to_n = touch.to_n;
    wanted.frame = touch.frame;
    wanted.hold_force = press;
    wanted.dwell_s = press ? dwell_s[touch.branch < 0 ? 0 : touch.repeat] : 0.0;
    INFO("step " << i << ": " << step_line(steps[i]) << "\n wanted " << step_line(wanted));
    CHECK(steps[i] == wanted);
  }
}

constexpr auto kGoHome = StepKind::kHome, kBias = StepKind::kTare, kGo = StepKind::kMoveXy, kDown = StepKind::kApproach,
               kLoad = StepKind::kPress, kAway = StepKind::kRetract;

Recipe presses(const std::string& press, const std::string& root) {
  return press_of("hold = \"force\"\n" + press, root);
}

}  // namespace

TEST_CASE("compile: a press recipe gives the expected steps, field by field") {
  const Recipe recipe =
      presses("positions_mm = [[10, 20], [30, 40]]\nforces_n = [2, 6]\n[conditioning]\ncycles = 2\npeak_n = 5\n",
              "repeats = 2\ndwell_s = [1, 3]\n");
  std::vector<Touch> wanted = {{kGoHome, 0, 0, 0, 0, 0}, {kBias, 0, 0, 0, 0, 0}};
  for (int repeat = 0; repeat < 2; ++repeat) {
    if (repeat == 1) wanted.push_back({kBias, 1, 0, 0, 0, 0});
    int ordinal = 0;
    for (int at = 0; at < 2; ++at) {
      const double x = at == 0 ? 10.0 : 30.0, y = at == 0 ? 20.0 : 40.0;
      wanted.push_back({kGo, repeat, 2 * at, ordinal, x, y});
      for (int cycle = 0; cycle < 2 && repeat == 0; ++cycle) {  // the specimen is conditioned once at each position
        wanted.push_back({kDown, cycle, -1, ordinal, x, y});
        wanted.push_back({kLoad, cycle, -1, ordinal, x, y, 5.0, 0.0, 5.0, false});
        wanted.push_back({kAway, cycle, -1, ordinal, x, y});
      }
      wanted.push_back({kDown, repeat, 2 * at, ordinal, x, y});
      wanted.push_back({kLoad, repeat, 2 * at, ordinal, x, y, 2.0, 0.0, 6.0});
      wanted.push_back({kLoad, repeat, 2 * at, ordinal + 1, x, y, 6.0, 0.0, 6.0});
      wanted.push_back({kLoad, repeat, 2 * at + 1, ordinal + 2, x, y, 2.0, 6.0, 2.0});
      ordinal += 3;
      wanted.push_back({kAway, repeat, 2 * at + 1, ordinal, x, y});
    }
  }
  wanted.push_back({kBias, 1, 3, 6, 0, 0});
  check_touches(compile(recipe, 2), wanted, {1.0, 3.0});
  Recipe untared = recipe;
  untared.press.tare = false;
  std::erase_if(wanted, [](const Touch& touch) { return touch.kind == kBias; });
  check_touches(compile(untared, 2), wanted, {1.0, 3.0});
}

TEST_CASE("way back: to a falling branch of a press has the expected steps, field by field") {
  const Recipe recipe =
      presses("positions_mm = [[10, 20], [30, 40]]\nforces_n = [2, 6]\n[conditioning]\ncycles = 1\npeak_n = 5\n",
              "repeats = 2\ndwell_s = [1, 3]\n");
  // Position 1 begins with frame 3; its falling branch, 3, with frame 5.
  const int repeat = 1, ordinal = 5;
  const std::vector<Step> steps = path_to_branch(recipe, 2, repeat, 3);
  REQUIRE(steps.size() == 10);
  std::vector<Step> without_cycle = steps;
  without_cycle.erase(without_cycle.begin() + 4, without_cycle.begin() + 7);
  check_touches(without_cycle,
                {{kAway, repeat, 2, ordinal, 30, 40},
                 {kGoHome, repeat, 2, ordinal, 0, 0},
                 {kBias, repeat, 2, ordinal, 0, 0},
                 {kGo, repeat, 2, ordinal, 30, 40},
                 {kDown, repeat, 2, ordinal, 30, 40},
                 {kLoad, repeat, 2, ordinal, 30, 40, 2.0, 0.0, 6.0, false},
                 {kLoad, repeat, 2, ordinal, 30, 40, 6.0, 0.0, 6.0, false}},
                {1.0, 3.0});
  for (std::size_t i = 4; i < 7; ++i) {  // the cycle, in the dwell of the repeat that is done again
    CHECK((steps[i].branch == -1 && steps[i].repeat == 0 && steps[i].x_mm == 30.0));
    CHECK(steps[i].dwell_s == (i == 5 ? 3.0 : 0.0));
  }
  // Its rising branch begins at contact with frame 3.
  const auto rising = path_to_branch(recipe, 2, repeat, 2);
  CHECK((rising.size() == 8 && rising.back().kind == kDown && rising.back().ordinal == 3));
}

TEST_CASE("compile: levels are exact decimals of the file's unit, equal on every way up and down") {
  struct Row {
    const char* unit;
    double step, top, psi_per_unit;
  };
  for (const Row& row :
       {Row{"kPa", 20.0, 400.0, 1.0 / 6.894757293168361}, Row{"kPa", 0.1, 2.0, 1.0 / 6.894757293168361},
        Row{"kPa", 7.0, 140.0, 1.0 / 6.894757293168361}, Row{"bar", 0.1, 4.0, 100.0 / 6.894757293168361},
        Row{"psi", 1.0, 60.0, 1.0}, Row{"psi", 0.01, 1.0, 1.0}}) {
    CAPTURE(row.unit, row.step);
    const std::string text = "schema = 1\nname = \"r\"\nunit = \"" + std::string(row.unit) +
                             "\"\nstep = " + std::to_string(row.step) + "\nturning_points = [0, " +
                             std::to_string(row.top) + ", 0]\n";
    std::map<long, std::set<double>> found;  // by steps from 0
    for (const Step& step : compile(parse_recipe(TomlDocument::from_text(text, "r.toml")), 0))
      found[std::lround(step.setpoint.value() / row.psi_per_unit / row.step)].insert(step.setpoint.value());
    CHECK(found.size() == static_cast<std::size_t>(std::lround(row.top / row.step)) + 1);
    const double per_unit = std::round(1.0 / row.step);  // steps in a unit, where a step is a part of it
    for (const auto& [steps, levels] : found) {
      const double decimal =
          row.step < 1.0 ? static_cast<double>(steps) / per_unit : static_cast<double>(steps) * row.step;
      CHECK((levels.size() == 1 && *levels.begin() == decimal * row.psi_per_unit));
    }
  }
}

// Lines, spans and extremes of steps.

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

TEST_CASE("way back: to a branch of a press ends where the branch's own steps continue") {
  const Recipe recipe = press_of("positions_mm = [[10, 20], [30, 40]]\nforces_n = [2, 6, 10]\n");
  // Where the way back ends, the branch's own steps continue.
  const auto steps = compile(recipe, 0);
  for (const BranchSpan& span : branches(steps)) {
    if (span.kind != SpanKind::kBranch) continue;
    const Step& first = steps[span.first];
    const Step end = path_to_branch(recipe, 0, 0, first.branch).back();
    CHECK((end.x_mm == first.x_mm && end.y_mm == first.y_mm && end.ordinal == first.ordinal));
  }
}

TEST_CASE("press grid: positions go row by row, every other row backward") {
  const Recipe recipe = press_of("forces_n = [2]\n[press.grid]\nx = [10, 12, 1]\ny = [5, 7, 2]\n");
  const std::vector<std::pair<double, double>> expected = {{10, 5}, {11, 5}, {12, 5}, {12, 7}, {11, 7}, {10, 7}};
  CHECK(recipe.press.positions_mm == expected);
  const Recipe tall = press_of("forces_n = [2]\n[press.grid]\nx = [1, 2, 1]\ny = [1, 5, 1]\n");
  CHECK(tall.press.positions_mm == std::vector<std::pair<double, double>>{
                                       {1, 1}, {2, 1}, {2, 2}, {1, 2}, {1, 3}, {2, 3}, {2, 4}, {1, 4}, {1, 5}, {2, 5}});
}

TEST_CASE("step line: differs for each field of a step") {
  Step base;
  base.kind = StepKind::kPress;
  std::set<std::string> lines = {step_line(base)};
  const auto differs = [&](auto change) {
    Step step = base;
    change(step);
    CHECK(lines.insert(step_line(step)).second);
  };
  differs([](Step& s) { s.kind = StepKind::kApproach; });
  for (int Step::*number : {&Step::sequence, &Step::repeat, &Step::branch, &Step::ordinal})
    differs([&](Step& s) { s.*number = 1; });
  for (double Step::*value : {&Step::force_from_n, &Step::force_to_n, &Step::x_mm, &Step::y_mm, &Step::dwell_s})
    differs([&](Step& s) { s.*value = 1; });
  differs([](Step& s) { s.force_n = 1e-9; });
  for (bool Step::*flag : {&Step::hold, &Step::hold_force, &Step::frame})
    differs([&](Step& s) { s.*flag = !(s.*flag); });
  differs([](Step& s) { s.text.push_back('x'); });
  base.kind = StepKind::kMeasure;
  differs([](Step&) {});
  differs([](Step& s) { s.setpoint = tactbench::devices::Psi(1e-9); });
  differs([](Step& s) { s.branch_from = tactbench::devices::Psi(1); });
  differs([](Step& s) { s.branch_to = tactbench::devices::Psi(1); });
  differs([](Step& s) { s.ramp_psi_per_s = 1; });
  differs([](Step& s) { s.settle = false; });
}

namespace {

Recipe grid_recipe(const std::string& x, const std::string& y, const std::string& more = {}) {
  return press_of("forces_n = [2]\n" + more + "[press.grid]\nx = " + x + "\ny = " + y + "\n");
}

std::vector<double> xs_of(const std::string& x) {
  std::vector<double> xs;
  for (const auto& at : grid_recipe(x, "[3, 3, 1]").press.positions_mm) xs.push_back(at.first);
  return xs;
}

}  // namespace

TEST_CASE("press grid: an axis ends at the last step that does not pass its end") {
  CHECK(xs_of("[10, 12, 0.5]") == std::vector<double>{10, 10.5, 11, 11.5, 12});
  CHECK(xs_of("[10, 12.25, 0.5]") == std::vector<double>{10, 10.5, 11, 11.5, 12});
  CHECK(xs_of("[-4, 4, 4]") == std::vector<double>{-4, 0, 4});
  CHECK(xs_of("[7, 7, 1]") == std::vector<double>{7});
  // 0.3 / 0.1 is 2.9999999999999996: an end reached but for a billionth of a step is reached.
  CHECK(xs_of("[0, 0.3, 0.1]").size() == 4);
  CHECK(xs_of("[0, 0.9999999995, 1]").size() == 2);
  CHECK(xs_of("[0, 0.9999999989, 1]").size() == 1);
}

TEST_CASE("press grid: ten thousand positions are accepted, along one axis or in total") {
  CHECK(grid_recipe("[1, 100, 1]", "[1, 100, 1]").press.positions_mm.size() == 10'000);
  CHECK(grid_recipe("[1, 10000, 1]", "[1, 1, 1]").press.positions_mm.size() == 10'000);
}

TEST_CASE("press positions: need either a list or a grid, not both") {
  const std::string grid = "[press.grid]\nx = [1, 1, 1]\ny = [1, 1, 1]\n", list = "positions_mm = [[1, 1]]\n";
  for (const std::string& at :
       {list + grid, std::string("positions_mm = []\n"), std::string("positions_mm = 1\n"), std::string()})
    CHECK(key_refused([&] { (void)press_of("forces_n = [2]\n" + at); }) == "press.positions_mm");
}
