// rig check: its document, each state of rig and standard with the conclusion of both, and its exit codes;
// held against baselines that are written into the store.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;
using Told = nlohmann::ordered_json;

namespace {

// In deviations of a baseline: the figures of a check lie in its middle, far within its band, or beyond it. The first
// value after a baseline's mean counts a fifth in the moving average.
enum class PlaceInBand { kWithin, kShifted, kOutside };

class CheckedRig {
 public:
  CheckedRig() {
    write_file(folder.path("small.toml"),
               "schema = 1\nname = \"small\"\nunit = \"psi\"\nturning_points = [0, 60, 20, 60, 0]\nstep = 20\n"
               "repeats = 1\ndwell_s = 1.0\n");
    REQUIRE(call(folder, {"sensors", "add", "STD-1", "--type", "sensor.toml"}).code == 0);
  }
  // With seeds of its own each time.
  Finished check(const std::vector<std::string>& more = {}) {
    std::vector<std::string> words = {"rig",        "check",
                                      "--bench",    "simulated.toml",
                                      "--standard", "STD-1",
                                      "--operator", "t",
                                      "--recipe",   "small.toml",
                                      "-q",         "--yes",
                                      "--seed",     std::to_string(++seed_)};
    words.insert(words.end(), more.begin(), more.end());
    return call(folder, words);
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

TEST_CASE("rig check: what is concluded of rig and standard together") {
  CheckedRig rig;
  const Told first = Told::parse(rig.check({"--press", "--json"}).out);
  CHECK(first.at("schema") == "tactbench.rig.check");
  CHECK(first.at("bench") == "simulated-rig");
  CHECK(first.at("origin") == "simulated");
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
        "rig check: force and stage");
  const auto accept = [&](std::size_t subject, PlaceInBand place) {
    rig.accept(subjects[subject], checks.at(subject).at("figures"), place);
  };
  const auto concluded = [&](const std::vector<std::string>& words, int code, const std::string& states,
                             const std::string& said) {
    const Finished done = rig.check(words);
    const Told told = Told::parse(done.out);
    CHECK(done.code == code);
    std::string found;
    for (const Told& one : told.at("checks")) found += one.at("state").get<std::string>() + ", ";
    CHECK(found == states);
    CHECK_THAT(told.at("conclusion").get<std::string>(), Catch::StartsWith(said));
  };
  accept(0, PlaceInBand::kWithin);
  concluded({"--json"}, 0, "within, no baseline, ", "not judged: ");
  accept(2, PlaceInBand::kWithin);
  concluded({"--json"}, 0, "within, within, ", "rig and standard are unchanged");
  accept(1, PlaceInBand::kOutside);
  concluded({"--json"}, 0, "within, within, ", "rig and standard are unchanged");  // nothing was pressed
  concluded({"--json", "--press"}, 1, "within, outside, within, ", "the rig changed, the standard's figures did not");
  accept(1, PlaceInBand::kWithin);
  accept(0, PlaceInBand::kShifted);
  concluded({"--json", "--press"}, 6, "shifted, within, within, ", "the rig changed, the standard's figures did not");
  accept(2, PlaceInBand::kShifted);
  concluded({"--json"}, 6, "shifted, shifted, ", "the rig changed, and the standard's figures with it");
  accept(0, PlaceInBand::kWithin);
  concluded({"--json"}, 6, "within, shifted, ", "the standard changed on an unchanged rig");
  accept(2, PlaceInBand::kOutside);
  CHECK(rig.check().code == 1);
  accept(0, PlaceInBand::kShifted);
  concluded({"--json"}, 1, "shifted, outside, ", "the rig changed, and the standard's figures with it");
}
