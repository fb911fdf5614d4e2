// Grids of positions and rising forces of a press recipe: their edges.
#include <fmt/format.h>

#include <catch2/catch.hpp>

#include "sequences/recipe.h"
#include "tests/sequences/refusal.h"

using namespace tactbench::sequences;

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
