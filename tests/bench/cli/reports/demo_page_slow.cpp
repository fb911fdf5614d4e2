// demo: what its five runs are made with, and a file of another kind that it leaves alone.
#include <catch2/catch.hpp>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "db/run_store.h"
#include "tests/bench/cli/check_refusal.h"
#include "tests/support/paths.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

struct DemoRunStored {
  std::int64_t seed = 0;
  std::vector<std::string> recipes;
  std::string settings;  // as key=value, with blanks between
  int frames = 0;
};

const std::vector<DemoRunStored>& runs_of_seed_three() {
  static const std::vector<std::string> table = {"descending", "ascending"};
  static const std::vector<DemoRunStored> runs = {
      {3, table, "", 3310},
      {4, table, "recipe.repeats=1 ", 662},
      {7, {"random-reversal"}, "", 463},
      {5, table, "recipe.repeats=1 simulation.mount_seed=1 simulation.effects.remount_variation=0.03 ", 662},
      {6, table,
       "recipe.repeats=1 simulation.temperature_c=28 simulation.age_months=1 "
       "simulation.effects.gain_drift_per_month=0.01 simulation.effects.zero_drift_v_per_month=0.01 ",
       662},
      {8,
       {"reversals", "held-presses", "small-reversals", "reversals", "held-presses", "small-reversals", "reversals",
        "held-presses", "small-reversals", "reversals", "held-presses"},
       "recipe.dwell_s=2 ",
       571}};
  return runs;
}

}  // namespace

TEST_CASE("demo: six runs, each with its seeds, recipes, settings and frames") {
  const TemporaryFolder folder;
  write_file(folder.path("mine.txt"), "a letter\n");
  const Finished refused = call(folder, {"demo", "-o", "mine.txt"});
  CHECK(refused.code == 2);
  CHECK(refused.out.empty());
  CHECK_FALSE(std::filesystem::exists(folder.path("runs.db")));
  well(call(folder,
            {"demo", "-q", "--timing", "--model", "elam", "--seed", "3", "--sensor-seed", "2", "-o", "demo.html"}));
  const std::vector<DemoRunStored>& runs = runs_of_seed_three();
  const db::RunStore store = db::RunStore::open_read_only(folder.path("runs.db"));
  for (std::size_t i = 0; i < runs.size(); ++i) {
    INFO(i);
    const db::RunRecord run = store.run(static_cast<std::int64_t>(i + 1));
    CHECK(run.seed == runs[i].seed);
    CHECK(run.sensor_seed == 2);
    CHECK(run.operator_name == "demo");
    CHECK(store.frame_count(run.run) == runs[i].frames);
    CHECK(run.sensor_serial == "SIM-0002");
    std::vector<std::string> recipes;
    for (const db::SequenceRecord& sequence : run.sequences) recipes.push_back(sequence.name);
    CHECK(recipes == runs[i].recipes);
    std::string settings;
    for (const auto& one : nlohmann::json::parse(run.overrides_json))
      settings += one.at("key").get<std::string>() + "=" + one.at("value").get<std::string>() + " ";
    CHECK(settings == runs[i].settings);
  }
  const auto sensor = store.sensor("SIM-0002");
  REQUIRE(sensor);
  CHECK(store.verdicts(5).size() == 10);
  CHECK(store.subjects() == std::vector<std::string>{"sensor/SIM-0002/descending+ascending"});
  // What its report prints is recomputed from its data by a script that knows none of the program.
  (void)call(folder, {"report", "1", "-o", "page.html"});
  (void)call(folder, {"report", "1", "--format", "json", "-o", "page.json"});
  const Finished recomputed = run_program(
      "/usr/bin/python3",
      {source_path("tests/analysis/pages/recompute.py"), folder.path("page.html"), folder.path("page.json")},
      folder.path());
  INFO(recomputed.out << recomputed.err);
  CHECK(recomputed.code == 0);
}
