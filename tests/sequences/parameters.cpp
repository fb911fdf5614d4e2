#include <catch2/catch.hpp>

#include "sequences/recipe.h"

using namespace tactbench::sequences;

namespace {

const std::string kBody =
    "schema = 1\nname = \"t\"\nunit = \"psi\"\nturning_points = [0, \"$peak\", 0]\nstep = 2\ndwell_s = \"$dwell_s\"\n"
    "repeats = \"$times\"\n"
    "[parameters.peak]\ndefault = 60\nlow = 10\nhigh = 60\nunit = \"psi\"\nhelp = \"of the loop\"\n"
    "[parameters.dwell_s]\ndefault = 2.0\nlow = 0.5\nhigh = 10\n"
    "[parameters.times]\ndefault = 3\nlow = 1\nhigh = 5\n";

Recipe recipe_with(const std::vector<Override>& overrides, const std::string& body = kBody) {
  return parse_recipe(TomlDocument::from_text(body, "p.toml"), overrides);
}

}  // namespace

TEST_CASE("a parameter stands for a number, by default and as set") {
  const Recipe standard = recipe_with({});
  CHECK(standard.turning_points[1].value() == 60.0);
  CHECK(standard.dwell_s == std::vector<double>{2.0});
  CHECK(standard.ramp_psi_per_s == std::vector<double>{0.0});  // the bench's own
  CHECK(standard.repeats == 3);
  const Recipe set = recipe_with({{"peak", "20"}, {"dwell_s", "0.5"}, {"times", "1"}});
  CHECK(set.turning_points[1].value() == 20.0);
  CHECK(set.dwell_s == std::vector<double>{0.5});
  CHECK(set.repeats == 1);
  REQUIRE(set.parameters.size() == 3);
  for (const Parameter& parameter : set.parameters) {
    if (parameter.name != "peak") continue;
    CHECK((parameter.value == 20.0 && parameter.standard == 60.0 && parameter.low == 10.0 && parameter.high == 60.0));
    CHECK((parameter.unit == "psi" && parameter.help == "of the loop"));
  }
}

TEST_CASE("a key set over a parameter's place wins") {
  std::string other = kBody;
  other.replace(other.find("[parameters.times]"), 18, "[parameters.count]");
  other.replace(other.find("$times"), 6, "$count");
  CHECK(recipe_with({{"repeats", "4"}}, other).repeats == 4);
}
