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

TEST_CASE("the way back to a branch of a press ends where the branch's own steps continue") {
  const Recipe recipe = press_of("positions_mm = [[10, 20], [30, 40]]\nforces_n = [2, 6, 10]\n");
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
