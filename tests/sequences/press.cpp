#include <algorithm>
#include <catch2/catch.hpp>
#include <set>

#include "sequences/recipe.h"

using namespace tactbench::sequences;

namespace {

Recipe press_of(const std::string& press, const std::string& root = {}) {
  return parse_recipe(TomlDocument::from_text(
      "schema = 1\nname = \"t\"\nkind = \"press\"\n" + root + "[press]\nobject = \"ring\"\n" + press, "press.toml"));
}

std::vector<StepKind> kinds(const std::vector<Step>& steps) {
  std::vector<StepKind> found;
  for (const Step& step : steps) found.push_back(step.kind);
  return found;
}

constexpr auto kHome = StepKind::kHome, kTare = StepKind::kTare, kMove = StepKind::kMoveXy,
               kApproach = StepKind::kApproach, kPress = StepKind::kPress, kRetract = StepKind::kRetract;

}  // namespace

TEST_CASE("a press recipe goes up and down at each position, the peak once, tared before and after") {
  const auto steps = compile(press_of("positions_mm = [[10, 20], [30, 40]]\nforces_n = [2, 6]\n"), 1);
  CHECK(kinds(steps) == std::vector<StepKind>{kHome, kTare, kMove, kApproach, kPress, kPress, kPress, kRetract, kMove,
                                              kApproach, kPress, kPress, kPress, kRetract, kTare});
  std::vector<double> forces;
  std::vector<int> branch, ordinal;
  for (const Step& step : steps) {
    CHECK(step.sequence == 1);
    if (step.kind != kPress) continue;
    CHECK(takes_frame(step));
    forces.push_back(step.force_n);
    branch.push_back(step.branch);
    ordinal.push_back(step.ordinal);
    CHECK(step.x_mm == (step.branch < 2 ? 10.0 : 30.0));
    CHECK(step.force_from_n == (step.branch % 2 == 0 ? 0.0 : 6.0));
    CHECK(step.force_to_n == (step.branch % 2 == 0 ? 6.0 : 2.0));
  }
  CHECK(forces == std::vector<double>{2, 6, 2, 2, 6, 2});
  CHECK(branch == std::vector<int>{0, 0, 1, 2, 2, 3});
  CHECK(ordinal == std::vector<int>{0, 1, 2, 3, 4, 5});
  const Extremes all = extremes(steps);
  CHECK((all.presses && all.moves && !all.pressurizes));
  CHECK(all.largest_force_n == 6.0);
  CHECK((all.lowest_x_mm == 10.0 && all.highest_x_mm == 30.0 && all.lowest_y_mm == 20.0 && all.highest_y_mm == 40.0));
}

TEST_CASE("presses that condition take no frame and come before the first branch of a position") {
  const Recipe recipe = press_of(
      "positions_mm = [[10, 20]]\nforces_n = [2, 6]\ntare = false\n[conditioning]\ncycles = 2\n", "repeats = 2\n");
  const auto steps = compile(recipe, 0);
  CHECK(kinds(steps) == std::vector<StepKind>{kHome, kMove, kApproach, kPress, kRetract, kApproach, kPress, kRetract,
                                              kApproach, kPress, kPress, kPress, kRetract, kMove, kApproach, kPress,
                                              kPress, kPress, kRetract});
  CHECK(std::count_if(steps.begin(), steps.end(), takes_frame) == 6);
  CHECK((steps[3].force_n == 6.0 && !steps[3].frame && steps[3].branch == -1));
}

TEST_CASE("the way back to a falling branch presses up to the peak without frames") {
  const Recipe recipe = press_of("positions_mm = [[10, 20], [30, 40]]\nforces_n = [2, 6, 10]\n");
  const auto rising = way_back(recipe, 0, 0, 2);
  CHECK(kinds(rising) == std::vector<StepKind>{kRetract, kHome, kTare, kMove, kApproach});
  CHECK(rising.back().x_mm == 30.0);
  CHECK(rising.back().ordinal == 5);
  const auto falling = way_back(recipe, 0, 0, 3);
  CHECK(kinds(falling) == std::vector<StepKind>{kRetract, kHome, kTare, kMove, kApproach, kPress, kPress, kPress});
  CHECK(falling.back().force_n == 10.0);
  CHECK(falling.back().ordinal == 8);
  CHECK(std::none_of(falling.begin(), falling.end(), takes_frame));
  // Where the way back ends, the branch's own steps continue.
  const auto steps = compile(recipe, 0);
  for (const BranchSpan& span : branches(steps)) {
    if (span.kind != SpanKind::kBranch) continue;
    const Step& first = steps[span.first];
    const Step end = way_back(recipe, 0, 0, first.branch).back();
    CHECK((end.x_mm == first.x_mm && end.y_mm == first.y_mm && end.ordinal == first.ordinal));
  }
}

TEST_CASE("a grid is walked row by row, every other one backward") {
  const Recipe recipe = press_of("forces_n = [2]\n[press.grid]\nx = [10, 12, 1]\ny = [5, 7, 2]\n");
  const std::vector<std::pair<double, double>> expected = {{10, 5}, {11, 5}, {12, 5}, {12, 7}, {11, 7}, {10, 7}};
  CHECK(recipe.press.positions_mm == expected);
  const Recipe tall = press_of("forces_n = [2]\n[press.grid]\nx = [1, 2, 1]\ny = [1, 5, 1]\n");
  CHECK(tall.press.positions_mm == std::vector<std::pair<double, double>>{
                                       {1, 1}, {2, 1}, {2, 2}, {1, 2}, {1, 3}, {2, 3}, {2, 4}, {1, 4}, {1, 5}, {2, 5}});
}

TEST_CASE("a bad press recipe names its place") {
  const auto refused = [](const std::string& body, const std::string& message, const std::string& where) {
    try {
      (void)press_of(body);
      FAIL("accepted: " << body);
    } catch (const FileError& error) {
      CHECK_THAT(error.what(), Catch::Contains(message));
      CHECK_THAT(error.where(), Catch::Contains(where));
    }
  };
  const std::string at = "positions_mm = [[10, 20]]\n";
  refused(at + "forces_n = [2, 2]\n", "force 2 is 2 N, not above 2 N", "press.toml:7:12");
  refused(at + "forces_n = [0.1]\n", "not above 0.2 N", "press.toml:7:12");
  refused(at + "forces_n = []\n", "empty", "press.toml:7:12");
  refused("positions_mm = [[10]]\nforces_n = [2]\n", "element 1", "press.toml:6:16");
  refused("positions_mm = [10, 20]\nforces_n = [2]\n", "element 1", "press.toml:6:16");
  refused("forces_n = [2]\n", "either positions_mm or", "press.positions_mm");
  refused(at + "forces_n = [2]\nsteps = 3\n", "unknown key 'steps'", "press.toml:8:9");
  refused("forces_n = [2]\n[press.grid]\nx = [1, 2]\ny = [1, 2, 1]\n", "[from, to, step]", "press.toml:8:5");
  refused("forces_n = [2]\n[press.grid]\nx = [1, 2, 1e-9]\ny = [1, 2, 1]\n", "has 1000000000 positions",
          "press.toml:8:5");
  refused(at + "forces_n = [2]\nhold = \"forces\"\n", "not one of position, force", "press.toml:8:8");
}

TEST_CASE("a step's line differs with each of its fields") {
  Step base;
  base.kind = kPress;
  std::set<std::string> lines = {step_line(base)};
  const auto differs = [&](auto change) {
    Step step = base;
    change(step);
    CHECK(lines.insert(step_line(step)).second);
  };
  differs([](Step& s) { s.kind = kApproach; });
  differs([](Step& s) { s.sequence = 1; });
  differs([](Step& s) { s.repeat = 1; });
  differs([](Step& s) { s.branch = 1; });
  differs([](Step& s) { s.ordinal = 1; });
  differs([](Step& s) { s.dwell_s = 0.1; });
  differs([](Step& s) { s.hold = true; });
  differs([](Step& s) { s.frame = false; });
  differs([](Step& s) { s.force_n = 1e-9; });
  differs([](Step& s) { s.force_from_n = 1; });
  differs([](Step& s) { s.force_to_n = 1; });
  differs([](Step& s) { s.hold_force = true; });
  differs([](Step& s) { s.x_mm = 1; });
  differs([](Step& s) { s.y_mm = 1; });
  differs([](Step& s) { s.text.push_back('x'); });
  base.kind = StepKind::kMeasure;
  differs([](Step&) {});
  differs([](Step& s) { s.setpoint = tactbench::devices::Psi(1e-9); });
  differs([](Step& s) { s.branch_from = tactbench::devices::Psi(1); });
  differs([](Step& s) { s.branch_to = tactbench::devices::Psi(1); });
  differs([](Step& s) { s.ramp_psi_per_s = 1; });
  differs([](Step& s) { s.settle = false; });
}
