// The verb plan as a person uses it: no device is there.

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "bench/run/recipe_check.h"
#include "sequences/recipe.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/db/store_example.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"
#include "tests/support/run_recipe.h"
#include "tests/support/text.h"

using namespace tactbench;
using namespace tactbench::tests;
using Told = nlohmann::ordered_json;
using nlohmann::json;

TEST_CASE("plan: lists the same steps as the compiler") {
  const TemporaryFolder folder;
  for (const std::vector<std::string>& names :
       std::vector<std::vector<std::string>>{{"production", "ring"}, {"rate-ramp"}, {"random-reversal"}}) {
    std::vector<std::string> words = joined({"plan", "--steps"}, names);
    std::string lines;
    const auto steps = sequences::compile(bench::read_recipes(names));
    for (const sequences::Step& step : steps) lines += step_line(step) + "\n";
    const Finished text = call(folder, words);
    CHECK(text.code == 0);
    CHECK(text.out.ends_with(lines));
    words.emplace_back("--json");
    const json list = json::parse(call(folder, words).out)["step_list"];
    REQUIRE(list.size() == steps.size());
    for (std::size_t i = 0; i < steps.size(); ++i) CHECK(list[i]["line"] == step_line(steps[i]));
  }
}

TEST_CASE("plan: lists the shipped recipes, and rejects an unknown name") {
  const TemporaryFolder folder;
  CHECK(call(folder, {"plan"}).code == 0);
  std::set<std::string> names, shipped;
  const json listed = json::parse(call(folder, {"plan", "--json"}).out);
  for (const json& recipe : listed["recipes"]) names.insert(recipe["name"].get<std::string>());
  for (const auto& entry : std::filesystem::directory_iterator(source_path("sequences")))
    if (entry.path().extension() == ".toml" && entry.path().stem() != "nightly") shipped.insert(entry.path().stem());
  CHECK(names == shipped);
  CHECK(call(folder, {"plan", "produktion"}).code == 2);
  CHECK(call(folder, {"run", "produktion", "--bench", "simulated.toml", "--sensor", "S", "--operator", "o"}).code == 2);
}

TEST_CASE("plan: rejects a step size that would exhaust memory") {
  const TemporaryFolder folder;
  CHECK(call(folder, {"plan", "noise", "--set", "recipe.step=0.00001"}).code == 2);
}

// devices test: its document, each state of rig and standard with the conclusion of both, and its exit codes;
// held against baselines that are written into the store.

namespace {

// In deviations of a baseline: the figures of a check lie in its middle, far within its band, or beyond it. The first
// value after a baseline's mean counts a fifth in the moving average.
enum class PlaceInBand { kWithin, kShifted, kOutside };

class CheckedRig {
 public:
  CheckedRig() {
    write_file(folder.path("small.toml"), small_loop_text());
    REQUIRE(call(folder, {"sensors", "add", "STD-1", "--type", "sensor.toml"}).code == 0);
  }
  // With seeds of its own each time.
  Finished check(const std::vector<std::string>& more = {}) {
    return call(folder, joined({"devices", "test", "--bench", "simulated.toml", "--standard", "STD-1", "--operator",
                                "t", "--recipe", "small.toml", "-q", "--yes", "--seed", std::to_string(++seed_)},
                               more));
  }
  // Accepts eight runs as the subject's baseline, so that these figures lie at this place of it.
  void accept(const std::string& subject, const Told& figures, PlaceInBand place) {
    const double away = place == PlaceInBand::kWithin ? 0.0 : place == PlaceInBand::kShifted ? 10.0 : 100.0;
    db::RunStore store = db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
    db::BaselineRecord baseline{0, subject, "as built", "K. Lee", kUtc, {}};
    for (int i = 0; i < 8; ++i) {
      db::RunRecord run = example_run();
      run.seed = ++seed_ + 1000;
      const std::int64_t number = begin_example(store, run).run;
      store.end_run(number, db::Outcome::kCompleted, "", db::SafeState::kVerified, kUtc);
      std::map<std::string, double> own;
      for (const auto& [name, value] : figures.items()) {
        const double spread = 0.5 * std::max(std::abs(value.get<double>()), 0.5) * (1.0 + 0.01 * i);  // none repeats
        own[name] = value.get<double>() - away * spread + (i % 2 == 0 ? spread : -spread);
      }
      store.replace_figures(number, subject, own);
      baseline.runs.push_back(number);
    }
    store.add_baseline(baseline);
  }
  TemporaryFolder folder;

 private:
  int seed_ = 0;
};

}  // namespace

TEST_CASE("devices test: states the result of rig and check standard together") {
  CheckedRig rig;
  const Told first = Told::parse(rig.check({"--press", "--json"}).out);
  check_members(first, R"({"schema": "tactbench.rig.check", "bench": "simulated-rig", "origin": "simulated"})");
  const Told checks = first.at("checks");
  REQUIRE(checks.size() == 3);
  const std::vector<std::string> what = {"chamber", "force and stage", "check standard"},
                                 subjects = {"rig/simulated-rig/chamber", "rig/simulated-rig/press",
                                             "sensor/STD-1/small"};
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(checks.at(i).at("what") == what[i]);
    CHECK(checks.at(i).at("subject") == subjects[i]);
    CHECK(checks.at(i).at("run") == (i == 0 ? 1 : i == 1 ? 3 : 2));
    CHECK(checks.at(i).at("state") == "no baseline");
    CHECK(checks.at(i).at("outside").empty());
    CHECK(checks.at(i).at("shifted").empty());
  }
  CHECK(checks.at(1).at("figures").size() == 4);
  CHECK(Told::parse(call(rig.folder, {"runs", "show", "3", "--json"}).out).at("purpose") ==
        "devices test: force and stage");
  const auto accept = [&](std::size_t subject, PlaceInBand place) {
    rig.accept(subjects[subject], checks.at(subject).at("figures"), place);
  };
  // What is concluded depends on whether rig and standard moved, and on nothing else.
  std::map<std::string, std::string> conclusions;
  const auto concluded = [&](const std::string& what_moved, int code, const std::string& states, bool press = false) {
    const Finished done =
        rig.check(press ? std::vector<std::string>{"--json", "--press"} : std::vector<std::string>{"--json"});
    const Told printed = Told::parse(well(done, code).out);
    std::string found;
    for (const Told& one : printed.at("checks")) found += one.at("state").get<std::string>() + ", ";
    CHECK(found == states);
    const std::string said = printed.at("conclusion");
    CHECK(conclusions.emplace(what_moved, said).first->second == said);
  };
  accept(0, PlaceInBand::kWithin);
  concluded("not judged", 0, "within, no baseline, ");
  accept(2, PlaceInBand::kWithin);
  concluded("nothing", 0, "within, within, ");
  accept(1, PlaceInBand::kOutside);
  concluded("nothing", 0, "within, within, ");  // nothing was pressed
  concluded("rig", 1, "within, outside, within, ", true);
  accept(1, PlaceInBand::kWithin);
  accept(0, PlaceInBand::kShifted);
  concluded("rig", 6, "shifted, within, within, ", true);
  accept(2, PlaceInBand::kShifted);
  concluded("both", 6, "shifted, shifted, ");
  accept(0, PlaceInBand::kWithin);
  concluded("standard", 6, "within, shifted, ");
  accept(2, PlaceInBand::kOutside);
  CHECK(rig.check().code == 1);
  accept(0, PlaceInBand::kShifted);
  concluded("both", 1, "shifted, outside, ");
  std::set<std::string> different;
  for (const auto& [moved, said] : conclusions) different.insert(said);
  CHECK(different.size() == 5);
}

// By eight checks as they are, and by faults of the rig and of the standard itself.
TEST_CASE("devices test: distinguishes a changed rig from a changed check standard") {
  const TemporaryFolder folder;
  REQUIRE(call(folder, {"sensors", "add", "STD-1", "--type", "sensor.toml"}).code == 0);
  // The state of the chamber and of the standard.
  const auto states = [&](const std::string& seed, int code, const std::vector<std::string>& more = {}) {
    const Told checks =
        Told::parse(
            well(call(folder, joined({"devices", "test", "--bench", "simulated.toml", "--standard", "STD-1",
                                      "--operator", "t", "--seed", seed, "--json", "-q", "--set", "recipe.repeats=2"},
                                     more)),
                 code)
                .out)
            .at("checks");
    REQUIRE(checks.size() == 2);
    return std::pair<std::string, std::string>(checks.at(0).at("state"), checks.at(1).at("state"));
  };
  for (const char* seed : {"1", "2", "3", "4", "5", "6", "7", "8"}) CHECK(states(seed, 0).first == "no baseline");
  well(call(folder, {"trend", "accept", "1-16", "--by", "K. Lee", "--reason", "after service"}));
  const std::pair<std::string, std::string> unchanged = {"within", "within"}, standard_changed = {"within", "outside"};
  CHECK(states("9", 0) == unchanged);
  const std::string chamber = states("10", 1, {"--set", "simulation.chamber.hysteresis_share=0.01"}).first;
  CHECK((chamber == "outside" || chamber == "shifted"));
  CHECK(states("11", 1, {"--set", R"(simulation.defect=[{kind="dead",row=3,column=4}])"}) == standard_changed);
  CHECK(call(folder, {"devices", "test", "--bench", "simulated.toml", "--standard", "none", "--operator", "t"}).code ==
        2);
}
