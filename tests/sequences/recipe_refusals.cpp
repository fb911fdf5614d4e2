// Refusals of a recipe: the error's id, its place, and the number or key at fault.

#include <fmt/format.h>
#include <catch2/catch.hpp>

#include <cmath>
#include <ctime>
#include <filesystem>
#include <map>

#include "sequences/recipe.h"
#include "tests/sequences/refusal.h"
#include "tests/support/paths.h"

using namespace tactbench::sequences;

namespace {

const std::string kSweep = "turning_points = [0, 4]\nstep = 2\n";  // lines 4 and 5 of test.toml
const std::string kValue = "TB-FILE-VALUE";

void read_levels(const std::string& body) { (void)recipe_of(body); }

}  // namespace

TEST_CASE("recipe: invalid keys, texts, units and numbers are refused with their place") {
  check_refusals(
      {{kSweep + "dwel_s = 2\n", "TB-FILE-KEY", "test.toml:6:10, dwel_s", "dwel_s"},
       {kSweep + "dwell_s = \"2 s\"\n", kValue, "test.toml:6:11, dwell_s"},
       {kSweep + "dwell_s = 2 s\n", "TB-FILE-SYNTAX", "test.toml:6:13"},

       {kSweep + "[guard]\ntolerance = 1\n", "TB-FILE-KEY", "test.toml:7:13, guard.tolerance", "tolerance"},
       {kSweep + "[guard]\non_broken = \"flags\"\n", kValue, "test.toml:7:13, guard.on_broken", "fail, flag"},
       {"turning_points = [0, 4]\n", "TB-FILE-KEY", "step", "step"},
       {"turning_points = [0, 4]\nstep = 0\n", kValue, "test.toml:5:8, step"},
       {"turning_points = [0, nan]\nstep = 2\n", kValue, "test.toml:4:18, turning_points", " 2 "},
       {kSweep + "ramp_psi_per_s = 1001\n", kValue, "test.toml:6:18, ramp_psi_per_s", "1001"},
       {kSweep + "settle = \"none\"\n", kValue, "test.toml:1:1, ramp_psi_per_s"},
       {kSweep + "[random]\nseed = 1\nreversals = 1\nlow = 0\nhigh = 8\n", kValue, "test.toml:6:1, random"},
       {kSweep + "[conditioning]\ncycles = 1\n", "TB-FILE-KEY", "conditioning.peak"},
       {kSweep + "repeats = 0\n", kValue, "test.toml:6:11, repeats", "from 1"},
       {kSweep + "repeats = 1.5\n", kValue, "test.toml:6:11, repeats", "1.5"},
       {kSweep + "dwell_s = [1, 2, 3]\nrepeats = 2\n", kValue, "test.toml:7:11, repeats", "3"}},
      read_levels);
  check_refusal(
      [] {
        (void)parse_recipe(
            TomlDocument::from_text("schema=1\nname=\"x\"\nunit=\"PSI\"\nturning_points=[0,2]\nstep=2\n", "u"));
      },
      {"unit PSI", kValue, "u:3:6, unit", "psi"});
}

TEST_CASE("press recipe: an impossible press is refused with its place") {
  const std::string at = "positions_mm = [[1, 1]]\n";
  check_refusals({{at + "forces_n = []\n", kValue, "p.toml:7:12, press.forces_n"},
                  {at + "forces_n = [0.1]\n", kValue, "p.toml:7:12, press.forces_n", "0.2 N"},
                  {at + "forces_n = [1, 3, 2]\n", kValue, "p.toml:7:12, press.forces_n", "force 3 "},
                  {at + "forces_n = [1, 1.5, 1.5]\n", kValue, "press.forces_n", "1.5 N"},
                  {at + "contact_n = 0.5\nforces_n = [0.5, 1]\n", kValue, "press.forces_n", "force 1 "},
                  {"forces_n = [2]\n", kValue, "p.toml:4:1, press.positions_mm"},
                  {"positions_mm = [[10]]\nforces_n = [2]\n", kValue, "p.toml:6:16, press.positions_mm", "element 1"},
                  {"positions_mm = [10, 2]\nforces_n = [2]\n", kValue, "p.toml:6:16, press.positions_mm", "element 1"},
                  {at + "forces_n = [2]\nsteps = 3\n", "TB-FILE-KEY", "p.toml:8:9, press.steps", "steps"},
                  {at + "forces_n = [2]\nhold = \"forces\"\n", kValue, "p.toml:8:8, press.hold", "position, force"}},
                 [](const std::string& body) { (void)press_of(body); });
  CHECK_NOTHROW(press_of(at + "contact_n = 0.5\nforces_n = [0.5000001, 0.75]\n"));
  check_refusal([&] { (void)press_of(at + "forces_n = [2]\n", "dwell_s = [1, 86401]\n"); },
                {"a day and a second", kValue, "p.toml:4:11, dwell_s", "0 to 86400"});
  check_refusal(
      [] { (void)parse_recipe(TomlDocument::from_text("schema = 1\nname = \"t\"\nkind = \"press\"\n", "p.toml")); },
      {"no [press]", kValue, "p.toml:1:1, press"});
}

TEST_CASE("press grid: no positions or too many are refused") {
  const auto grid = [](const std::string& x, const std::string& y, const std::string& place, const std::string& fact) {
    check_refusal([&] { (void)press_of("forces_n = [2]\n[press.grid]\nx = " + x + "\ny = " + y + "\n"); },
                  {x + " " + y, kValue, place, fact});
  };
  const std::string one = "[1, 1, 1]";
  for (const char* x : {"[1, 2]", "[1, 2, 3, 4]", "[2, 1, 1]", "[1, 2, -1]", "[1, 2, 0]", "[1, 1, 0]", "[2, 1, -1]"})
    grid(x, one, "p.toml:8:5, press.grid.x", "");
  grid(one, "[1, 10001, 1]", "p.toml:9:5, press.grid.y", "10001");
  grid("[1, 101, 1]", "[1, 100, 1]", "p.toml:7:1, press.grid", "101 x 100");
}

TEST_CASE("recipe parameter: an invalid or unused one is refused") {
  const auto read = [](const std::string& tables, const std::vector<Override>& overrides = {}) {
    (void)parse_recipe(TomlDocument::from_text("schema = 1\nname = \"t\"\nunit = \"psi\"\nturning_points = "
                                               "[0, \"$peak\"]\nstep = 1\n[parameters.peak]\n" +
                                                   tables,
                                               "p.toml"),
                       overrides);
  };
  const std::string peak = "default = 2\nlow = 2\nhigh = 4\n";
  const std::string idle = peak + "[parameters.idle]\ndefault = 1\nlow = 1\nhigh = 1\n";
  check_refusals({{"default = 5\nlow = 2\nhigh = 4\n", kValue, "p.toml:7:11, parameters.peak.default", "2 to 4"},
                  {"default = 1\nlow = 2\nhigh = 4\n", kValue, "p.toml:7:11, parameters.peak.default", "2 to 4"},
                  {"default = 3\nlow = 0\nhihg = 2\n", "TB-FILE-KEY", "p.toml:6:1, parameters.peak.high", "high"},
                  {peak + "value = 9\n", kValue, "p.toml:10:9, parameters.peak.value", "9"},
                  {idle, kValue, "p.toml:10:1, parameters.idle", "idle"}},
                 [&](const std::string& tables) { read(tables); });
  struct Typed {
    std::vector<Override> overrides;
    std::string id, place, fact;
  };
  for (const Typed& one : std::vector<Typed>{
           {{{"peak", "5"}}, kValue, "--set recipe.peak=5 (over p.toml)", "2 to 4"},
           {{{"peak", "3"}, {"peak", "9"}, {"name", "u"}}, kValue, "--set recipe.peak=9 (over p.toml)", "9"},
           {{{"peak", "high"}}, kValue, "--set recipe.peak=high (over p.toml)", ""},
           {{{"step", "-1"}}, kValue, "--set recipe.step (over p.toml)", ""},
           {{{"paek", "1"}}, "TB-FILE-KEY", "--set recipe.paek (over p.toml)", "paek"}})
    check_refusal([&] { read(peak, one.overrides); }, {one.place, one.id, one.place, one.fact});
  // A value typed over the file may have stood where the parameter was used. One of a parameter stands nowhere.
  CHECK_NOTHROW(read(idle, {{"step", "2"}}));
  CHECK_THROWS_AS(read(idle, {{"idle", "1"}}), FileError);
  for (const char* bound : {"2", "4"}) CHECK_NOTHROW(read("default = " + std::string(bound) + "\nlow = 2\nhigh = 4\n"));
  CHECK_NOTHROW(read(peak + "value = 9\n", {{"peak", "3"}}));
  CHECK_NOTHROW(read(peak, {{"peak", "9"}, {"peak", "3"}}));
}

TEST_CASE("recipe: an unknown key is refused in every table") {
  const std::string press = "positions_mm = [[1, 1]]\nforces_n = [20]\n";
  for (const std::string& table :
       std::vector<std::string>{"conditioning", "limits", "guard", "warm_up", "dwell", "retry", "timeout", "prompt"})
    check_refusals({{kSweep + "[" + table + "]\nwhatever = 1\n", "TB-FILE-KEY", table + ".whatever"}}, read_levels);
  check_refusals({{kSweep + "[[suspend]]\nquantity = \"supply_bar\"\ntrip_below = 6\nresume_above = 6\n"
                            "whatever = 1\n",
                   "TB-FILE-KEY", "suspend[0].whatever"},
                  {kSweep + "[parameters.p]\ndefault = 1\nlow = 0\nhigh = 2\nwhatever = 1\n", "TB-FILE-KEY",
                   "parameters.p.whatever"},
                  {"step = 2\n[random]\nseed = 1\nreversals = 1\nlow = 0\nhigh = 60\nwhatever = 1\n", "TB-FILE-KEY",
                   "random.whatever"}},
                 read_levels);
  check_refusals({{press + "[conditioning]\nwhatever = 1\n", "TB-FILE-KEY", "conditioning.whatever"},
                  {"forces_n = [20]\n[press.grid]\nx = [1, 1, 1]\ny = [1, 1, 1]\nwhatever = 1\n", "TB-FILE-KEY",
                   "press.grid.whatever"}},
                 [](const std::string& body) { (void)press_of(body); });
}

// Which key the error for a too large recipe names, and the longest dwell that is allowed.

namespace {

std::string too_large(const std::string& text, const std::string& fact) {
  return key_refused([&] { (void)parse_recipe(TomlDocument::from_text(text, "s.toml")); }, fact);
}

// `levels` levels a repeat.
std::string sweep(int levels, int repeats, int frames, const std::string& more = {}) {
  return fmt::format(
             "schema = 1\nname = \"t\"\nunit = \"psi\"\nturning_points = [0, {}]\nstep = 1\nrepeats = {}\n"
             "frames_per_level = {}\n",
             levels - 1, repeats, frames) +
         more;
}

std::string grid(int positions, int forces, int repeats, bool listed, bool tare = false) {
  std::string list;
  for (int i = 1; i <= forces; ++i) list += fmt::format("{},", i);
  std::string text = fmt::format(
      "schema = 1\nname = \"t\"\nkind = \"press\"\nrepeats = {}\ndwell_s = 0\n[press]\nobject = \"ring\"\n"
      "forces_n = [{}]\ntare = {}\n",
      repeats, list, tare);
  if (!listed) return text + fmt::format("[press.grid]\nx = [1, {}, 1]\ny = [1, 1, 1]\n", positions);
  text += "positions_mm = [";
  for (int i = 0; i < positions; ++i) text += "[1, 1],";
  return text + "]\n";
}

constexpr double kDay = 86400.0;

bool dwells(const std::string& text) { return too_large(text, " days") == "accepted"; }

}  // namespace

TEST_CASE("recipe size: a million steps are accepted, and one step more is refused") {
  CHECK(too_large(sweep(100, 100, 100), "") == "accepted");
  CHECK(too_large(sweep(100, 100, 100, "[prompt]\nbefore = \"?\"\n"), "1000001 steps") == "step");
  // Home, 62 times a tare and at each of 2016 positions move, approach, 5 presses, retract, then a tare:
  // 1 + 62 x (1 + 2016 x 8) + 1 = 1000000.
  CHECK(too_large(grid(2016, 3, 62, false, true), "") == "accepted");
  const std::string asked = grid(2016, 3, 62, false, true) + "[prompt]\nbefore = \"?\"\n";
  CHECK(too_large(asked, "1000001 steps") == "press.grid");
}

TEST_CASE("recipe size: the error for too many steps names the key with the largest number") {
  CHECK(too_large(sweep(100, 100, 101), "1010000 steps") == "frames_per_level");
  CHECK(too_large(sweep(100, 101, 101), "1020100 steps") == "frames_per_level");
  CHECK(too_large(sweep(101, 100, 101), "1020100 steps") == "step");
  CHECK(too_large(sweep(101, 101, 100), "1020100 steps") == "step");
  CHECK(too_large(sweep(100, 101, 100), "1010000 steps") == "repeats");
  CHECK(too_large(sweep(200, 101, 100), "2020000 steps") == "step");
  // Of a press: the positions, or the forces up and down, of which 501 are 1001.
  CHECK(too_large(grid(1000, 501, 1, false), "1004001 steps") == "press.forces_n");
  CHECK(too_large(grid(1001, 501, 1, false), "1005005 steps") == "press.grid");
  CHECK(too_large(grid(1001, 501, 1, true), "1005005 steps") == "press.positions_mm");
  CHECK(too_large(grid(501, 1, 1000, true), "2004001 steps") == "repeats");
}

TEST_CASE("recipe dwell: 366 days are accepted, counting all frames, repeats and cycles") {
  const auto levels = [](int repeats, double dwell_s, const std::string& more = {}) {
    return sweep(2, repeats, 1, fmt::format("dwell_s = {}\n", dwell_s) + more);
  };
  CHECK(dwells(levels(183, kDay)));
  CHECK(!dwells(levels(184, kDay)));
  // A cycle dwells at its peak and at 0, as long as the first repeat.
  const std::string cycles = "[conditioning]\npeak = 1\ncycles = ";
  CHECK(dwells(levels(182, kDay, cycles + "1\n")));
  CHECK(!dwells(levels(182, kDay, cycles + "2\n")));
  // Repeats take their dwells in turn: 122 x (86400 s + 43200 s + 0 s) x 2 levels are 366 days.
  CHECK(dwells(sweep(2, 366, 1, "dwell_s = [86400, 43200, 0]\n")));
  CHECK(!dwells(sweep(2, 367, 1, "dwell_s = [86400, 43200, 0]\n")));
  // 2 levels x 61 repeats x (a day, and two more frames a day apart) are 366 days.
  const std::string held = "dwell_s = 86400\nframe_interval_s = 86400\n";
  CHECK(dwells(sweep(2, 61, 3, held)));
  CHECK(too_large(sweep(2, 62, 3, held), "372 days") == "frame_interval_s");
  CHECK(too_large(sweep(2, 92, 2, held), "368 days") == "dwell_s");  // as long at first as held
}

TEST_CASE("press recipe dwell: 366 days are accepted, counting every force at every position") {
  const auto press = [](int repeats, int cycles) {
    return fmt::format(
        "schema = 1\nname = \"t\"\nkind = \"press\"\nrepeats = {}\ndwell_s = 86400\n[press]\nobject = \"ring\"\n"
        "forces_n = [1, 2]\npositions_mm = [[1, 1], [2, 2]]\n[conditioning]\ncycles = {}\n",
        repeats, cycles);
  };
  // 2 positions x 3 forces a repeat, 2 positions a cycle.
  CHECK(dwells(press(61, 0)));
  CHECK(!dwells(press(62, 0)));
  CHECK(dwells(press(60, 3)));
  CHECK(!dwells(press(60, 4)));
}

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

TEST_CASE("recipe size: the step count equals the number of compiled steps") {
  const auto shipped = [](const std::string& name) {
    return tactbench::tests::source_path("sequences/" + name + ".toml");
  };
  int looked = 0;
  for (const auto& entry : std::filesystem::directory_iterator(tactbench::tests::source_path("sequences"))) {
    if (entry.path().extension() != ".toml" || entry.path().stem() == "nightly") continue;
    INFO(entry.path());
    for (const Recipe& recipe : read_recipe_file(entry.path(), {}, shipped).recipes) {
      CHECK(step_count(recipe) == static_cast<double>(compile(recipe, 0).size()));
      ++looked;
    }
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

TEST_CASE("recipe size: too many steps are refused with the file, line, key and number") {
  const std::string sweep = kHead + "turning_points = [0, 60, 0]\n";
  check_refused(sweep + "step = 0.0001\n", "1200001 steps", "big.toml:5:8, step");
  check_refused(sweep + "step = 1e-300\n", "e+", "big.toml:5:8, step");  // no 300 digits
  check_refused(sweep + "step = 2\nframes_per_level = 100000\n", "6100000 steps", "big.toml:6:20, frames_per_level");
  check_refused(sweep + "step = 2\nframes_per_level = 30\nrepeats = 1000\n", "1830000 steps", "big.toml:7:11, repeats");
  const std::string random = "[random]\nseed = 1\nreversals = 9999\nlow = 0\nhigh = 60\n";
  check_refused(kHead + "step = 0.01\n" + random, "steps", "step");
  check_refused(kHead + "step = 1e-9\n" + random, "60000000000 steps", "random.high");
  const std::string press = kPressHead + "repeats = 1000\n[press]\nobject = \"ring\"\nforces_n = [1, 2, 3]\n";
  check_refused(press + "[press.grid]\nx = [0, 9, 1e-9]\ny = [0, 1, 1]\n", "9000000001", "press.grid.x");
  check_refused(press + "[press.grid]\nx = [0, 99, 1]\ny = [0, 99, 1]\n", "10000 positions", "press.grid");
}

TEST_CASE("recipe size: values set on the command line have the same limit") {
  const std::string body = kHead + "turning_points = [0, 60, 0]\nstep = 2\n";
  check_refused(body, "1200001 steps", "--set recipe.step (over big.toml)", {{"step", "1e-4"}});
  check_refused(body, "steps", "--set recipe.frames_per_level (over big.toml)", {{"frames_per_level", "99999"}});
}

// Every number and word of a recipe: what it is by default, and that its bounds are allowed and nothing beyond them.

namespace {

// The next double outward; of 0 a tiny one that is not subnormal, which a reader of text may drop.
double below(double bound) { return bound == 0.0 ? -1e-300 : std::nextafter(bound, -HUGE_VAL); }
double above(double bound) { return bound == 0.0 ? 1e-300 : std::nextafter(bound, HUGE_VAL); }

struct Bound {
  std::string table;  // empty: the root
  std::string key;
  double low, high;
  bool whole = false;
  std::string more = {};  // what else the table needs
};

const std::string kLevelsHead = "schema = 1\nname = \"t\"\nunit = \"psi\"\nturning_points = [0, 2]\nstep = 2\n";
const std::string kTouchHead = "schema = 1\nname = \"t\"\nkind = \"press\"\n";
const std::string kTouch = "[press]\nobject = \"ring\"\nforces_n = [20]\npositions_mm = [[1, 1]]\n";

bool accepted(const std::string& text) {
  try {
    (void)parse_recipe(TomlDocument::from_text(text, "b.toml"));
    return true;
  } catch (const FileError& error) {
    CHECK(error.id() == "TB-FILE-VALUE");
    return false;
  }
}

std::string text_with(const std::string& head, const std::string& press, const Bound& bound, double value) {
  const std::string line = fmt::format("{} = {}\n", bound.key, value);
  if (bound.table.empty()) return head + bound.more + line + press;
  if (bound.table == "press") return head + press + bound.more + line;
  return head + press + "[" + bound.table + "]\n" + bound.more + line;
}

void check_bounds(const std::string& head, const std::string& press, const std::vector<Bound>& bounds) {
  for (const Bound& bound : bounds) {
    INFO(bound.table << " " << bound.key);
    const auto takes = [&](double value) { return accepted(text_with(head, press, bound, value)); };
    CHECK(takes(bound.low));
    CHECK(takes(bound.high));
    CHECK(!takes(bound.whole ? bound.low - 1.0 : below(bound.low)));
    CHECK(!takes(bound.whole ? bound.high + 1.0 : above(bound.high)));
  }
}

// What a document was asked for and had not, by key.
std::map<std::string, std::string> defaults_of(const std::string& text) {
  const TomlDocument document = TomlDocument::from_text(text, "b.toml");
  (void)parse_recipe(document);
  std::map<std::string, std::string> found;
  for (const Setting& setting : document.settings()) {
    if (setting.origin == "default") found[setting.key] = setting.value;
  }
  return found;
}

}  // namespace

TEST_CASE("levels recipe: numbers at their bounds are accepted, the next ones beyond are refused") {
  check_bounds(kLevelsHead, "",
               {{"", "dwell_s", 0, 86400},
                {"", "repeats", 1, 1000, true},
                {"", "frames_per_level", 1, 100'000, true},
                {"", "frame_interval_s", 0, 86400},
                {"", "rest_restart_s", 0, 1e9},
                {"conditioning", "cycles", 0, 100, true, "peak = 60\n"},
                {"conditioning", "least", 0, 100, true, "peak = 60\ncycles = 100\n"},
                {"conditioning", "change_percent", 0, 100},
                {"limits", "least_response_v", 0, 100},
                {"limits", "most_dead_taxels", -1, 1'000'000, true},
                {"guard", "tolerance_psi", 0, 100},
                {"guard", "redo", 0, 20, true},
                {"warm_up", "drift_percent_per_min", 1e-6, 100},
                {"warm_up", "at_most_s", 0, 86400},
                {"dwell", "tolerance_s", 0, 3600},
                {"retry", "frame", 0, 20, true},
                {"retry", "branch", 0, 20, true},
                {"timeout", "step_s", 0, 86400}});
  const std::string suspend = "[[suspend]]\nquantity = \"supply_bar\"\ntrip_below = 6\nresume_above = 6\n";
  check_bounds(kLevelsHead + suspend, "", {{"", "hold_s", 0, 86400}, {"", "timeout_s", 0, 604'800}});
}

TEST_CASE("recipe ramp: is absent, or from 0.01 to 1000 psi/s") {
  const auto ramp = [](const std::string& settle, double value) {
    return accepted(kLevelsHead + settle + fmt::format("ramp_psi_per_s = {}\n", value));
  };
  for (const std::string& settle : std::vector<std::string>{"", "settle = \"none\"\n"}) {
    CHECK(ramp(settle, 0.0) == settle.empty());
    CHECK(!ramp(settle, above(0.0)));
    CHECK(!ramp(settle, below(0.01)));
    CHECK(ramp(settle, 0.01));
    CHECK(ramp(settle, 1000.0));
    CHECK(!ramp(settle, above(1000.0)));
  }
}

TEST_CASE("press recipe: numbers at their bounds are accepted, the next ones beyond are refused") {
  check_bounds(kTouchHead, kTouch,
               {{"", "dwell_s", 0, 86400},
                {"press", "contact_n", 0.01, 10},
                {"press", "approach_mm_per_s", 0.001, 10},
                {"press", "servo_mm_per_s", 0.001, 10},
                {"press", "clear_mm", 0.01, 50},
                {"conditioning", "cycles", 0, 100, true},
                {"conditioning", "peak_n", 0.2, 1000},
                {"guard", "tolerance_n", 0, 100}});
}

TEST_CASE("recipe: schema 1, a name, a unit and a step are required") {
  for (const std::string& gone :
       std::vector<std::string>{"schema = 1\n", "step = 2\n", "name = \"t\"\n", "unit = \"psi\"\n"}) {
    std::string text = kLevelsHead;
    text.erase(text.find(gone), gone.size());
    CHECK_THROWS_AS(parse_recipe(TomlDocument::from_text(text, "b.toml")), FileError);
  }
  for (const char* schema : {"0", "2"}) {
    CHECK(!accepted("schema = " + std::string(schema) + kLevelsHead.substr(kLevelsHead.find('\n'))));
  }
  CHECK(!accepted("schema = 1\nname = \"\"\nunit = \"psi\"\nturning_points = [0, 2]\nstep = 2\n"));
  CHECK(!accepted("schema = 1\nname = \"t\"\nunit = \"psi\"\nturning_points = [0, 2]\nstep = -2\n"));
  CHECK(!accepted(kTouchHead));
}

TEST_CASE("levels recipe: has the expected defaults") {
  CHECK(defaults_of(kLevelsHead) == std::map<std::string, std::string>{{"title", "\"t\""},
                                                                       {"kind", "\"levels\""},
                                                                       {"settle", "\"band\""},
                                                                       {"dwell_s", "2"},
                                                                       {"ramp_psi_per_s", "0"},
                                                                       {"frames_per_level", "1"},
                                                                       {"frame_interval_s", "1"},
                                                                       {"frames_at", "\"levels\""},
                                                                       {"conditioning.cycles", "0"},
                                                                       {"conditioning.least", "0"},
                                                                       {"conditioning.change_percent", "0"},
                                                                       {"conditioning.peak", "0"},
                                                                       {"limits.least_response_v", "0"},
                                                                       {"limits.most_dead_taxels", "-1"},
                                                                       {"repeats", "1"},
                                                                       {"guard.tolerance_psi", "0.2"},
                                                                       {"guard.redo", "2"},
                                                                       {"guard.on_broken", "\"fail\""},
                                                                       {"warm_up.drift_percent_per_min", "0.1"},
                                                                       {"warm_up.at_most_s", "0"},
                                                                       {"dwell.tolerance_s", "0.25"},
                                                                       {"retry.frame", "1"},
                                                                       {"retry.branch", "0"},
                                                                       {"retry.verdict", "\"worst\""},
                                                                       {"timeout.step_s", "0"},
                                                                       {"prompt.before", "\"\""},
                                                                       {"rest_restart_s", "3600"}});
  const auto suspended = defaults_of(kLevelsHead +
                                     "[[suspend]]\nquantity = \"supply_bar\"\ntrip_below = 6\nresume_above = 6.5\n"
                                     "[conditioning]\ncycles = 3\npeak = 2\n[parameters.spare]\ndefault = 1\nlow = 1\n"
                                     "high = 1\n[dwell]\ntolerance_s = \"$spare\"\n");
  CHECK(suspended.at("suspend[0].hold_s") == "10");
  CHECK(suspended.at("suspend[0].timeout_s") == "3600");
  CHECK(suspended.at("conditioning.least") == "1");
  CHECK(suspended.at("parameters.spare.value") == "1");
  CHECK(suspended.at("parameters.spare.unit") == "\"\"");
  CHECK(suspended.at("parameters.spare.help") == "\"\"");
  CHECK(defaults_of(kLevelsHead + "settle = \"none\"\nramp_psi_per_s = 1\n").at("dwell_s") == "0");
}

TEST_CASE("press recipe: has the expected defaults, and reads each key that is given") {
  const auto found = defaults_of(kTouchHead + kTouch);
  const std::map<std::string, std::string> wanted = {{"dwell_s", "2"},
                                                     {"press.contact_n", "0.2"},
                                                     {"press.hold", "\"position\""},
                                                     {"press.approach_mm_per_s", "0.5"},
                                                     {"press.servo_mm_per_s", "0.05"},
                                                     {"press.clear_mm", "5"},
                                                     {"press.tare", "true"},
                                                     {"press.registers", "false"},
                                                     {"conditioning.cycles", "0"},
                                                     {"conditioning.peak_n", "20"},
                                                     {"guard.tolerance_n", "0.2"}};
  for (const auto& [key, value] : wanted) {
    INFO(key);
    REQUIRE(found.contains(key));
    CHECK(found.at(key) == value);
  }
  const Recipe recipe = parse_recipe(TomlDocument::from_text(kTouchHead + kTouch, "b.toml"));
  CHECK(
      (recipe.kind == RecipeKind::kPress && recipe.press.tare && !recipe.press.registers && !recipe.press.hold_force));
  const Recipe given = parse_recipe(TomlDocument::from_text(
      kTouchHead + "title = \"a ring\"\n" + kTouch +
          "contact_n = 0.3\nhold = \"force\"\ntare = false\nregisters = true\napproach_mm_per_s = 1.5\n"
          "servo_mm_per_s = 0.25\nclear_mm = 7\n[conditioning]\ncycles = 3\npeak_n = 9\n[guard]\ntolerance_n = 0.5\n",
      "b.toml"));
  CHECK((given.title == "a ring" && given.press.object == "ring" && given.press.contact_n == 0.3));
  CHECK((given.press.hold_force && !given.press.tare && given.press.registers));
  CHECK((given.press.approach_mm_per_s == 1.5 && given.press.servo_mm_per_s == 0.25 && given.press.clear_mm == 7.0));
  CHECK((given.conditioning.cycles == 3 && given.conditioning.least == 3 && given.conditioning.peak_n == 9.0));
  CHECK(given.guard.tolerance_n == 0.5);
}

namespace {

Recipe rules_of(const std::string& rules) {
  return parse_recipe(TomlDocument::from_text(
      "schema = 1\nname = \"t\"\nunit = \"kPa\"\nturning_points = [0, 60]\nstep = 2\n" + rules, "r.toml"));
}

}  // namespace

TEST_CASE("recipe: all rules of a run are read") {
  const Recipe given = rules_of(
      "rest_restart_s = 600\n"
      "[conditioning]\ncycles = 6\nleast = 2\nchange_percent = 0.5\npeak = 100\n"
      "[warm_up]\ndrift_percent_per_min = 0.05\nat_most_s = 900\n"
      "[guard]\ntolerance_psi = 0.3\nredo = 1\non_broken = \"flag\"\n"
      "[dwell]\ntolerance_s = 0.1\n"
      "[retry]\nframe = 3\nverdict = \"any\"\n"
      "[timeout]\nstep_s = 40\n"
      "[limits]\nleast_response_v = 0.2\nmost_dead_taxels = 8\n"
      "[prompt]\nbefore = \"ready?\"\n"
      "[[suspend]]\nquantity = \"supply_bar\"\ntrip_below = 6\nresume_above = 6.5\nhold_s = 5\ntimeout_s = 60\n"
      "[[suspend]]\nquantity = \"temperature_c\"\ntrip_above = 30\nresume_below = 28\n");
  CHECK(given.rest_restart_s == 600.0);
  CHECK((given.conditioning.cycles == 6 && given.conditioning.least == 2 && given.conditioning.change_percent == 0.5));
  CHECK(given.conditioning.peak.value() == Approx(14.503773773));  // of the recipe's unit
  CHECK((given.warm_up.drift_percent_per_min == 0.05 && given.warm_up.at_most_s == 900.0));
  // The guard's tolerance is in psi whatever the recipe's unit.
  CHECK((given.guard.tolerance.value() == 0.3 && given.guard.redo == 1 && !given.guard.fail_when_broken));
  CHECK(given.dwell_tolerance_s == 0.1);
  CHECK((given.retry.frame == 3 && given.retry.any_passes));
  CHECK(given.step_timeout_s == 40.0);
  CHECK((given.limits.least_response_v == 0.2 && given.limits.most_dead_taxels == 8));
  REQUIRE(given.suspend.size() == 2);
  CHECK((given.suspend[0].below && given.suspend[0].trip == 6.0 && given.suspend[0].resume == 6.5));
  CHECK((given.suspend[0].hold_s == 5.0 && given.suspend[0].timeout_s == 60.0));
  CHECK((!given.suspend[1].below && given.suspend[1].quantity == "temperature_c"));
  const auto steps = compile(given, 2);
  CHECK((steps[0].kind == StepKind::kPrompt && steps[0].text == "ready?" && steps[0].sequence == 2));
}
