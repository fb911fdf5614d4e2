// Suspensions, repeats and parameters of a recipe: their edges.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "sequences/recipe.h"
#include "sequences/toml/pressure_text.h"
#include "tests/sequences/recipe_text.h"
#include "tests/sequences/refusal.h"
#include "tests/support/process.h"

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

TEST_CASE("suspension: ends at its trip value or past it, on the side it came from") {
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

TEST_CASE("recipe repeats: default to the length of the longer list of values") {
  const auto repeats = [](const std::string& rest) { return recipe_of(kTwoLevels + rest).repeats; };
  CHECK(repeats("dwell_s = [1, 2, 3]\nramp_psi_per_s = 1\n") == 3);
  CHECK(repeats("dwell_s = 1\nramp_psi_per_s = [1, 2]\n") == 2);
  CHECK(repeats("dwell_s = [1, 2]\nrepeats = 2\n") == 2);
  CHECK(repeats("dwell_s = [1, 2]\nrepeats = 5\n") == 5);
  CHECK_THROWS_AS(repeats("ramp_psi_per_s = [1, 2]\nrepeats = 1\n"), FileError);
  CHECK(recipe_of(kTwoLevels).title == "t");
  CHECK(recipe_of("title = \"T\"\n" + kTwoLevels).title == "T");
}

TEST_CASE("recipe text: is kept as it was read, whatever is set over it") {
  const std::string body = "schema = 1\nname = \"t\"\nunit = \"psi\"\n# why\n" + kTwoLevels;
  const Recipe recipe = parse_recipe(TomlDocument::from_text(body, "t.toml"), {{"repeats", "7"}});
  CHECK(recipe.text == body);
  CHECK(recipe.repeats == 7);
}

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

TEST_CASE("recipe parameter: provides a number, by default or as set") {
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

TEST_CASE("recipe: a key that is set replaces a parameter in its place") {
  std::string other = kBody;
  other.replace(other.find("[parameters.times]"), 18, "[parameters.count]");
  other.replace(other.find("$times"), 6, "$count");
  CHECK(recipe_with({{"repeats", "4"}}, other).repeats == 4);
}

namespace {

constexpr const char* kRecipe =
    "schema = 1\nname = \"r\"\nunit = \"kPa\"\nturning_points = [0, 400, 0]\nstep = \"$step\"\n"
    "[conditioning]\ncycles = 1\npeak = 300\n"
    "[parameters.step]\ndefault = 100\nlow = 10\nhigh = 400\nunit = \"kPa\"\n";

Recipe with(const std::vector<Override>& overrides) {
  return parse_recipe(TomlDocument::from_text(kRecipe, "r.toml"), overrides);
}

}  // namespace

TEST_CASE("typed pressure: needs a number and a unit, in any case") {
  CHECK(*typed_pressure_psi("3 psi") == 3.0);
  CHECK(*typed_pressure_psi("413.6854375901kPa") == Approx(60.0));
  CHECK(*typed_pressure_psi(" 2BAR ") == Approx(29.0075475));
  CHECK(*typed_pressure_psi("-0.5 psi") == -0.5);
  for (const char* other : {"", "3", "kPa", "3 mbar", "3 psi 4", "nan psi", "0x3 psi", "3psi/s"})
    CHECK_FALSE(typed_pressure_psi(other).has_value());
  // Blanks before, between and behind, as many as there are.
  for (const char* blanks : {"3 psi ", " 3 psi", " 3psi ", "  3  psi  ", "\t 3 \t psi \t"})
    CHECK(typed_pressure_psi(blanks) == 3.0);
  for (const char* none : {" ", " \t ", "\n3 psi", "3\npsi"}) CHECK_FALSE(typed_pressure_psi(none).has_value());
  const std::string_view digit = std::string_view("25 psi").substr(0, 1);  // what lies behind it is no part of it
  CHECK_FALSE(typed_pressure_psi(digit).has_value());
  CHECK(as_number_in("kPa", "2 bar") == "200");
  CHECK(as_number_in("psi", "12.5") == "12.5");    // a bare number keeps the unit of its key
  CHECK(as_number_in("s", "20 kPa") == "20 kPa");  // a time is no pressure: the key's own error follows
}

TEST_CASE("recipe: parameters and pressure keys accept other units, a bare number has the recipe's unit") {
  CHECK(with({{"step", "0.5bar"}}).step.value() == Approx(50.0 / 6.894757293168));
  CHECK(with({{"step", "50"}}).step.value() == Approx(50.0 / 6.894757293168));
  CHECK(with({{"conditioning.peak", "30 psi"}}).conditioning.peak.value() == Approx(30.0));
  CHECK(with({{"step", "50"}, {"unit", "psi"}, {"turning_points", "[0, 50, 0]"}, {"conditioning.peak", "200kPa"}})
            .conditioning.peak.value() == Approx(200.0 / 6.894757293168));
  // The typed unit applies to all values, wherever it is.
  const Recipe psi = with({{"turning_points", "[0, 50, 0]"}, {"step", "25"}, {"unit", "psi"}});
  CHECK((psi.turning_points[1].value() == 50.0 && psi.step.value() == 25.0));
  CHECK(psi.conditioning.peak.value() == 300.0);
  CHECK_THROWS_WITH(with({{"step", "5kPa"}}), Catch::Contains("5kPa") && Catch::Contains("10 to 400"));
  CHECK_THROWS_AS(with({{"step", "20psi"}, {"step", "5"}}), FileError);
  CHECK_THROWS_AS(with({{"step", "5"}}), FileError);
  CHECK_THROWS_AS(with({{"dwell_s", "2kPa"}}), FileError);
}

TEST_CASE("recipe list: gives its recipes in order, each with the values that are set") {
  const tactbench::tests::TemporaryFolder folder;
  const auto find = [&](const std::string& name) { return folder.path(name); };
  const auto write = [&](const std::string& name, const std::string& rest) {
    tactbench::tests::write_file(folder.path(name), "schema = 1\nname = \"" + name + "\"\n" + rest);
  };
  const auto read = [&](const std::string& name) {
    return read_recipe_file(folder.path(name), {{"repeats", "4"}}, find);
  };
  write("a", "unit = \"psi\"\n" + kTwoLevels);
  write("b", "unit = \"kPa\"\n" + kTwoLevels);
  write("both", "title = \"B, A\"\nrecipes = [\"b\", \"a\"]\n");
  const RecipeFile both = read("both");
  CHECK((both.name == "both" && both.title == "B, A"));
  REQUIRE(both.recipes.size() == 2);
  CHECK((both.recipes[0].name == "b" && both.recipes[1].name == "a"));
  for (const Recipe& recipe : both.recipes) CHECK(recipe.repeats == 4);
  CHECK(read("a").recipes.size() == 1);
  write("none", "recipes = []\n");
  write("nested", "recipes = [\"both\"]\n");
  write("more", "recipes = [\"a\"]\nstep = 2\n");
  for (const char* name : {"none", "nested", "more"}) CHECK_THROWS_AS(read(name), FileError);
}

TEST_CASE("recipe list: entries set the recipe's parameters, and the stored text includes them") {
  const tactbench::tests::TemporaryFolder folder;
  const auto find = [&](const std::string& name) { return folder.path(name); };
  const auto write = [&](const std::string& name, const std::string& rest) {
    tactbench::tests::write_file(folder.path(name), "schema = 1\nname = \"" + name + "\"\n" + rest);
  };
  write("a",
        "unit = \"psi\"\nturning_points = [0, 4, 0]\nstep = \"$step\"\nrepeats = \"$repeats\"\n"
        "[parameters.step]\ndefault = 2\nlow = 1\nhigh = 4\n[parameters.repeats]\ndefault = 1\nlow = 1\nhigh = 9\n");
  write("set", "recipes = [\"a\", \"a step=4 repeats=3\", \"a repeats=2\"]\n");
  const RecipeFile set = read_recipe_file(folder.path("set"), {}, find);
  REQUIRE(set.recipes.size() == 3);
  const double steps[] = {2, 4, 2};
  const int repeats[] = {1, 3, 2};
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK((set.recipes[i].step.value() == steps[i] && set.recipes[i].repeats == repeats[i]));
    // The stored text is enough to continue a run.
    const Recipe again = parse_recipe(TomlDocument::from_text(set.recipes[i].text, "stored"));
    CHECK((again.step.value() == steps[i] && again.repeats == repeats[i]));
  }
  CHECK(read_recipe_file(folder.path("set"), {{"repeats", "7"}}, find).recipes[1].repeats == 7);
  for (const char* entry : {"a step", "a size=2", "a step=9", "a step=x"}) {
    write("wrong", std::string("recipes = [\"") + entry + "\"]\n");
    INFO(entry);
    CHECK_THROWS_AS(read_recipe_file(folder.path("wrong"), {}, find), FileError);
  }
}
