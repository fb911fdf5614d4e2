// What fleet status and fleet migrate print and tell, with a server by script or none at all.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "db/fleet/local_runs.h"
#include "db/fleet/postgres.h"
#include "tests/bench/cli/fleet/fleet_verb.h"
#include "tests/db/store_example.h"

namespace tactbench::tests::postgres {

namespace {

// Two ended runs of three frames each, and one that has not ended.
struct StoreOfThree {
  StoreOfThree() {
    for (int i = 0; i < 2; ++i) store_example(store);
    (void)begin_example(store);
  }
  std::vector<db::fleet::LocalRun> ended_runs() const { return db::fleet::LocalRuns(path).ended_runs(); }
  TemporaryFolder folder;
  std::string path = folder.path("runs.db");
  db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
};

}  // namespace

TEST_CASE("fleet status: what waits by the server, in words and as JSON") {
  if (!db::fleet::built_with_libpq()) return;
  const StoreOfThree store;
  const std::vector<db::fleet::LocalRun> own = store.ended_runs();
  REQUIRE(own.size() == 2);
  const auto status = [&](const std::vector<std::vector<Field>>& there, const std::vector<std::vector<Field>>& origins,
                          std::vector<std::string> words) {
    std::vector<Answer> answers = of_this_schema();
    answers.emplace_back(rows(3, there));
    answers.emplace_back(rows(2, origins));
    words.insert(words.begin(), {"status", "--db", store.path});
    std::string where;
    Finished finished = fleet_verb(answers, words, &where);
    CHECK(finished.code == 0);
    if (finished.out.starts_with(where)) finished.out.replace(0, where.size(), "WHERE");
    return finished.out;
  };
  CHECK(status({}, {{"hardware", "3"}, {"simulated", "12"}}, {}) ==
        "WHERE: schema 2; runs of all benches: 3 hardware, 12 simulated\n" + store.path +
            ": 0 of 2 ended runs there; 2 runs with 6 frames waiting; tactbench fleet push sends it\n");
  const std::vector<Field> first = {own[0].uuid, own[0].content_sha256, own[0].fingerprint},
                           second = {own[1].uuid, own[1].content_sha256, "of before"},
                           other_content = {own[1].uuid, "of before", own[1].fingerprint};
  CHECK(status({first, second}, {}, {}) ==
        "WHERE: schema 2; runs of all benches: none\n" + store.path +
            ": 2 of 2 ended runs there; of 1 run something newer waits; tactbench fleet push sends it\n");
  CHECK(status({first, other_content}, {{"hardware", "1"}}, {}) ==
        "WHERE: schema 2; runs of all benches: 1 hardware\n" + store.path +
            ": 1 of 2 ended runs there; 1 run with 3 frames waiting; tactbench fleet push sends it\n");
  CHECK_THAT(status({first, {own[1].uuid, own[1].content_sha256, own[1].fingerprint}}, {}, {}),
             Catch::EndsWith(": 2 of 2 ended runs there; nothing waits\n"));
  const nlohmann::json told = nlohmann::json::parse(status({first, second}, {{"hardware", "1"}}, {"--json"}));
  CHECK(told.at("reached") == true);
  CHECK(told.at("by") == "server");
  CHECK(told.at("error") == "");
  CHECK(told.at("ended_runs") == 2);
  CHECK(told.at("waiting_runs") == 0);
  CHECK(told.at("waiting_frames") == 0);
  CHECK(told.at("waiting_remarks") == 1);
  CHECK(told.at("fleet_runs") == nlohmann::json::parse(R"({"hardware": 1})"));
  CHECK(nlohmann::json::parse(status({}, {}, {"--json"})).at("waiting_frames") == 6);
}

TEST_CASE("fleet status: without the server by the note beside the store, with exit code 3") {
  if (!db::fleet::built_with_libpq()) return;
  const StoreOfThree store;
  const std::vector<db::fleet::LocalRun> own = store.ended_runs();
  const TemporaryFolder nobody;
  const std::string to = "host=" + nobody.path() + " dbname=tactile", where = "tactile on " + nobody.path() + ":5432";
  const auto status = [&](const std::vector<std::string>& more = {}) {
    std::vector<std::string> words = {"fleet", "status", "--db", store.path, "--to", to};
    words.insert(words.end(), more.begin(), more.end());
    const Finished finished = verb_here(bench::add_fleet, words);
    CHECK(finished.code == 3);
    return finished.out;
  };
  const std::string keeps = store.path + " keeps everything; by the note beside it:\n" + store.path;
  const std::string all = status();
  CHECK_THAT(all,
             Catch::Contains(" [TB-FLEET-CONNECT]\n  try: ") &&
                 Catch::EndsWith(keeps + ": 0 of 2 ended runs there; 2 runs with 6 frames waiting; tactbench fleet "
                                         "push sends it\n"));
  db::fleet::PushedNote(store.path, where).keep(own[0], "2026-01-02T00:00:00Z");
  CHECK_THAT(status(), Catch::EndsWith(": 1 of 2 ended runs there; 1 run with 3 frames waiting; tactbench fleet push "
                                       "sends it\nlast pushed 2026-01-02T00:00:00Z\n"));
  db::fleet::PushedNote(store.path, where).keep(own[1], "2026-01-03T00:00:00Z");
  CHECK_THAT(status(), Catch::EndsWith(": 2 of 2 ended runs there; nothing waits\nlast pushed 2026-01-03T00:00:00Z\n"));
  db::RunStore::open(store.path).set_tags(1, {"later"}, {});
  CHECK_THAT(status(), Catch::Contains(": 2 of 2 ended runs there; of 1 run something newer waits; tactbench fleet "
                                       "push sends it\n"));
  const nlohmann::json told = nlohmann::json::parse(status({"--json"}));
  CHECK(told.at("fleet") == where);
  CHECK(told.at("reached") == false);
  CHECK(told.at("error") == "TB-FLEET-CONNECT");
  CHECK(told.at("by") == "note");
  CHECK(told.at("waiting_remarks") == 1);
  CHECK(told.at("waiting_runs") == 0);
  CHECK(told.at("last_push_utc") == "2026-01-03T00:00:00Z");
  CHECK_FALSE(told.contains("fleet_runs"));
  const TemporaryFolder folder;
  db::RunStore::open(folder.path("empty.db"), db::Durability::kNormal);
  CHECK_THAT(verb_here(bench::add_fleet, {"fleet", "status", "--db", folder.path("empty.db"), "--to", to}).out,
             Catch::EndsWith("empty.db: no run has ended yet\n"));
  const Finished nonsense = verb_here(bench::add_fleet, {"fleet", "status", "--db", store.path, "--to", "nonsense"});
  CHECK(nonsense.code == 2);
  CHECK_THAT(nonsense.err, Catch::Contains("[TB-FLEET-CONNINFO]"));
}

TEST_CASE("fleet migrate: a new fleet, one that is brought up to date, and one that is so already") {
  if (!db::fleet::built_with_libpq()) return;
  const auto migrate = [&](int before, const std::vector<std::string>& more) {
    std::vector<Answer> answers = {started(), ended("BEGIN"), rows(1, {{""}})};
    if (before == 0) {
      answers.emplace_back(rows(1, {{Field()}}));
    } else {
      answers.emplace_back(rows(1, {{"fleet.migrations"}}));
      answers.emplace_back(rows(1, {{std::to_string(before)}}));
    }
    for (int step = before; step < 2; ++step) {
      answers.emplace_back(ended("DONE"));
      answers.emplace_back(rows(0, {}));
    }
    answers.emplace_back(ended("COMMIT"));
    std::vector<std::string> words = {"migrate"};
    words.insert(words.end(), more.begin(), more.end());
    std::string where;
    Finished finished = fleet_verb(answers, words, &where);
    CHECK(finished.code == 0);
    if (finished.out.starts_with(where)) finished.out.replace(0, where.size(), "WHERE");
    return finished.out;
  };
  const std::string who = "; benches log in as members of role tactbench_bench, readers of tactbench_analyst\n";
  CHECK(migrate(0, {}) == "WHERE: made a fleet with schema 2" + who);
  CHECK(migrate(1, {}) == "WHERE: schema 1 migrated to 2" + who);
  CHECK(migrate(2, {}) == "WHERE: has schema 2 already\n");
  const nlohmann::json told = nlohmann::json::parse(migrate(1, {"--json"}));
  CHECK(told.at("schema_before") == 1);
  CHECK(told.at("schema_now") == 2);
  CHECK(told.at("schema") == "tactbench.fleet.migrate");
}

}  // namespace tactbench::tests::postgres
