#include "db/schema.h"

#include <catch2/catch.hpp>

#include <filesystem>

#include "db/sqlite.h"
#include "tests/db/store_example.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::RunStore;
using db::sqlite::Access;
using db::sqlite::Connection;

TEST_CASE("a new store has the application id, the newest version, WAL and pages of 4096") {
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
  CHECK(raw.integer("SELECT count(*) FROM pragma_table_list WHERE type = 'table' AND strict") == 20);
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

TEST_CASE("the views show runs, frames and verdicts with their units") {
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
  CHECK_THAT(steps, Catch::Contains("SEARCH f USING INTEGER PRIMARY KEY") && !Catch::Contains("SCAN f") &&
                        !Catch::Contains("SCAN b"));
}

TEST_CASE("a store of schema 1 is brought up to date, its rows and its hash unchanged") {
  const TemporaryFolder folder;
  std::filesystem::copy_file(source_path("tests/db/stores/version_1.db"), folder.path("runs.db"));
  CHECK(Connection(folder.path("runs.db"), Access::kReadOnly).integer("PRAGMA user_version") == 1);
  CHECK(store_error([&] { RunStore::open_read_only(folder.path("runs.db")); }) == "TB-STORE-OPEN");
  RunStore store = RunStore::open(folder.path("runs.db"));
  const db::RunRecord run = store.run(1);
  CHECK(run.content_sha256 == "c1d5c53a3d9d4d311d051e3dec523f53e1652af5c10fca4e466850a6c99f3dcf");
  CHECK(store.content_hash(1) == run.content_sha256);
  REQUIRE(store.frames(1).size() == 5);
  CHECK((store.frames(1)[4].trace.empty() && !store.frames(1)[4].wrench));
}

TEST_CASE("a store of schema 2 is brought up to date, its rows and its hash unchanged") {
  const TemporaryFolder folder;
  std::filesystem::copy_file(source_path("tests/db/stores/version_2.db"), folder.path("runs.db"));
  CHECK(Connection(folder.path("runs.db"), Access::kReadOnly).integer("PRAGMA user_version") == 2);
  RunStore store = RunStore::open(folder.path("runs.db"));
  const db::RunRecord run = store.run(1);
  CHECK(run.content_sha256 == "6f62f02b7f82b37ed237543a965bf54209635788a266a8ca9e8b04046790a952");
  CHECK(store.content_hash(1) == run.content_sha256);
  CHECK(store.frames(1).size() == 3);
  CHECK(store.series(1).empty());
}

TEST_CASE("a store of schema 3 is brought up to date, its rows and its hash unchanged") {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db"), kept = path + ".schema-3.backup";
  std::filesystem::copy_file(source_path("tests/db/stores/version_3.db"), path);
  CHECK(db::schema_version_of(path) == 3);
  RunStore store = RunStore::open(path);
  const db::RunRecord run = store.run(1);
  CHECK(run.content_sha256 == "e67589a8fdfa599ff5cf5b6145471804a2d0e07a99287af055796f3936cd0b23");
  CHECK(store.check_content(1).holds());
  CHECK(store.frames(1).size() == 11);
  CHECK(store.fit_taxels(1).size() == 257);
  CHECK(store.verdicts(1).size() == 8);
  CHECK((run.tags.empty() && run.notes.empty() && !run.is_void()));
  CHECK(store.check_structure().empty());
  CHECK(db::schema_version_of(path) == db::kSchemaVersion);
  CHECK(db::schema_version_of(kept) == 3);
  CHECK(Connection(kept, Access::kReadOnly).integer("SELECT count(*) FROM frames") == 11);
}

TEST_CASE("a store of schema 6 is opened, its rows, fits and verdicts as they were stored") {
  const TemporaryFolder folder;
  std::filesystem::copy_file(source_path("tests/db/stores/version_6.db"), folder.path("runs.db"));
  RunStore store = RunStore::open(folder.path("runs.db"));
  for (const std::int64_t run : {1, 2}) CHECK(store.check_content(run).holds());
  CHECK(store.run(1).content_sha256 == "886a1faf099e7a2baf6ded84c2b46dabf5132e6a754623e72480c52111683ce5");
  CHECK(store.frames(1).size() == 11);
  REQUIRE(store.fits(1).size() == 3);
  CHECK((store.fits(1)[0].model == "elam" && store.fit_taxels(1).size() == 257));
  CHECK((store.fits(1)[1].model == "gpi" && store.fit_taxels(2).empty()));
  CHECK(store.verdicts(2).size() == 4);
  CHECK(store.check_structure().empty());
}

TEST_CASE("a store of schema 7 is opened, its rows as they were stored, its frames all there") {
  const TemporaryFolder folder;
  std::filesystem::copy_file(source_path("tests/db/stores/version_7.db"), folder.path("runs.db"));
  RunStore store = RunStore::open(folder.path("runs.db"));
  for (const std::int64_t run : {1, 2}) {
    CHECK(store.check_content(run).holds());
    CHECK_FALSE(store.pruned(run));
  }
  CHECK(store.run(1).content_sha256 == "886a1faf099e7a2baf6ded84c2b46dabf5132e6a754623e72480c52111683ce5");
  CHECK(store.frames(1).size() == 11);
  CHECK(store.nights().empty());
  CHECK(store.check_structure().empty());
}

TEST_CASE("a store of schema 8 is opened, its signed reports without a reason and sealed as they were") {
  const TemporaryFolder folder;
  std::filesystem::copy_file(source_path("tests/db/stores/version_8.db"), folder.path("runs.db"));
  RunStore store = RunStore::open(folder.path("runs.db"));
  CHECK(store.check_content(1).holds());
  const std::vector<db::ReportRecord> reports = store.reports(1);
  REQUIRE(reports.size() == 2);
  CHECK((reports[1].replaces == reports[0].number && reports[0].reason.empty() && reports[1].reason.empty()));
  CHECK(Connection(store.path(), Access::kReadOnly)
            .integer("SELECT length(sha256) FROM seals WHERE run = 1 AND kind = 'approvals'") == 64);
  CHECK(store.check_seals(1).empty());
  CHECK(store.check_structure().empty());
  store.add_report({1, "1-ffffffff", "f", "K. Lee", kUtc, reports[1].number, "serial corrected"});
  CHECK(store.check_seals(1).empty());
}

TEST_CASE("a backup is made before each migration and never over another file") {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  std::filesystem::copy_file(source_path("tests/db/stores/version_2.db"), path);
  write_file(path + ".schema-2.backup", "mine");
  RunStore::open(path);
  CHECK(read_file(path + ".schema-2.backup") == "mine");
  CHECK(db::schema_version_of(path + ".schema-2.backup.2") == 2);
  RunStore::open(path);  // nothing to migrate
  RunStore::open(folder.path("new.db"));
  CHECK_FALSE(std::filesystem::exists(path + ".schema-2.backup.3"));
  CHECK_FALSE(std::filesystem::exists(folder.path("new.db.schema-0.backup")));
}

TEST_CASE("the series of an imported run read back bit for bit") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  db::RunRecord imported = example_run();
  imported.origin = "imported";
  const Begun begun = begin_example(store, imported);
  const std::vector<double> input = {0.0, 0.1, 1.0 / 3.0}, output = {-1e-300, 2.0 / 3.0, 1e300};
  store.append_series(begun.run, {{1, 0, input, output}, {0, 7, output, input}});
  CHECK(store_error([&] { store.append_series(begun.run, {{0, 7, input, output}}); }) == "TB-STORE-CONFLICT");
  CHECK(store_error([&] { store.append_series(begun.run, {{0, 8, input, {1.0}}}); }) == "TB-STORE-CONFLICT");
  store.end_run(begun.run, db::Outcome::kCompleted, "imported", db::SafeState::kUnknown, "");
  const std::vector<db::SeriesRecord> back = store.series(begun.run);
  REQUIRE(back.size() == 2);
  CHECK((back[0].sequence == 0 && back[0].taxel == 7 && back[0].input == output && back[0].output == input));
  CHECK((back[1].sequence == 1 && back[1].input == input && back[1].output == output));
  CHECK(store.content_hash(begun.run) == store.run(begun.run).content_sha256);
  CHECK(store_error([&] { store.append_series(begun.run, {{0, 9, input, output}}); }) == "TB-STORE-CONFLICT");
}

TEST_CASE("an ended run that was not completed can be opened again, and its chain continues") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  const Begun begun = begin_example(store);
  store.append_frame(begun.run, example_frame(begun.branch, 0));
  CHECK(store_error([&] { store.reopen_run(begun.run, {}); }) == "TB-STORE-CONFLICT");  // it is live
  REQUIRE(store.mark_interrupted("2026-01-01T00:00:00Z") == 1);
  store.reopen_run(begun.run, {9, "state", "", "ended -> prepared: resumed"});
  CHECK((store.run(begun.run).outcome == db::Outcome::kIncomplete && store.run(begun.run).content_sha256.empty()));
  store.append_frame(begun.run, example_frame(begun.branch, 1));
  CHECK(store.last_time_ns(begun.run) == example_frame(begun.branch, 1).time_ns);
  store.end_run(begun.run, db::Outcome::kCompleted, "all steps done", db::SafeState::kVerified, "");
  CHECK(store.content_hash(begun.run) == store.run(begun.run).content_sha256);
  CHECK(store.frame_count(begun.run) == 2);
  CHECK(store_error([&] { store.reopen_run(begun.run, {}); }) == "TB-STORE-CONFLICT");  // completed
}

TEST_CASE("a store of schema 4 is brought up to date, its rows and its hash unchanged") {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  std::filesystem::copy_file(source_path("tests/db/stores/version_4.db"), path);
  CHECK(db::schema_version_of(path) == 4);
  RunStore store = RunStore::open(path);
  const db::RunRecord run = store.run(1);
  CHECK(run.content_sha256 == "e35e54aacf36944bd3f63520ae74e6e2e4b99fe94a4a464525a638801bcbe68f");
  CHECK(store.check_content(1).holds());
  CHECK(store.frames(1).size() == 11);
  CHECK(store.fit_taxels(1).size() == 257);
  CHECK((run.tags == std::vector<std::string>{"kept"} && !run.notes.empty()));
  CHECK((store.figures("").empty() && store.baselines().empty() && store.reports(1).empty()));
  CHECK(store.check_structure().empty());
}

TEST_CASE("a store that became newer while its migration waited is refused, and keeps its version") {
  const TemporaryFolder folder;
  RunStore::open(folder.path("runs.db"));
  Connection raw(folder.path("runs.db"), Access::kReadWrite);
  const std::int64_t newer = db::kSchemaVersion + 1;
  raw.execute("PRAGMA user_version = " + std::to_string(newer));
  CHECK(store_error([&] { db::migrate(raw); }) == "TB-STORE-NEWER");
  CHECK(raw.integer("PRAGMA user_version") == newer);
}
