// Every number and word of a recipe: what it is by default, and that its bounds are allowed and nothing beyond them.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "sequences/recipe.h"

using namespace tactbench::sequences;

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
