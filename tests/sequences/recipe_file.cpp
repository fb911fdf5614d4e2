// Suspensions, repeats and parameters of a recipe: their edges.
#include <catch2/catch.hpp>

#include "tests/sequences/recipe_text.h"
#include "tests/sequences/refusal.h"

using namespace tactbench::sequences;

namespace {

const std::string kTwoLevels = "turning_points = [0, 2]\nstep = 2\n";

bool suspends(const std::string& rule, const std::string& place = {}) {
  const std::string key =
      key_refused([&] { (void)recipe_of(kTwoLevels + "[[suspend]]\nquantity = \"supply_bar\"\n" + rule); });
  if (key == "accepted") return true;
  CHECK_THAT(key, Catch::EndsWith(place));
  return false;
}

}  // namespace

TEST_CASE("a suspension ends at its trip or past it, on the side it came from") {
  CHECK(suspends("trip_below = 6\nresume_above = 6\n"));
  CHECK(suspends("trip_below = 6\nresume_above = 6.5\n"));
  CHECK(!suspends("trip_below = 6\nresume_above = 5.999\n", "resume_above"));
  CHECK(suspends("trip_above = 30\nresume_below = 30\n"));
  CHECK(suspends("trip_above = 30\nresume_below = 29\n"));
  CHECK(!suspends("trip_above = 30\nresume_below = 30.001\n", "resume_below"));
  CHECK(!suspends("", "suspend[0].quantity"));
  CHECK(!suspends("trip_below = 6\ntrip_above = 30\nresume_above = 7\n", "suspend[0].quantity"));
  CHECK(!suspends("trip_below = 6\nresume_below = 7\n", "suspend[0].resume_above"));
}

TEST_CASE("suspensions keep their order and their own numbers") {
  const auto rules =
      recipe_of(kTwoLevels +
                "[[suspend]]\nquantity = \"temperature_c\"\ntrip_above = 30\nresume_below = 28\nhold_s = 7\n"
                "[[suspend]]\nquantity = \"supply_bar\"\ntrip_below = 6\nresume_above = 6.5\n")
          .suspend;
  REQUIRE(rules.size() == 2);
  CHECK((rules[0].quantity == "temperature_c" && rules[0].trip == 30.0 && rules[0].resume == 28.0));
  CHECK((rules[0].hold_s == 7.0 && rules[0].timeout_s == 3600.0 && !rules[0].below));
  CHECK((rules[1].quantity == "supply_bar" && rules[1].below && rules[1].hold_s == 10.0));
}

TEST_CASE("by default a recipe has as many repeats as its longer list has values") {
  const auto repeats = [](const std::string& rest) { return recipe_of(kTwoLevels + rest).repeats; };
  CHECK(repeats("dwell_s = [1, 2, 3]\nramp_psi_per_s = 1\n") == 3);
  CHECK(repeats("dwell_s = 1\nramp_psi_per_s = [1, 2]\n") == 2);
  CHECK(repeats("dwell_s = [1, 2]\nrepeats = 2\n") == 2);
  CHECK(repeats("dwell_s = [1, 2]\nrepeats = 5\n") == 5);
  CHECK_THROWS_AS(repeats("ramp_psi_per_s = [1, 2]\nrepeats = 1\n"), FileError);
  CHECK(recipe_of(kTwoLevels).title == "t");
  CHECK(recipe_of("title = \"T\"\n" + kTwoLevels).title == "T");
}

TEST_CASE("the text of a recipe is kept as it was read, whatever was set") {
  const std::string body = "schema = 1\nname = \"t\"\nunit = \"psi\"\n# why\n" + kTwoLevels;
  const Recipe recipe = parse_recipe(TomlDocument::from_text(body, "t.toml"), {{"repeats", "7"}});
  CHECK(recipe.text == body);
  CHECK(recipe.repeats == 7);
}
