#include <catch2/catch.hpp>
#include <set>

#include "sequences/recipe.h"
#include "tests/sequences/recipe_text.h"
#include "tests/sequences/refusal.h"

using namespace tactbench::sequences;

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
