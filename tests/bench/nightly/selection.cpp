// Which scenarios a night carries out: one alone, with other seeds, in parts; and scenarios that are none.
#include <catch2/catch.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/common/error.h"
#include "bench/nightly/scenario.h"
#include "bench/nightly/suite.h"
#include "db/run_store.h"
#include "tests/bench/config/bench_text.h"
#include "tests/support/process.h"
#include "tests/support/refusal.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;

namespace {

Suite suite_of_three() {
  return parse_suite(
      "schema = 1\nname = \"s\"\n[[scenario]]\nname = \"a\"\nabout = \"\"\nseed = 5\n[[scenario]]\nname = \"b\"\n"
      "about = \"\"\n[[scenario]]\nname = \"c\"\nabout = \"\"\nseed = 9\n",
      "three.toml");
}

std::string labels(const Suite& suite) {
  std::string text;
  for (const Scenario& scenario : suite.scenarios)
    text += (text.empty() ? "" : " ") + scenario.label + "=" + std::to_string(scenario.seed);
  return text;
}

}  // namespace

TEST_CASE("a night's choice: all, one alone, two in the suite's order, one seed for all, several seeds") {
  CHECK(labels(selected(suite_of_three(), {})) == "a=5 b=1 c=9");
  CHECK(labels(selected(suite_of_three(), {.only = {"b"}, .seed = std::nullopt, .seeds = 1})) == "b=1");
  CHECK(labels(selected(suite_of_three(), {.only = {"c", "a", "c"}, .seed = std::nullopt, .seeds = 1})) == "a=5 c=9");
  CHECK(labels(selected(suite_of_three(), {.only = {}, .seed = 7, .seeds = 1})) == "a=7 b=7 c=7");
  CHECK(labels(selected(suite_of_three(), {.only = {"c"}, .seed = 0, .seeds = 2})) == "c-seed-0=0 c-seed-1=1");
  const auto none = refusal_by([] {
    (void)selected(suite_of_three(), {.only = {"a", "d"}, .seed = std::nullopt, .seeds = 1});
  });
  REQUIRE(none);
  CHECK((none->id() == "TB-NIGHTLY-SCENARIO" && none->code() == ExitCode::kUsage && none->where() == "three.toml"));
}

TEST_CASE("a night's choice as JSON, there and back") {
  CHECK(to_json(Selection{}) == "{\"only\":[],\"seed\":null,\"seeds\":1}");
  CHECK(to_json(Selection{{"x", "y"}, 12, 3}) == "{\"only\":[\"x\",\"y\"],\"seed\":12,\"seeds\":3}");
  const Selection none = selection_from_json("{\"only\":[],\"seed\":null,\"seeds\":1}");
  CHECK((none.only.empty() && !none.seed && none.seeds == 1));
  const Selection all = selection_from_json("{\"only\":[\"x\"],\"seed\":12,\"seeds\":3}");
  CHECK((all.only == std::vector<std::string>{"x"} && all.seed == 12U && all.seeds == 3));
  for (const char* wrong : {"", "{}", "{\"only\":[],\"seeds\":1}", "{\"only\":\"x\",\"seed\":null,\"seeds\":1}"})
    CHECK_THROWS(selection_from_json(wrong));
}

TEST_CASE("parts of a night take its scenarios in turn, in their order") {
  const Suite whole = selected(suite_of_three(), {.only = {}, .seed = std::nullopt, .seeds = 2});
  CHECK(labels(part_of(whole, {1, 2})) == "a-seed-5=5 b-seed-1=1 c-seed-9=9");
  CHECK(labels(part_of(whole, {2, 2})) == "a-seed-6=6 b-seed-2=2 c-seed-10=10");
  CHECK(labels(part_of(whole, {1, 1})) == labels(whole));
  CHECK(part_of(whole, {3, 4}).name == "s");
}

TEST_CASE("a scenario on a bench that is not simulated is refused before anything is touched") {
  const TemporaryFolder folder;
  Scenario scenario = suite_of_three().scenarios[0];
  scenario.bench = folder.path("rig.toml");
  write_file(scenario.bench, bench_text("hardware"));
  const auto refused = refusal_by([&] { (void)carry_out(scenario, folder.path("n.db")); });
  REQUIRE(refused);
  CHECK((refused->id() == "TB-NIGHTLY-BENCH" && refused->code() == ExitCode::kUsage));
  CHECK_THAT(refused->where(), Catch::EndsWith(scenario.bench));
}

TEST_CASE("the store of a scenario has the night's specimen and its runs alone, without tags and notes") {
  const TemporaryFolder folder;
  const std::string path = folder.path("n.db");
  CHECK_FALSE(is_scenario_store(path));
  write_file(folder.path("text"), "no store");
  CHECK_FALSE(is_scenario_store(folder.path("text")));
  db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
  CHECK(is_scenario_store(path));  // broken off before its specimen
  store.add_sensor({"SIM-0001", "t", "", db::sha256_hex(""), "", "simulated array of the nightly suite", ""});
  db::RunRecord run;
  run.uuid = db::new_uuid();
  run.origin = "simulated";
  run.state = "prepared";
  run.sensor_serial = "SIM-0001";
  run.operator_name = "nightly";
  run.sequences = {{0, "s", "", "", 1, 1}};
  const std::int64_t first = store.begin_run(run);
  CHECK(is_scenario_store(path));
  store.set_tags(first, {"kept"}, {});
  CHECK_FALSE(is_scenario_store(path));
  store.set_tags(first, {}, {"kept"});
  CHECK(is_scenario_store(path));
  store.end_run(first, db::Outcome::kCompleted, "", db::SafeState::kVerified, "2026-01-01T00:00:00Z");
  run.uuid = db::new_uuid();
  run.operator_name = "K. Lee";
  (void)store.begin_run(run);
  CHECK_FALSE(is_scenario_store(path));
  db::RunStore other = db::RunStore::open(folder.path("other.db"), db::Durability::kNormal);
  other.add_sensor({"S-1", "t", "", db::sha256_hex(""), "", "mine", ""});
  CHECK_FALSE(is_scenario_store(folder.path("other.db")));
}
