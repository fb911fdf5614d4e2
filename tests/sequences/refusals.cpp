// What a recipe is refused for: the error's id, its place, and the number or key that it is about.
#include <catch2/catch.hpp>

#include "sequences/recipe.h"
#include "tests/sequences/recipe_text.h"
#include "tests/sequences/refusal.h"

using namespace tactbench::sequences;

namespace {

const std::string kSweep = "turning_points = [0, 4]\nstep = 2\n";  // lines 4 and 5 of test.toml
const std::string kValue = "TB-FILE-VALUE";

void read_levels(const std::string& body) { (void)recipe_of(body); }

}  // namespace

TEST_CASE("refused: keys, texts, units and numbers that a recipe cannot have") {
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

TEST_CASE("refused: a press that cannot be made") {
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

TEST_CASE("refused: a grid that has no positions or too many") {
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

TEST_CASE("refused: a parameter that cannot be used") {
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

TEST_CASE("refused: an unknown key in every table") {
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
