// The number of a recipe's steps is known, and bounded, before any step is made.
#include <catch2/catch.hpp>
#include <ctime>
#include <filesystem>

#include "sequences/recipe.h"
#include "tests/sequences/refusal.h"
#include "tests/support/paths.h"

using namespace tactbench::sequences;

namespace {

const std::string kHead = "schema = 1\nname = \"t\"\nunit = \"psi\"\n";
const std::string kPressHead = "schema = 1\nname = \"t\"\nkind = \"press\"\n";

void check_refused(const std::string& body, const std::string& steps, const std::string& place,
                   const std::vector<Override>& overrides = {}) {
  const std::clock_t start = std::clock();
  check_refusal([&] { (void)parse_recipe(TomlDocument::from_text(body, "big.toml"), overrides); },
                {body, "TB-FILE-VALUE", place, steps});
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
  check_refused(sweep + "step = 0.0001\n", "1200001 steps", "big.toml:5:8, step");
  check_refused(sweep + "step = 2\nframes_per_level = 100000\n", "6100000 steps", "big.toml:6:20, frames_per_level");
  check_refused(sweep + "step = 2\nframes_per_level = 30\nrepeats = 1000\n", "1830000 steps", "big.toml:7:11, repeats");
  const std::string random = "[random]\nseed = 1\nreversals = 9999\nlow = 0\nhigh = 60\n";
  check_refused(kHead + "step = 0.01\n" + random, "steps", "step");
  check_refused(kHead + "step = 1e-9\n" + random, "60000000000 steps", "random.high");
  const std::string press = kPressHead + "repeats = 1000\n[press]\nobject = \"ring\"\nforces_n = [1, 2, 3]\n";
  check_refused(press + "[press.grid]\nx = [0, 9, 1e-9]\ny = [0, 1, 1]\n", "9000000001", "press.grid.x");
  check_refused(press + "[press.grid]\nx = [0, 99, 1]\ny = [0, 99, 1]\n", "10000 positions", "press.grid");
}

TEST_CASE("typed values go through the same bound") {
  const std::string body = kHead + "turning_points = [0, 60, 0]\nstep = 2\n";
  check_refused(body, "1200001 steps", "--set recipe.step (over big.toml)", {{"step", "1e-4"}});
  check_refused(body, "steps", "--set recipe.frames_per_level (over big.toml)", {{"frames_per_level", "99999"}});
}
