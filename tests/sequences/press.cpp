#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <set>

#include "sequences/recipe.h"
#include "tests/sequences/refusal.h"

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

namespace {

Recipe grid_recipe(const std::string& x, const std::string& y, const std::string& more = {}) {
  return parse_recipe(
      TomlDocument::from_text("schema = 1\nname = \"t\"\nkind = \"press\"\n[press]\nobject = \"ring\"\n"
                              "forces_n = [2]\n" +
                                  more + "[press.grid]\nx = " + x + "\ny = " + y + "\n",
                              "g.toml"));
}

std::vector<double> xs_of(const std::string& x) {
  std::vector<double> xs;
  for (const auto& at : grid_recipe(x, "[3, 3, 1]").press.positions_mm) xs.push_back(at.first);
  return xs;
}

std::string place_refused(const std::string& x, const std::string& y, const std::string& fact = {},
                          const std::string& more = {}) {
  return key_refused([&] { (void)grid_recipe(x, y, more); }, fact);
}

}  // namespace

TEST_CASE("an axis of a grid ends at the last step that does not pass its end") {
  CHECK(xs_of("[10, 12, 0.5]") == std::vector<double>{10, 10.5, 11, 11.5, 12});
  CHECK(xs_of("[10, 12.25, 0.5]") == std::vector<double>{10, 10.5, 11, 11.5, 12});
  CHECK(xs_of("[-4, 4, 4]") == std::vector<double>{-4, 0, 4});
  CHECK(xs_of("[7, 7, 1]") == std::vector<double>{7});
  // 0.3 / 0.1 is 2.9999999999999996: an end reached but for a billionth of a step is reached.
  CHECK(xs_of("[0, 0.3, 0.1]").size() == 4);
  CHECK(xs_of("[0, 0.9999999995, 1]").size() == 2);
  CHECK(xs_of("[0, 0.9999999989, 1]").size() == 1);
}

TEST_CASE("an axis of a grid goes up by a step above 0") {
  CHECK(place_refused("[10, 12, 0]", "[1, 1, 1]") == "press.grid.x");
  CHECK(place_refused("[10, 12, -1]", "[1, 1, 1]") == "press.grid.x");
  CHECK(place_refused("[10, 9, 1]", "[1, 1, 1]") == "press.grid.x");
  CHECK(place_refused("[10, 12]", "[1, 1, 1]") == "press.grid.x");
  CHECK(place_refused("[1, 1, 1]", "[10, 12, 1, 1]") == "press.grid.y");
  CHECK(place_refused("[1, 1, 0.5]", "[1, 1, 1]") == "accepted");
}

TEST_CASE("a grid has ten thousand positions at most, along an axis and in all") {
  CHECK(grid_recipe("[1, 100, 1]", "[1, 100, 1]").press.positions_mm.size() == 10'000);
  CHECK(place_refused("[1, 101, 1]", "[1, 100, 1]", "101 x 100") == "press.grid");
  CHECK(grid_recipe("[1, 10000, 1]", "[1, 1, 1]").press.positions_mm.size() == 10'000);
  CHECK(place_refused("[1, 10001, 1]", "[1, 1, 1]", " 10001 ") == "press.grid.x");
}

TEST_CASE("positions are given either as a list or as a grid") {
  CHECK(place_refused("[1, 1, 1]", "[1, 1, 1]", "", "positions_mm = [[1, 1]]\n") == "press.positions_mm");
  for (const char* at : {"positions_mm = []\n", "positions_mm = 1\n", ""}) {
    INFO(at);
    CHECK_THROWS_AS(parse_recipe(TomlDocument::from_text(
                        "schema = 1\nname = \"t\"\nkind = \"press\"\n[press]\nobject = \"ring\"\nforces_n = [2]\n" +
                            std::string(at),
                        "g.toml")),
                    FileError);
  }
}

TEST_CASE("forces of a recipe rise and begin above the contact force") {
  const auto refused = [](const std::string& forces, const std::string& fact) {
    return key_refused(
        [&] {
          (void)parse_recipe(
              TomlDocument::from_text("schema = 1\nname = \"t\"\nkind = \"press\"\n[press]\nobject = \"ring\"\n"
                                      "contact_n = 0.5\npositions_mm = [[1, 1]]\nforces_n = " +
                                          forces + "\n",
                                      "f.toml"));
        },
        fact);
  };
  const std::string key = "press.forces_n";
  CHECK(refused("[0.5, 1]", "force 1 ") == key);
  CHECK(refused("[1, 3, 2]", "force 3 ") == key);
  CHECK(refused("[1, 1.5, 1.5]", "1.5 N") == key);
  CHECK(refused("[0.5000001, 0.75]", "") == "accepted");
}
