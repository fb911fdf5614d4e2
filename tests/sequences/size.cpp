// The number of a recipe's steps is known, and bounded, before any step is made.
#include <catch2/catch.hpp>
#include <ctime>
#include <filesystem>

#include "sequences/recipe.h"
#include "tests/support/paths.h"

using namespace tactbench::sequences;

namespace {

const std::string kHead = "schema = 1\nname = \"t\"\nunit = \"psi\"\n";
const std::string kPressHead = "schema = 1\nname = \"t\"\nkind = \"press\"\n";

struct Refused {
  std::string body, message, where;
};

void check_refused(const Refused& wanted, const std::vector<Override>& overrides = {}) {
  INFO(wanted.body);
  const std::clock_t start = std::clock();
  try {
    (void)parse_recipe(TomlDocument::from_text(wanted.body, "big.toml"), overrides);
    FAIL("accepted");
  } catch (const FileError& error) {
    CHECK(error.id() == "TB-FILE-VALUE");
    CHECK_THAT(error.what(), Catch::Contains(wanted.message));
    CHECK_THAT(error.where(), Catch::Contains(wanted.where));
    CHECK_THAT(error.remedy(), Catch::Contains("may "));
  }
  CHECK(std::clock() - start < CLOCKS_PER_SEC);  // nothing was made: it takes well below a millisecond
}

}  // namespace

TEST_CASE("a recipe's steps are counted without making them") {
  int looked = 0;
  for (const auto& entry : std::filesystem::directory_iterator(tactbench::tests::source_path("sequences"))) {
    if (entry.path().extension() != ".toml" || entry.path().stem() == "nightly") continue;
    INFO(entry.path());
    const Recipe recipe = read_recipe(entry.path());
    CHECK(step_count(recipe) == static_cast<double>(compile(recipe, 0).size()));
    ++looked;
  }
  CHECK(looked >= 15);
  const Recipe levels = parse_recipe(TomlDocument::from_text(
      kHead + "turning_points = [0, 6, 2, 6]\nstep = 2\nframes_per_level = 3\nrepeats = 4\n[conditioning]\n"
              "cycles = 5\npeak = 60\n[prompt]\nbefore = \"ready?\"\n",
      "t.toml"));
  CHECK(step_count(levels) == static_cast<double>(compile(levels, 0).size()));
  for (const char* tare : {"true", "false"}) {
    const Recipe press = parse_recipe(TomlDocument::from_text(
        kPressHead +
            "repeats = 3\n[conditioning]\ncycles = 2\n[press]\nobject = \"ring\"\nforces_n = [1, 2, 3]\n"
            "positions_mm = [[1, 1], [2, 2]]\ntare = " +
            tare + "\n",
        "t.toml"));
    CHECK(step_count(press) == static_cast<double>(compile(press, 0).size()));
  }
}

TEST_CASE("a recipe with more than a million steps is refused with file, line, key, number and bound") {
  const std::string sweep = kHead + "turning_points = [0, 60, 0]\n";
  check_refused({sweep + "step = 0.0001\n", "has 1200001 steps", "big.toml:5:8, step"});
  check_refused({sweep + "step = 0.000001\n", "steps", "big.toml:5:8, step"});
  check_refused(
      {sweep + "step = 2\nframes_per_level = 100000\n", "has 6100000 steps", "big.toml:6:20, frames_per_level"});
  check_refused(
      {sweep + "step = 2\nframes_per_level = 30\nrepeats = 1000\n", "has 1830000 steps", "big.toml:7:11, repeats"});
  const std::string random = "[random]\nseed = 1\nreversals = 9999\nlow = 0\nhigh = 60\n";
  check_refused({kHead + "step = 0.01\n" + random, "steps", "step"});
  check_refused({kHead + "step = 1e-9\n" + random, "60000000000 steps", "random.high"});
  const std::string press = kPressHead + "repeats = 1000\n[press]\nobject = \"ring\"\nforces_n = [1, 2, 3]\n";
  check_refused(
      {press + "[press.grid]\nx = [0, 9, 1e-9]\ny = [0, 1, 1]\n", "'x' has 9000000001 positions", "press.grid.x"});
  check_refused({press + "[press.grid]\nx = [0, 99, 1]\ny = [0, 99, 1]\n", "10000 positions", "press.grid"});
}

TEST_CASE("typed values go through the same bound") {
  const std::string body = kHead + "turning_points = [0, 60, 0]\nstep = 2\n";
  check_refused({body, "has 1200001 steps", "--set recipe.step (over big.toml)"}, {{"step", "1e-4"}});
  check_refused({body, "steps", "--set recipe.frames_per_level"}, {{"frames_per_level", "99999"}});
}

TEST_CASE("a recipe that dwells for more than a year is refused") {
  const std::string body = kHead + "turning_points = [0, 60, 0]\nstep = 2\n";
  check_refused({body + "dwell_s = 86400\nrepeats = 7\n", "dwells for 427 days", "big.toml:6:11, dwell_s"});
  check_refused(
      {body + "frames_per_level = 10\nframe_interval_s = 86400\n", "dwells for 549 days", "frame_interval_s"});
}

TEST_CASE("recipes that are short one by one are refused when they are too long together") {
  const Recipe half =
      parse_recipe(TomlDocument::from_text(kHead + "turning_points = [0, 60, 0]\nstep = 0.0002\n", "t"));
  CHECK(step_count(half) == 600001.0);
  try {
    (void)compile({half, half});
    FAIL("accepted");
  } catch (const FileError& error) {
    CHECK_THAT(error.what(), Catch::Contains("1200002 steps"));
    CHECK_THAT(error.remedy(), Catch::Contains("1000000 steps"));
  }
}

TEST_CASE("a ramp or a speed that is far too slow is refused") {
  const std::string body = kHead + "turning_points = [0, 60, 0]\nstep = 2\n";
  CHECK_THROWS_AS(parse_recipe(TomlDocument::from_text(body + "ramp_psi_per_s = 1e-9\n", "t")), FileError);
  CHECK_NOTHROW(parse_recipe(TomlDocument::from_text(body + "ramp_psi_per_s = 0.01\n", "t")));
  const std::string press = kPressHead + "[press]\nobject = \"ring\"\nforces_n = [1]\npositions_mm = [[1, 1]]\n";
  for (const char* key : {"servo_mm_per_s", "approach_mm_per_s", "clear_mm", "contact_n"}) {
    INFO(key);
    CHECK_THROWS_AS(parse_recipe(TomlDocument::from_text(press + key + " = 1e-9\n", "t")), FileError);
  }
}
