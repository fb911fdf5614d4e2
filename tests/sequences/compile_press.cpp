// The very steps that a press recipe becomes, all their fields, against lists written out by hand.
#include <catch2/catch.hpp>

#include "sequences/recipe.h"

using namespace tactbench::sequences;

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
  return parse_recipe(TomlDocument::from_text(
      "schema = 1\nname = \"t\"\nkind = \"press\"\n" + root + "[press]\nobject = \"ring\"\nhold = \"force\"\n" + press,
      "press.toml"));
}

}  // namespace

TEST_CASE("a press recipe becomes these steps, field by field") {
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
}

TEST_CASE("the way back to a falling branch of a press, field by field") {
  const Recipe recipe =
      presses("positions_mm = [[10, 20], [30, 40]]\nforces_n = [2, 6]\n[conditioning]\ncycles = 1\npeak_n = 5\n",
              "repeats = 2\ndwell_s = [1, 3]\n");
  // Position 1 begins with frame 3; its falling branch, 3, with frame 5.
  const int repeat = 1, ordinal = 5;
  const std::vector<Step> steps = way_back(recipe, 2, repeat, 3);
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
  const auto rising = way_back(recipe, 2, repeat, 2);
  CHECK((rising.size() == 8 && rising.back().kind == kDown && rising.back().ordinal == 3));
}
