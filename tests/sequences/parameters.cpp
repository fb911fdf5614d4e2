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

void refused(const std::vector<Override>& overrides, const std::string& body, const std::string& message,
             const std::string& where, const std::string& remedy) {
  try {
    (void)recipe_with(overrides, body);
    FAIL("accepted");
  } catch (const FileError& error) {
    CHECK_THAT(error.what(), Catch::Contains(message));
    CHECK_THAT(error.where(), Catch::Contains(where));
    CHECK_THAT(error.remedy(), Catch::Contains(remedy));
  }
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

TEST_CASE("a parameter out of its range or unknown is refused with its place") {
  refused({{"peak", "62"}}, kBody, "'peak' is 62, outside 10 to 60", "--set recipe.peak=62 (over p.toml)", "10 to 60");
  refused({{"peak", "high"}}, kBody, "'peak' must be a number", "--set recipe.peak=high", "number");
  refused({{"step", "-1"}}, kBody, "above 0", "--set recipe.step (over p.toml)", "levels");
  refused({{"times", "1.5"}}, kBody, "not a whole number", "p.toml:7:11", "whole number");
  refused({{"dwel_s", "1"}}, kBody, "unknown key 'dwel_s'", "--set", "dwell_s");
  std::string misspelt = kBody;
  misspelt.replace(misspelt.find("$peak"), 5, "$paek");
  refused({}, misspelt, "no parameter 'paek'", "p.toml:4:", "$peak");
  refused({}, kBody + "[parameters.idle]\ndefault = 1\nlow = 0\nhigh = 2\n", "nothing uses", "p.toml:22:", "$idle");
  refused({}, kBody + "[parameters.idle]\ndefault = 3\nlow = 0\nhigh = 2\n", "outside 0 to 2", "p.toml:23:11", "low");
  refused({}, kBody + "[parameters.idle]\ndefault = 3\nlow = 0\nhihg = 2\n", "'high' is missing", "p.toml:22:", "high");
}

TEST_CASE("a key set over a parameter's place wins") {
  std::string other = kBody;
  other.replace(other.find("[parameters.times]"), 18, "[parameters.count]");
  other.replace(other.find("$times"), 6, "$count");
  CHECK(recipe_with({{"repeats", "4"}}, other).repeats == 4);
}
