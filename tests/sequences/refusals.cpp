// Each refusal of a recipe in full: id, message, place and remedy.
#include "tests/sequences/refusal_words.h"

#include <catch2/catch.hpp>

#include "sequences/recipe.h"
#include "tests/sequences/recipe_text.h"

using namespace tactbench::sequences;

namespace {

const std::string kSweep = "turning_points = [0, 4]\nstep = 2\n";  // lines 4 and 5 of test.toml

std::string said_of(const std::string& body) {
  return words_of([&] { (void)recipe_of(body); });
}

// Lines 1 to 5 are those before `press`, which follows in [press].
std::string said_of_press(const std::string& press, const std::string& root = {}) {
  return words_of([&] {
    (void)parse_recipe(TomlDocument::from_text(
        "schema = 1\nname = \"t\"\nkind = \"press\"\n" + root + "[press]\nobject = \"ring\"\n" + press, "p.toml"));
  });
}

std::string said_of_random(const std::string& step, const std::string& table) {
  return said_of("step = " + step + "\n[random]\n" + table);
}

}  // namespace

TEST_CASE("what is said of a step or turning points that cannot be taken") {
  CHECK(said_of("turning_points = [0, 4]\nstep = 0\n") ==
        "TB-FILE-VALUE | 'step' must be above 0 | test.toml:5:8, step | use the distance between levels");
  CHECK(said_of("turning_points = [4]\nstep = 2\n") ==
        "TB-FILE-VALUE | fewer than two turning points | test.toml:4:18, turning_points | "
        "e.g. [0, 60, 0]; a single level needs frames_per_level above 1");
  CHECK(
      said_of("turning_points = [4, -2]\nstep = 2\n") ==
      "TB-FILE-VALUE | turning point 2 is negative: -2 | test.toml:4:18, turning_points | gauge pressure starts at 0");
  CHECK(said_of("turning_points = [4, 2, 5, 4]\nstep = 2\n") ==
        "TB-FILE-VALUE | 2 to 5 is not a whole number of steps of 2 | test.toml:4:18, turning_points | "
        "choose turning points that are whole steps apart");
}

TEST_CASE("what is said of random reversals that cannot be drawn") {
  CHECK(said_of(kSweep + "[random]\nseed = 1\nreversals = 1\nlow = 0\nhigh = 8\n") ==
        "TB-FILE-VALUE | both turning_points and [random] | test.toml:6:1, random | keep one of the two");
  CHECK(said_of_random("2", "seed = 1\nreversals = 4\nlow = 0\nhigh = 8\n") ==
        "TB-FILE-VALUE | 4 reversals end on a lower point, and the way to 0 continues falling | "
        "test.toml:7:13, random.reversals | use an odd number");
  CHECK(said_of_random("2", "seed = 1\nreversals = 3\nlow = 1\nhigh = 8\n") ==
        "TB-FILE-VALUE | 'low' is not a whole number of steps of 2 | test.toml:8:7, random.low | choose one that is");
  CHECK(said_of_random("2", "seed = 1\nreversals = 3\nlow = 0\nhigh = 9\n") ==
        "TB-FILE-VALUE | 'high' is not a whole number of steps of 2 | test.toml:9:8, random.high | choose one that is");
  CHECK(said_of_random("2", "seed = 1\nreversals = 3\nlow = 6\nhigh = 8\n") ==
        "TB-FILE-VALUE | there is no room for reversals between 6 and 8 | test.toml:9:8, random.high | "
        "0 <= low, and at least two steps from low to high");
  CHECK(said_of_random("2", "seed = 1\nreversals = 3\nlow = 0\nhigh = 2000002\n") ==
        "TB-FILE-VALUE | 2e+06 is 1000001 steps of 2 | test.toml:9:8, random.high | "
        "a larger step: a run may have 1000000 steps");
}

TEST_CASE("what is said of dwells, ramps and frames that cannot be taken") {
  CHECK(said_of(kSweep + "dwell_s = [1, -1]\n") ==
        "TB-FILE-VALUE | 'dwell_s' is -1, outside 0 to 86400 | test.toml:6:11, dwell_s | use 0 to 86400");
  CHECK(said_of(kSweep + "ramp_psi_per_s = 1001\n") ==
        "TB-FILE-VALUE | 'ramp_psi_per_s' is 1001 | test.toml:6:18, ramp_psi_per_s | "
        "use 0.01 to 1000, or 0 for the bench's own limit");
  const std::string passing = kSweep + "settle = \"none\"\n";
  CHECK(said_of(passing) ==
        "TB-FILE-VALUE | 'ramp_psi_per_s' is 0 | test.toml:1:1, ramp_psi_per_s | "
        "use 0.01 to 1000: settle = \"none\" needs a ramp");
  CHECK(said_of(passing + "ramp_psi_per_s = 1\ndwell_s = 2\n") ==
        "TB-FILE-VALUE | 'dwell_s' is 2, outside 0 to 0 | test.toml:8:11, dwell_s | "
        "frames taken in passing (settle = \"none\") have no dwell");
  CHECK(said_of(passing + "ramp_psi_per_s = 1\nframes_per_level = 2\n") ==
        "TB-FILE-VALUE | several frames at a level that is only passed | test.toml:8:20, frames_per_level | "
        "remove settle = \"none\"");
}

TEST_CASE("what is said of conditioning, repeats and suspensions that cannot be taken") {
  CHECK(said_of(kSweep + "[conditioning]\ncycles = 2\nleast = 3\npeak = 4\n") ==
        "TB-FILE-VALUE | at least 3 cycles, at most 2 | test.toml:8:9, conditioning.least | "
        "'cycles' is the greatest number");
  CHECK(said_of(kSweep + "[conditioning]\ncycles = 0\nleast = 101\n") ==
        "TB-FILE-VALUE | 'least' is 101, not a whole number from 0 to 100 | test.toml:8:9, conditioning.least | "
        "use a whole number from 0 to 100");
  for (const auto& [cycles, peak] : std::vector<std::pair<std::string, std::string>>{{"0", "-1"}, {"1", "0"}}) {
    CHECK(said_of(kSweep + "[conditioning]\ncycles = " + cycles + "\npeak = " + peak + "\n") ==
          "TB-FILE-VALUE | 'peak' is " + peak +
              " | test.toml:8:8, conditioning.peak | a cycle goes from 0 to a peak above 0");
  }
  CHECK(said_of(kSweep + "dwell_s = [1, 2, 3]\nrepeats = 2\n") ==
        "TB-FILE-VALUE | repeats = 2 for a list of 3: not all would be used | test.toml:7:11, repeats | "
        "use at least 3, or shorten the list");
  const std::string suspend = kSweep + "[[suspend]]\nquantity = \"supply_bar\"\n";
  CHECK(said_of(suspend) ==
        "TB-FILE-VALUE | a [[suspend]] needs either trip_below or trip_above | test.toml:7:12, suspend[0].quantity | "
        "for instance trip_below = 6.0 with resume_above = 6.5");
  CHECK(said_of(suspend + "trip_below = 6\nresume_above = 5.5\n") ==
        "TB-FILE-VALUE | 'resume_above' is 5.5, on the wrong side of the trip at 6 | "
        "test.toml:9:16, suspend[0].resume_above | a quantity must come back past the trip before the run continues");
  CHECK(said_of(suspend + "trip_above = 6\nresume_below = 7\n") ==
        "TB-FILE-VALUE | 'resume_below' is 7, on the wrong side of the trip at 6 | "
        "test.toml:9:16, suspend[0].resume_below | a quantity must come back past the trip before the run continues");
}

TEST_CASE("what is said of a press that cannot be made") {
  CHECK(words_of([] {
          (void)parse_recipe(TomlDocument::from_text("schema = 1\nname = \"t\"\nkind = \"press\"\n", "p.toml"));
        }) == "TB-FILE-VALUE | kind = \"press\" without a [press] | p.toml:1:1, press | add [press] with forces_n");
  const std::string at = "positions_mm = [[1, 1]]\n";
  CHECK(said_of_press(at + "forces_n = [2]\n", "dwell_s = [1, 86401]\n") ==
        "TB-FILE-VALUE | 'dwell_s' is 86401, outside 0 to 86400 | p.toml:4:11, dwell_s | use 0 to 86400");
  CHECK(said_of_press(at + "forces_n = []\n") ==
        "TB-FILE-VALUE | 'forces_n' is empty | p.toml:7:12, press.forces_n | e.g. [2, 6, 10, 20, 30]");
  CHECK(said_of_press(at + "forces_n = [0.1]\n") ==
        "TB-FILE-VALUE | force 1 is 0.1 N, not above 0.2 N | p.toml:7:12, press.forces_n | "
        "forces rise, from above contact_n; the way down is added");
  CHECK(said_of_press(at + "forces_n = [1, 3, 2]\n") ==
        "TB-FILE-VALUE | force 3 is 2 N, not above 3 N | p.toml:7:12, press.forces_n | "
        "forces rise, from above contact_n; the way down is added");
  CHECK(said_of_press("forces_n = [2]\n") ==
        "TB-FILE-VALUE | a press recipe needs either positions_mm or [press.grid] | p.toml:4:1, press.positions_mm | "
        "e.g. positions_mm = [[20, 20]]");
}

TEST_CASE("what is said of a grid that has no positions or too many") {
  const auto grid = [](const std::string& x, const std::string& y) {
    return said_of_press("forces_n = [2]\n[press.grid]\nx = " + x + "\ny = " + y + "\n");
  };
  const std::string one = "[1, 1, 1]";
  // A step of 0 is refused in the same words whether the axis has a length or none.
  for (const char* x : {"[1, 2]", "[1, 2, 3, 4]", "[2, 1, 1]", "[1, 2, -1]", "[1, 2, 0]", "[1, 1, 0]", "[2, 1, -1]"}) {
    INFO(x);
    CHECK(grid(x, one) ==
          "TB-FILE-VALUE | 'x' must be [from, to, step] with a step above 0 | p.toml:8:5, press.grid.x | "
          "e.g. x = [10, 20, 2.54]");
  }
  CHECK(grid(one, "[1, 10001, 1]") ==
        "TB-FILE-VALUE | 'y' has 10001 positions | p.toml:9:5, press.grid.y | "
        "a larger step: a recipe may have 10000");
  CHECK(grid("[1, 101, 1]", "[1, 100, 1]") ==
        "TB-FILE-VALUE | 101 x 100 positions | p.toml:7:1, press.grid | a recipe may have 10000");
}

TEST_CASE("what is said of a recipe with too many steps or too long a dwell") {
  CHECK(said_of("turning_points = [0, 4]\nstep = 2\nframes_per_level = 1001\nrepeats = 1000\n") ==
        "TB-FILE-VALUE | the recipe has 3003000 steps (3 levels a repeat, 1001 frames a level, 1000 repeats) | "
        "test.toml:6:20, frames_per_level | "
        "a run may have 1000000 steps: a larger step, or fewer frames a level or repeats");
  CHECK(said_of_press("positions_mm = [[1, 1]]\nforces_n = [2]\ntare = false\n[conditioning]\ncycles = 0\n",
                      "repeats = 1000\n") == "accepted");
  CHECK(said_of_press("forces_n = [2, 3]\n[press.grid]\nx = [1, 200, 1]\ny = [1, 1, 1]\n", "repeats = 1000\n") ==
        "TB-FILE-VALUE | the recipe has 1201002 steps (200 positions, 3 forces up and down, 1000 repeats) | "
        "p.toml:4:11, repeats | a run may have 1000000 steps: fewer positions, forces or repeats");
  CHECK(said_of(kSweep + "dwell_s = 86400\nrepeats = 123\n") ==
        "TB-FILE-VALUE | the recipe dwells for 369 days in 369 steps | test.toml:6:11, dwell_s | "
        "a recipe may dwell for 366 days");
}

TEST_CASE("a dwell that is too long is refused at its longer part, before the first frame or between the frames") {
  const auto said = [](double dwell_s, double interval_s) {
    return said_of(kSweep + fmt::format("repeats = 92\nframes_per_level = 2\ndwell_s = {}\nframe_interval_s = {}\n",
                                        dwell_s, interval_s));
  };
  // 3 levels x 92 repeats, two frames each.
  CHECK(said(77'760.0, 86'400.0) ==
        "TB-FILE-VALUE | the recipe dwells for 524 days in 552 steps | test.toml:9:20, frame_interval_s | "
        "a recipe may dwell for 366 days");
  CHECK(said(86'400.0, 43'200.0) ==
        "TB-FILE-VALUE | the recipe dwells for 414 days in 552 steps | test.toml:8:11, dwell_s | "
        "a recipe may dwell for 366 days");
}

TEST_CASE("what is said of parameters that cannot be used") {
  const auto said = [](const std::string& tables, const std::vector<Override>& overrides = {}) {
    return words_of([&] {
      (void)parse_recipe(TomlDocument::from_text("schema = 1\nname = \"t\"\nunit = \"psi\"\nturning_points = "
                                                 "[0, \"$peak\"]\nstep = 1\n[parameters.peak]\n" +
                                                     tables,
                                                 "p.toml"),
                         overrides);
    });
  };
  CHECK(said("default = 5\nlow = 2\nhigh = 4\n") ==
        "TB-FILE-VALUE | 'default' is 5, outside 2 to 4 | p.toml:7:11, parameters.peak.default | "
        "choose low <= default <= high");
  const std::string peak = "default = 2\nlow = 2\nhigh = 4\n";
  CHECK(said(peak, {{"peak", "5"}}) ==
        "TB-FILE-VALUE | 'peak' is 5, outside 2 to 4 | --set recipe.peak=5 (over p.toml) | use 2 to 4");
  CHECK(said(peak, {{"peak", "high"}}) ==
        "TB-FILE-VALUE | 'peak' must be a number, it is text | --set recipe.peak=high (over p.toml) | "
        "write the number alone; its unit is in the key");
  const std::string idle = peak + "[parameters.idle]\ndefault = 1\nlow = 1\nhigh = 1\n";
  CHECK(said(idle) ==
        "TB-FILE-VALUE | nothing uses the parameter 'idle' | p.toml:10:1, parameters.idle | "
        "write \"$idle\" where its value belongs, or remove it");
  // A value typed over the file may have stood where the parameter was used. One of a parameter stands nowhere.
  CHECK(said(idle, {{"step", "2"}}) == "accepted");
  CHECK(said(idle, {{"idle", "1"}}) ==
        "TB-FILE-VALUE | nothing uses the parameter 'idle' | p.toml:10:1, parameters.idle | "
        "write \"$idle\" where its value belongs, or remove it");
}

TEST_CASE("what is said of recipes that are too many together") {
  const Recipe half = recipe_of("turning_points = [0, 60, 0]\nstep = 0.0002\n");
  CHECK(words_of([&] {
          (void)compile({half, half});
        }) ==
        "TB-FILE-VALUE | the recipes together have 1200002 steps | recipes t, t | "
        "a run may have 1000000 steps: use several runs");
}
