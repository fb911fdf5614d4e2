// Suspensions, repeats and parameters of a recipe: their edges.

#include <fmt/format.h>
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "sequences/estimate.h"
#include "sequences/recipe.h"
#include "sequences/toml/pressure_text.h"
#include "tests/sequences/refusal.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"

using namespace tactbench::sequences;
using tactbench::devices::Psi;

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

// Turning points on their grid, drawn ones against an independent generator, and conditioning.

namespace {

std::vector<double> points_of(const std::string& body) {
  std::vector<double> points;
  for (const auto& point : recipe_of(body).turning_points) points.push_back(point.value());
  return points;
}

std::string drawn(const std::string& step, int seed, int reversals, const std::string& low, const std::string& high) {
  return fmt::format("step = {}\n[random]\nseed = {}\nreversals = {}\nlow = {}\nhigh = {}\n", step, seed, reversals,
                     low, high);
}

std::string level_refused(const std::string& body, const std::string& fact = {}) {
  return tactbench::sequences::key_refused([&] { (void)recipe_of(body); }, fact);
}

}  // namespace

TEST_CASE("random reversals: follow the 64-bit Mersenne Twister, modulo the remaining range") {
  // From a second implementation of the generator (its 10000th number of seed 5489 is 9981545532273789042, as the
  // standard asks): after 0, high, 0 alternately low' + 1 + g % (high - low') and low + g % (last - low), where low' is
  // the larger of the last point and low.
  CHECK(points_of(drawn("2", 1, 5, "0", "60")) == std::vector<double>{0, 60, 0, 18, 12, 50, 42, 44, 0});
  CHECK(points_of(drawn("1", 1, 9, "3", "9")) == std::vector<double>{0, 9, 0, 6, 3, 4, 3, 4, 3, 6, 3, 6, 0});
  CHECK(points_of(drawn("0.5", 7, 9, "1.5", "3")) ==
        std::vector<double>{0, 3, 0, 2, 1.5, 2, 1.5, 2.5, 1.5, 2, 1.5, 2, 0});
  CHECK(points_of(drawn("1", 0, 1, "0", "2")).size() == 5);
}

TEST_CASE("random reversals: values off the grid or beyond their bounds are refused") {
  CHECK(level_refused(drawn("1", 1, 3, "0.5", "9")) == "random.low");
  CHECK(level_refused(drawn("1", 1, 3, "0", "9.5")) == "random.high");
  CHECK(level_refused(drawn("1", 1, 3, "-1", "9")) == "random.high");
  CHECK(level_refused(drawn("1", 1, 3, "4", "5")) == "random.high");
  CHECK(level_refused(drawn("1", 1, 3, "4", "6")) == "accepted");
  CHECK(level_refused(drawn("1", 1, 2, "0", "9")) == "random.reversals");
  CHECK(level_refused(drawn("1", 1, 0, "0", "9"), "from 1 to 10000") == "random.reversals");
  CHECK(level_refused(drawn("1", 1, 10'001, "0", "9"), "from 1 to 10000") == "random.reversals");
  CHECK(level_refused(drawn("1", 1, 9'999, "0", "9")) == "accepted");
  CHECK(level_refused(drawn("1", -1, 1, "0", "9")) == "random.seed");
  CHECK(level_refused(drawn("1", 2'000'000'000, 1, "0", "9")) == "accepted");
  CHECK(level_refused(drawn("1", 2'000'000'001, 1, "0", "9")) == "random.seed");
  // A million steps from 0 to high are too many only as a whole sequence.
  CHECK(level_refused(drawn("1", 1, 1, "0", "1000000")) == "step");
  CHECK(level_refused(drawn("1", 1, 1, "0", "1000001")) == "random.high");
}

TEST_CASE("level grid: a point within a millionth of a step is on the grid") {
  CHECK(level_refused(drawn("1", 1, 1, "1e-6", "9")) == "accepted");
  CHECK(level_refused(drawn("1", 1, 1, fmt::format("{}", std::nextafter(1e-6, 1.0)), "9")) == "random.low");
  CHECK(points_of("turning_points = [0, 4.0000018]\nstep = 2\n").back() == 4.0000018);
  CHECK(level_refused("turning_points = [0, 4.0000022]\nstep = 2\n", "0 to 4") == "turning_points");
}

TEST_CASE("turning points: an error names the point's number, and a single point needs several frames") {
  const std::string frames = "frames_per_level = 2\n";
  CHECK(level_refused("turning_points = []\nstep = 2\n") == "turning_points");
  CHECK(level_refused("turning_points = []\nstep = 2\n" + frames) == "turning_points");
  CHECK(level_refused("turning_points = [4]\nstep = 2\n") == "turning_points");
  CHECK(level_refused("turning_points = [4]\nstep = 2\n" + frames) == "accepted");
  CHECK(level_refused("turning_points = [4, 6]\nstep = 2\n") == "accepted");
  CHECK(level_refused("turning_points = [4, 4]\nstep = 0.25\n") == "turning_points");
  CHECK(level_refused("turning_points = [0, 0.25]\nstep = 0.25\n") == "accepted");
  CHECK(level_refused("turning_points = [4, 2, -2]\nstep = 2\n", " 3 ") == "turning_points");
  CHECK(level_refused("turning_points = [-2]\nstep = 2\n" + frames, " 1 ") == "turning_points");
  CHECK(level_refused("turning_points = [4, 2, 5]\nstep = 2\n", "2 to 5 ") == "turning_points");
}

TEST_CASE("passing levels: accept no dwell, and one frame per level") {
  const std::string passing = "turning_points = [0, 2]\nstep = 2\nsettle = \"none\"\nramp_psi_per_s = 1\n";
  CHECK(level_refused(passing + "dwell_s = 0\nframes_per_level = 1\n") == "accepted");
  CHECK(level_refused(passing + "dwell_s = 1e-9\n", "0 to 0") == "dwell_s");
  CHECK(level_refused(passing + "dwell_s = -1\n", "0 to 0") == "dwell_s");
  CHECK(level_refused(passing + "frames_per_level = 2\n") == "frames_per_level");
  CHECK(level_refused("turning_points = [0, 2]\nstep = 2\ndwell_s = [1, 86401]\n", "0 to 86400") == "dwell_s");
  CHECK(level_refused("turning_points = [0, 2]\nstep = 2\nramp_psi_per_s = [1, 0]\nsettle = \"none\"\n") ==
        "ramp_psi_per_s");
  CHECK(level_refused("turning_points = [0, 2]\nstep = 2\nsettle = \"nome\"\n") == "settle");
}

TEST_CASE("conditioning: a cycle needs a peak, and the least number of cycles is no more than all") {
  const std::string head = "turning_points = [0, 2]\nstep = 2\n[conditioning]\n";
  CHECK(level_refused(head + "cycles = 1\npeak = 0\n") == "conditioning.peak");
  CHECK(level_refused(head + "cycles = 1\npeak = -1\n") == "conditioning.peak");
  CHECK(level_refused(head + "cycles = 1\npeak = 0.001\n") == "accepted");
  CHECK(level_refused(head + "cycles = 0\npeak = 0\n") == "accepted");
  CHECK(level_refused(head + "cycles = 0\npeak = -1\n") == "conditioning.peak");
  CHECK(level_refused(head + "cycles = 2\nleast = 3\npeak = 1\n") == "conditioning.least");
  const auto least = [&](const std::string& rest) { return recipe_of(head + rest).conditioning.least; };
  CHECK(least("cycles = 2\nleast = 2\npeak = 1\n") == 2);
  CHECK(least("cycles = 2\npeak = 1\n") == 1);
  CHECK(least("cycles = 0\nleast = 3\npeak = 1\n") == 0);  // as with --set recipe.conditioning.cycles=0
  CHECK(least("cycles = 1\nleast = 0\npeak = 1\n") == 0);
}

TEST_CASE("recipe units: 1 bar is 100 kPa, and 1 psi is 6.894757 kPa") {
  const auto second = [](const std::string& unit, const std::string& conditioning) {
    return parse_recipe(TomlDocument::from_text(
        "schema = 1\nname = \"t\"\nunit = \"" + unit + "\"\nturning_points = [0, 50]\nstep = 10\n" + conditioning,
        "u.toml"));
  };
  const std::string cycles = "[conditioning]\ncycles = 1\npeak = 20\n";
  CHECK(second("psi", cycles).turning_points[1].value() == 50.0);
  CHECK(second("psi", cycles).conditioning.peak.value() == 20.0);
  CHECK(second("kPa", cycles).turning_points[1].value() == Approx(50.0 / 6.894757293168).epsilon(1e-12));
  CHECK(second("kPa", cycles).step.value() == Approx(10.0 / 6.894757293168).epsilon(1e-12));
  CHECK(second("bar", cycles).conditioning.peak.value() == Approx(2000.0 / 6.894757293168).epsilon(1e-12));
}

namespace {

const std::string kRecipes = tactbench::tests::source_path("sequences/");

int measuring(const std::vector<Step>& steps, int repeat) {
  int count = 0;
  for (const Step& step : steps) count += step.kind == StepKind::kMeasure && step.repeat == repeat ? 1 : 0;
  return count;
}

}  // namespace

TEST_CASE("paper sequences: have 211 and 451 frames per repeat, and 3310 in total") {
  const Recipe descending = read_recipe(kRecipes + "descending.toml");
  const Recipe ascending = read_recipe(kRecipes + "ascending.toml");
  for (int repeat = 0; repeat < 5; ++repeat) {
    CHECK(measuring(compile(descending, 0), repeat) == 211);
    CHECK(measuring(compile(ascending, 0), repeat) == 451);
  }
  const std::vector<Recipe> both = {descending, ascending};
  const Estimate all = estimate(both, compile(both), TimeModel(), 1024.0);
  CHECK(all.frames == 3310);
  CHECK(all.time.low_s > 3310 * 2.0);
  CHECK(all.time.low_s < all.time.likely_s);
  CHECK(all.time.likely_s < all.time.high_s);
  CHECK(extremes(compile(both)).highest == Psi(60.0));
  CHECK(extremes(compile(both)).lowest == Psi(0.0));
}

TEST_CASE("compile: a ramp without stops states its rate and settles only at its start") {
  const auto steps =
      compile(recipe_of("turning_points = [0, 4, 0]\nstep = 2\nsettle = \"none\"\nramp_psi_per_s = [0.5, 8]\n"), 0);
  REQUIRE(steps.size() == 10);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    CHECK(steps[i].settle == (i % 5 == 0));
    CHECK(steps[i].dwell_s == 0.0);
    CHECK(steps[i].ramp_psi_per_s == (i < 5 ? 0.5 : 8.0));
  }
  CHECK(extremes(steps).fastest_ramp_psi_per_s == 8.0);
}

TEST_CASE("way back: conditions and moves to the start of the branch, without a frame") {
  const Recipe recipe =
      recipe_of("turning_points = [0, 60, 10, 60, 0]\nstep = 10\ndwell_s = 1\n[conditioning]\ncycles = 2\npeak = 50\n");
  const auto levels = [](const std::vector<Step>& steps) {
    std::vector<double> found;
    for (const Step& step : steps) {
      CHECK(step.kind == StepKind::kConditioning);
      CHECK(!has_frame(step));
      found.push_back(step.setpoint.value());
    }
    return found;
  };
  CHECK(levels(path_to_branch(recipe, 0, 0, 0)) == std::vector<double>{50, 0, 50, 0});
  CHECK(levels(path_to_branch(recipe, 0, 3, 2)) == std::vector<double>{50, 0, 50, 0, 0, 60, 10});
  const Recipe bare = recipe_of("turning_points = [0, 60, 10, 60, 0]\nstep = 10\n");
  CHECK(levels(path_to_branch(bare, 0, 0, 1)) == std::vector<double>{60, 0, 0, 60});
  // Only cycles may be skipped by a criterion: they have branch -1.
  const auto steps = path_to_branch(recipe, 4, 3, 2);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    CHECK((steps[i].branch < 0) == (i < 4));
    CHECK(steps[i].sequence == 4);
  }
  // The turning points after them belong to the branches that they end.
  REQUIRE(steps.size() == 7);
  const std::vector<double> from = {0, 0, 60}, to = {0, 60, 10};
  const std::vector<int> branch = {0, 0, 1};
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(steps[4 + i].branch == branch[i]);
    CHECK(steps[4 + i].branch_from == Psi(from[i]));
    CHECK(steps[4 + i].branch_to == Psi(to[i]));
  }
}

TEST_CASE("drawn presses: one peak lies in each of equal parts of the range, in random order") {
  std::string orders;
  for (int seed = 1; seed <= 20; ++seed) {
    const std::vector<Psi> points =
        recipe_of(
            fmt::format("step = 2\n[random]\nkind = \"press\"\nseed = {}\nreversals = 3\nlow = 2\nhigh = 60\n", seed))
            .turning_points;
    std::vector<double> heights;
    for (const std::size_t at : {1U, 3U, 5U}) heights.push_back(points[at].value());
    orders += heights[0] < heights[1] ? "<" : ">";
    std::ranges::sort(heights);
    CHECK((heights[0] >= 2 && heights[0] <= 20 && heights[1] > 20 && heights[1] <= 40 && heights[2] > 40));
  }
  CHECK((orders.find('<') != std::string::npos && orders.find('>') != std::string::npos));
}

TEST_CASE("frames at holds: all frames of turning points above the lowest level, one at the lowest, none between") {
  const Recipe recipe = recipe_of(
      "turning_points = [0, 30, 0, 10, 4, 0]\nstep = 2\nframes_per_level = 3\nframe_interval_s = 2\nframes_at = "
      "\"holds\"\n");
  const auto steps = compile(recipe, 0);
  std::vector<double> levels;
  for (const Step& step : steps) levels.push_back(step.setpoint.value());
  CHECK(levels == std::vector<double>{0, 30, 30, 30, 0, 10, 10, 10, 4, 4, 4, 0});
  CHECK(static_cast<double>(steps.size()) == step_count(recipe));
  CHECK((steps[3].hold && steps[3].dwell_s == 2.0 && !steps[1].hold && !steps[4].hold));
}

TEST_CASE("recipe: the path to a branch settles at every level, even if the recipe's ramps do not stop") {
  const Recipe ramps = recipe_of("turning_points = [0, 4, 2, 4]\nstep = 2\nsettle = \"none\"\nramp_psi_per_s = 0.5\n");
  const auto back = path_to_branch(ramps, 0, 0, 2);
  REQUIRE(back.size() == 5);  // a cycle to the highest level, then 0, 4, 2
  for (const Step& step : back) CHECK(step.settle);
}

TEST_CASE("recipe: the path to a branch ends where the branch starts, in all shipped levels recipes") {
  for (const char* name : {"descending", "ascending", "inner-loops", "random-reversal", "rate", "creep-hold"}) {
    const Recipe recipe = read_recipe(kRecipes + name + ".toml");
    const auto steps = compile(recipe, 0);
    for (const BranchSpan& span : branches(steps)) {
      if (span.kind != SpanKind::kBranch || span.key.repeat > 1) continue;
      const Step& first = steps[span.first];
      const auto back = path_to_branch(recipe, 0, span.key.repeat, span.key.branch);
      CHECK(back.back().setpoint == first.branch_from);
    }
  }
}

TEST_CASE("branch spans: cover all steps once and name the branches") {
  const auto steps =
      compile(recipe_of("turning_points = [0, 4, 0]\nstep = 2\nrepeats = 2\n[conditioning]\ncycles = 2\npeak = 4\n"
                        "[prompt]\nbefore = \"ready?\"\n"),
              0);
  const auto spans = branches(steps);
  REQUIRE(spans.size() == 6);
  CHECK((spans[0].kind == SpanKind::kTravel && spans[0].count == 1));
  CHECK((spans[1].kind == SpanKind::kConditioning && spans[1].count == 4));
  const std::vector<BranchKey> keys = {{0, 0, 0}, {0, 0, 1}, {0, 1, 0}, {0, 1, 1}};
  std::size_t next = 5;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const BranchSpan& span = spans[i + 2];
    CHECK((span.kind == SpanKind::kBranch && span.key == keys[i]));
    CHECK(span.first == next);
    CHECK(span.count == (i % 2 == 0 ? 3 : 2));
    next += span.count;
  }
  CHECK(next == steps.size());
}

TEST_CASE("random reversals: lie on the grid, alternate up and down, and are equal for equal seeds") {
  const auto points = [](int seed, int low) {
    return recipe_of("step = 2\n[random]\nseed = " + std::to_string(seed) +
                     "\nreversals = 99\nlow = " + std::to_string(low) + "\nhigh = 60\n")
        .turning_points;
  };
  for (const int low : {0, 10, 56}) {
    const auto drawn = points(3, low);
    REQUIRE(drawn.size() == 103);
    CHECK((drawn[0] == Psi(0) && drawn[1] == Psi(60) && drawn[2] == Psi(0) && drawn.back() == Psi(0)));
    for (std::size_t i = 3; i + 1 < drawn.size(); ++i) {
      CHECK((drawn[i].value() >= low && drawn[i].value() <= 60.0));
      CHECK(std::fmod(drawn[i].value(), 2.0) == 0.0);
      CHECK((drawn[i] > drawn[i - 1]) == (i % 2 == 1));
      CHECK(drawn[i] != drawn[i - 1]);
    }
  }
  CHECK(points(3, 0) == points(3, 0));
  CHECK(points(3, 0) != points(4, 0));
}

TEST_CASE("drawn points: each kind keeps its reversal sizes, bounds and holds, for twenty seeds") {
  struct Row {
    const char *kind, *refused;  // the key that is refused with an even number; empty: none
    int low, smallest, most;     // of a reversal, in steps of 2 psi
    bool loop;                   // to the highest first
    std::size_t points;          // with 99 drawn
  };
  const Row row =
      GENERATE(Row{"reversals", "random.reversals", 4, 1, 28, true, 103},
               Row{"wander", "random.reversals", 4, 1, 3, false, 101}, Row{"press", "", 4, 2, 30, false, 199});
  const auto body = [&](int seed, int count) {
    return fmt::format(
        "step = 2\nframes_per_level = 5\nframes_at = \"turns\"\n[random]\nkind = \"{}\"\nseed = {}\nreversals = {}\n"
        "low = {}\nhigh = 60\n",
        row.kind, seed, count, row.low);
  };
  INFO(row.kind);
  for (int seed = 1; seed <= 20; ++seed) {
    const Recipe recipe = recipe_of(body(seed, 99));
    const std::vector<Psi>& points = recipe.turning_points;
    REQUIRE(points.size() == row.points);
    CHECK((points.front() == Psi(0) && points.back() == Psi(0)));
    if (row.loop) CHECK((points[1] == Psi(60) && points[2] == Psi(0)));
    CHECK_THAT(recipe.drawn, Catch::Contains(row.kind));
    double highest = 0.0;
    for (std::size_t i = row.loop ? 4 : 2; i + 1 < points.size(); ++i) {  // from one drawn point to another
      const double from = points[i - 1].value(), to = points[i].value(), size = std::abs(to - from) / 2.0;
      CHECK((to > from) != (points[i - 1] > points[i - 2]));
      CHECK(size == std::round(size));
      CHECK((size >= row.smallest && size <= row.most));
      CHECK((std::max(from, to) <= 60.0 && (to >= row.low || row.points == 199)));
      highest = std::max(highest, to);
    }
    CHECK(highest > 40.0);  // nothing stays where it began
    const auto steps = compile(recipe, 0);
    CHECK(static_cast<double>(steps.size()) == step_count(recipe));
    const auto held = std::ranges::count_if(steps, [](const Step& step) { return step.hold; });
    CHECK(held == 4 * static_cast<long>(points.size()));
    CHECK(points == recipe_of(body(seed, 99)).turning_points);
    CHECK(points != recipe_of(body(seed + 1, 99)).turning_points);
  }
  CHECK(level_refused(body(1, 2)) == (*row.refused != 0 ? row.refused : "accepted"));
  CHECK(level_refused("step = 2\n[random]\nkind = \"saw\"\nseed = 1\nreversals = 1\nlow = 0\nhigh = 60\n") ==
        "random.kind");
  CHECK(level_refused(body(1, 3) + "size = 2\n") == "random.size");
  CHECK(level_refused(body(1, 3) + "step = 3\n") == "random.step");
  for (const Psi& point : recipe_of(body(1, 9) + "step = 4\n").turning_points)
    CHECK(std::fmod(point.value(), 4.0) == 0.0);
}
