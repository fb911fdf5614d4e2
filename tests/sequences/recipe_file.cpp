// Suspensions, repeats and parameters of a recipe: their edges.
#include <catch2/catch.hpp>

#include "tests/sequences/recipe_text.h"

using namespace tactbench::sequences;

namespace {

const std::string kTwoLevels = "turning_points = [0, 2]\nstep = 2\n";

bool suspends(const std::string& rule, const std::string& place = {}) {
  try {
    (void)recipe_of(kTwoLevels + "[[suspend]]\nquantity = \"supply_bar\"\n" + rule);
    return true;
  } catch (const FileError& error) {
    CHECK_THAT(error.where(), Catch::EndsWith(place));
    return false;
  }
}

struct Complaint {
  std::string id, message, where;
};

Complaint complaint_of(const std::string& parameter, const std::vector<Override>& overrides = {}) {
  try {
    (void)parse_recipe(TomlDocument::from_text("schema = 1\nname = \"t\"\nunit = \"psi\"\nturning_points = "
                                               "[0, \"$peak\"]\nstep = 1\n[parameters.peak]\n" +
                                                   parameter,
                                               "p.toml"),
                       overrides);
  } catch (const FileError& error) {
    return {error.id(), error.what(), error.where()};
  }
  return {};
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

TEST_CASE("a parameter's default may lie at either bound, and no further") {
  CHECK(complaint_of("default = 2\nlow = 2\nhigh = 4\n").id.empty());
  CHECK(complaint_of("default = 4\nlow = 2\nhigh = 4\n").id.empty());
  CHECK(complaint_of("default = 1\nlow = 2\nhigh = 4\n").where == "p.toml:7:11, parameters.peak.default");
  CHECK(complaint_of("default = 5\nlow = 2\nhigh = 4\n").where == "p.toml:7:11, parameters.peak.default");
}

TEST_CASE("an error about a parameter's value names its place: the file, or the last option typed") {
  const std::string range = "default = 2\nlow = 2\nhigh = 4\n";
  const Complaint of_file = complaint_of(range + "value = 9\n");
  CHECK(of_file.where == "p.toml:10:9, parameters.peak.value");
  CHECK_THAT(of_file.message, Catch::StartsWith("'value' is 9, outside 2 to 4"));
  CHECK(complaint_of(range + "value = 9\n", {{"peak", "3"}}).id.empty());
  CHECK(complaint_of(range, {{"peak", "9"}, {"peak", "3"}}).id.empty());
  const Complaint typed = complaint_of(range, {{"peak", "3"}, {"peak", "9"}, {"name", "u"}});
  CHECK(typed.where == "--set recipe.peak=9 (over p.toml)");
  CHECK(typed.id == "TB-FILE-VALUE");
  CHECK_THAT(typed.message, Catch::StartsWith("'peak' is 9, outside 2 to 4"));
}

TEST_CASE("the text of a recipe is kept as it was read, whatever was set") {
  const std::string body = "schema = 1\nname = \"t\"\nunit = \"psi\"\n# why\n" + kTwoLevels;
  const Recipe recipe = parse_recipe(TomlDocument::from_text(body, "t.toml"), {{"repeats", "7"}});
  CHECK(recipe.text == body);
  CHECK(recipe.repeats == 7);
}
