#include "db/schema.h"

#include <catch2/catch.hpp>

#include "db/sqlite.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::RunStore;
using db::sqlite::Access;
using db::sqlite::Connection;

TEST_CASE("a new store is ours, of version 1, in WAL with pages of 4096") {
  const TemporaryFolder folder;
  RunStore::open(folder.path("runs.db"));
  Connection raw(folder.path("runs.db"), Access::kReadWrite);
  CHECK(raw.integer("PRAGMA application_id") == db::kApplicationId);
  CHECK(raw.integer("PRAGMA user_version") == db::kSchemaVersion);
  CHECK(raw.text("PRAGMA journal_mode") == "wal");
  CHECK(raw.integer("PRAGMA page_size") == 4096);
  CHECK(raw.integer("PRAGMA wal_autocheckpoint") == 1000);
  CHECK(raw.text("PRAGMA integrity_check") == "ok");
}

TEST_CASE("every table is STRICT, and a text in a column of numbers is refused") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  const std::int64_t run = store_example(store);
  Connection raw(folder.path("runs.db"), Access::kReadWrite);
  CHECK(raw.integer("SELECT count(*) FROM pragma_table_list WHERE type = 'table' AND NOT strict "
                    "AND name NOT LIKE 'sqlite_%'") == 0);
  CHECK(raw.integer("SELECT count(*) FROM pragma_table_list WHERE type = 'table' AND strict") == 10);
  CHECK(store_error([&] { raw.execute("UPDATE frames SET setpoint_psi = 'two'"); }) == "TB-STORE-CONFLICT");
  CHECK(store_error([&] { raw.execute("UPDATE runs SET outcome = 'done'"); }) == "TB-STORE-CONFLICT");
  CHECK(store_error([&] { raw.execute("UPDATE runs SET outcome = 'incomplete'"); }) == "TB-STORE-CONFLICT");
  CHECK(store_error([&] { raw.execute("UPDATE runs SET safe_state = 'fine'"); }) == "TB-STORE-CONFLICT");
  CHECK(store_error([&] { raw.execute("UPDATE frames SET dtype = 'float64le'"); }) == "TB-STORE-CONFLICT");
  CHECK(store_error([&] { raw.execute("UPDATE frames SET counts = x'0011'"); }) == "TB-STORE-CONFLICT");
  db::VerdictRecord verdict;
  verdict.verdict = "passed";
  CHECK(store_error([&] { store.replace_verdicts(run, 0, {verdict}); }) == "TB-STORE-CONFLICT");
  for (const char* word : {"pass", "conditional pass", "conditional fail", "fail", "inconclusive"}) {
    verdict.verdict = word;
    CHECK(store_error([&] { store.replace_verdicts(run, 0, {verdict}); }).empty());
  }
}

TEST_CASE("foreign keys hold") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  const Begun begun = begin_example(store);
  store.append_frame(begun.run, example_frame(begun.branch, 0));
  Connection raw(folder.path("runs.db"), Access::kReadWrite);
  CHECK(store_error([&] { raw.execute("DELETE FROM runs"); }) == "TB-STORE-CONFLICT");
  CHECK(store_error([&] { raw.execute("DELETE FROM branches"); }) == "TB-STORE-CONFLICT");
  CHECK(store_error([&] { raw.execute("DELETE FROM sensors"); }) == "TB-STORE-CONFLICT");
  db::BranchRecord no_sequence = example_branch();
  no_sequence.sequence = 9;
  CHECK(store_error([&] { store.begin_branch(begun.run, no_sequence); }) == "TB-STORE-CONFLICT");
  CHECK(store_error([&] { store.begin_branch(begun.run, example_branch()); }) ==
        "TB-STORE-CONFLICT");  // attempt 0 twice
  CHECK(raw.integer("SELECT count(*) FROM pragma_foreign_key_check") == 0);
}

TEST_CASE("the views show what a person asks for") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  store_example(store);
  const std::int64_t run = store_example(store);
  db::VerdictRecord verdict;
  verdict.verdict = "fail";
  verdict.unit = std::string("%");  // GCC 12 warns wrongly at a plain literal
  verdict.value = 1.75;
  verdict.limit = 1.5;
  store.replace_verdicts(run, 0, {verdict});
  Connection raw(folder.path("runs.db"), Access::kReadOnly);
  CHECK(raw.integer("SELECT frames FROM v_runs WHERE run = 2 AND recipes = 'up, down' AND tags = '' AND notes = ''") ==
        3);
  CHECK(raw.integer("SELECT count(*) FROM v_frames WHERE run = 2") == 3);
  CHECK(raw.integer("SELECT count(*) FROM v_frames WHERE run = 2 AND void") == 1);
  CHECK(raw.text("SELECT recipe || ' ' || position || ' ' || step || ' ' || setpoint_psi FROM v_frames "
                 "WHERE run = 2 AND position = 3") == "down 3 1 2.0");
  CHECK(raw.integer("SELECT count(*) FROM pragma_table_info('v_frames') WHERE name = 'counts'") == 0);
  CHECK(raw.text("SELECT value || ' ' || unit || ' > ' || limit_value FROM v_verdicts WHERE run = 2") ==
        "1.75 % > 1.5");
  CHECK(raw.integer("SELECT count(*) FROM v_frames WHERE run = 3") == 0);
  // The frames of a run are found by key, not by reading all frames.
  db::sqlite::Statement plan(raw, "EXPLAIN QUERY PLAN SELECT * FROM v_frames WHERE run = 2");
  std::string steps;
  while (plan.step()) {
    int id = 0, parent = 0, unused = 0;
    std::string detail;
    plan.read(id, parent, unused, detail);
    steps += detail + "\n";
  }
  CHECK_THAT(steps, Catch::Contains("SEARCH f USING INTEGER PRIMARY KEY") && !Catch::Contains("SCAN"));
}
