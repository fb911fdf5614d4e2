#include <sqlite3.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <filesystem>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "db/schema.h"
#include "db/sqlite.h"
#include "db/store_file.h"
#include "tests/db/store_example.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::db;
using namespace tactbench::tests;
using db::RunStore;
using db::sqlite::Access;
using db::sqlite::Connection;

TEST_CASE("store migration: a third backup also gets a name of its own") {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  CHECK(db::backup_path(path, 3) == path + ".schema-3.backup");
  write_file(path + ".schema-3.backup", "");
  CHECK(db::backup_path(path, 3) == path + ".schema-3.backup.2");
  write_file(path + ".schema-3.backup.2", "");
  CHECK(db::backup_path(path, 3) == path + ".schema-3.backup.3");
  CHECK(db::backup_path(path, 4) == path + ".schema-4.backup");
}

namespace {

// Makes the tables of a store just before another connection, `watched`, lists what there is in the same file.
struct MakesMeanwhile {
  std::string path;
  int made = 0, held_off = 0;
};

int make_before_listing(unsigned /*kind*/, void* context, void* /*statement*/, void* text) {
  if (std::string(static_cast<const char*>(text)).find("FROM main.sqlite_master") == std::string::npos) return 0;
  auto& maker = *static_cast<MakesMeanwhile*>(context);
  Connection other(maker.path, Access::kReadWrite, 0);
  ++(store_error([&] { db::migrate(other); }).empty() ? maker.made : maker.held_off);
  return 0;
}

}  // namespace

TEST_CASE("foreign objects: tables that another process creates during the check are not foreign") {
  const TemporaryFolder folder;
  MakesMeanwhile maker{folder.path("runs.db")};
  Connection watched(maker.path, Access::kReadWrite);
  REQUIRE(sqlite3_trace_v2(watched.handle(), SQLITE_TRACE_STMT, make_before_listing, &maker) == SQLITE_OK);
  const db::ForeignObjects found = db::foreign_objects(watched);
  CHECK((found.changed.empty() && found.added.empty()));
  CHECK(maker.made + maker.held_off == 1);
}

// Tables, indexes, views and triggers that tactbench did not make: reported, and never executed.

namespace {

struct Changed {
  std::string written, read;  // identifiers of the errors of opening for each
  std::string message;
  std::vector<std::string> structure;  // where reading is possible
};

// A store with one run after `sql` was carried out on it.
Changed changed_by(const std::string& sql) {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  {
    RunStore store = RunStore::open(path);
    store_example(store);
  }
  Connection(path, Access::kReadWrite).execute("PRAGMA foreign_keys = OFF; " + sql);
  const std::string before = read_file(path);
  Changed changed;
  changed.written = store_error([&] { RunStore::open(path); }, &changed.message);
  changed.read = store_error([&] {
    const RunStore store = RunStore::open_read_only(path);
    CHECK(store.check_content(1).holds());
    CHECK(store.frames(1).size() == 3);
    changed.structure = store.check_structure();
  });
  CHECK(read_file(path) == before);
  return changed;
}

}  // namespace

TEST_CASE("foreign objects: foreign triggers, tables, indexes and views are named, and the store is not written") {
  const auto refused = [](const std::string& sql, const std::string& named) {
    const Changed changed = changed_by(sql);
    INFO(sql);
    CHECK(changed.written == "TB-STORE-FOREIGN");
    CHECK_THAT(changed.message, Catch::Contains(named));
    CHECK(changed.read.empty());
    REQUIRE(changed.structure.size() == 1);
    CHECK_THAT(changed.structure.front(), Catch::Contains(named));
  };
  refused("CREATE TRIGGER evil AFTER INSERT ON runs BEGIN DELETE FROM verdicts; END", "'evil'");
  refused("CREATE TABLE mine (a)", "'mine'");
  refused("CREATE INDEX quick ON frames (time_ns)", "'quick'");
  refused("CREATE VIEW v_mine AS SELECT 1", "'v_mine'");
}

TEST_CASE("foreign objects: if a table, index or view of the store itself differs, reading is refused too") {
  const auto refused = [](const std::string& sql, const std::string& named) {
    const Changed changed = changed_by(sql);
    INFO(sql);
    CHECK(changed.written == "TB-STORE-OTHER-SCHEMA");
    CHECK(changed.read == "TB-STORE-OTHER-SCHEMA");
    CHECK_THAT(changed.message, Catch::Contains(named));
  };
  refused("DROP VIEW v_runs; CREATE VIEW v_runs AS SELECT 1 AS run", "'v_runs'");
  refused("DROP INDEX verdicts_of_run", "'verdicts_of_run'");
  refused(
      "DROP VIEW v_frames; DROP VIEW v_runs; DROP TABLE frames; CREATE VIEW frames AS WITH RECURSIVE c (frame) AS "
      "(SELECT 1 UNION ALL SELECT frame + 1 FROM c) SELECT frame FROM c",
      "'frames'");
  refused("ALTER TABLE verdicts ADD COLUMN more TEXT", "'verdicts'");
}

TEST_CASE("foreign objects: SQLite's own statistics are not foreign") {
  const Changed changed = changed_by("ANALYZE");
  CHECK((changed.written.empty() && changed.read.empty() && changed.structure.empty()));
}

TEST_CASE("foreign objects: no trigger runs and no view is read on an untrusted schema") {
  const TemporaryFolder folder;
  Connection connection(folder.path("any.db"), Access::kReadWrite);
  connection.execute(
      "CREATE TABLE a (x); CREATE TABLE b (x); CREATE VIEW c AS SELECT x FROM a; "
      "CREATE TRIGGER t AFTER INSERT ON a BEGIN INSERT INTO b VALUES (1); END");
  connection.disable_triggers_and_views();
  connection.execute("INSERT INTO a VALUES (7)");
  CHECK(connection.integer("SELECT count(*) FROM b") == 0);
  CHECK_FALSE(store_error([&] { (void)connection.integer("SELECT x FROM c"); }).empty());
}

TEST_CASE("store schema: a new store has the application id, the newest version, WAL and pages of 4096 bytes") {
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

TEST_CASE("store schema: every table is STRICT, and invalid values are refused") {
  NewStore store;
  const std::int64_t run = store_example(store);
  Connection raw(store.path(), Access::kReadWrite);
  CHECK(raw.integer("SELECT count(*) FROM pragma_table_list WHERE type = 'table' AND NOT strict "
                    "AND name NOT LIKE 'sqlite_%'") == 0);
  CHECK(raw.integer("SELECT count(*) FROM pragma_table_list WHERE type = 'table' AND strict") == 19);
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

TEST_CASE("store schema: foreign keys are enforced") {
  NewStore store;
  const Begun begun = begin_example(store);
  store.append_frame(begun.run, example_frame(begun.branch, 0));
  Connection raw(store.path(), Access::kReadWrite);
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

TEST_CASE("store schema: the views show runs, frames and verdicts with their units") {
  NewStore store;
  store_example(store);
  const std::int64_t run = store_example(store);
  db::VerdictRecord verdict;
  verdict.verdict = "fail";
  verdict.unit = std::string("FS");  // GCC 12 warns wrongly at a plain literal
  verdict.value = 1.75;
  verdict.limit = 1.5;
  store.replace_verdicts(run, 0, {verdict});
  Connection raw(store.path(), Access::kReadOnly);
  CHECK(raw.integer("SELECT frames FROM v_runs WHERE run = 2 AND recipes = 'up, down' AND tags = '' AND notes = ''") ==
        3);
  CHECK(raw.integer("SELECT count(*) FROM v_frames WHERE run = 2") == 3);
  CHECK(raw.integer("SELECT count(*) FROM v_frames WHERE run = 2 AND void") == 1);
  CHECK(raw.text("SELECT recipe || ' ' || position || ' ' || step || ' ' || setpoint_psi FROM v_frames "
                 "WHERE run = 2 AND position = 3") == "down 3 1 2.0");
  CHECK(raw.text("SELECT value || ' ' || unit || ' > ' || limit_value FROM v_verdicts WHERE run = 2") ==
        "1.75 FS > 1.5");
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

namespace {

// A later version: one more column, with the value that held before.
const db::Migrations& with_second_schema() {
  static const db::Migrations both = {db::schema_1(),
                                      "ALTER TABLE runs ADD COLUMN weather TEXT NOT NULL DEFAULT 'not recorded'"};
  return both;
}

}  // namespace

TEST_CASE("store migration: keeps a backup, rows and hashes, and the newer schema is then refused by this program") {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db"), kept = path + ".schema-1.backup.2";
  write_file(path + ".schema-1.backup", "mine");  // never written over
  std::string content;
  {
    RunStore store = RunStore::open(path);
    content = store.run(store_example(store)).content_sha256;
  }
  {
    Connection connection(path, Access::kReadWrite);
    db::migrate_store(connection, path, with_second_schema());
    CHECK(connection.integer("PRAGMA user_version") == 2);
    CHECK(connection.text("SELECT weather FROM runs") == "not recorded");
    CHECK(connection.text("SELECT content_sha256 FROM runs") == content);
    const db::ForeignObjects found = db::foreign_objects(connection, with_second_schema());
    CHECK((found.changed.empty() && found.added.empty()));
    db::migrate_store(connection, path, with_second_schema());  // nothing to do
  }
  CHECK(read_file(path + ".schema-1.backup") == "mine");
  CHECK_FALSE(std::filesystem::exists(path + ".schema-1.backup.3"));
  CHECK(RunStore::open_read_only(kept).check_content(1).holds());
  const std::string before = read_file(path);
  CHECK(store_error([&] { RunStore::open(path); }) == "TB-STORE-OTHER-SCHEMA");
  CHECK(store_error([&] { RunStore::open_read_only(path); }) == "TB-STORE-OTHER-SCHEMA");
  CHECK(read_file(path) == before);
}

TEST_CASE("store migration: a failed migration and a store of another schema leave the file unchanged") {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  {
    RunStore store = RunStore::open(path);
    store_example(store);
  }
  const std::string before = read_file(path);
  Connection connection(path, Access::kReadWrite);
  const db::Migrations wrong = {db::schema_1(), "ALTER TABLE runs ADD COLUMN weather TEXT; SELECT nothing_there()"};
  CHECK_FALSE(store_error([&] { db::migrate(connection, wrong); }).empty());
  const db::Migrations other = {"CREATE TABLE runs (run INTEGER PRIMARY KEY)", "CREATE TABLE more (a)"};
  CHECK(store_error([&] { db::migrate_store(connection, path, other); }) == "TB-STORE-OTHER-SCHEMA");
  CHECK(connection.integer("PRAGMA user_version") == 1);
  CHECK(RunStore::open_read_only(path).check_content(1).holds());
  CHECK_FALSE(std::filesystem::exists(path + ".schema-1.backup"));
  CHECK(read_file(path) == before);
}

TEST_CASE("store migration: an older store is migrated once, by whichever process is first") {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  RunStore::open(path);
  Connection first(path, Access::kReadWrite), second(path, Access::kReadWrite);
  db::migrate(first, with_second_schema());
  db::migrate(second, with_second_schema());
  CHECK(second.integer("SELECT count(*) FROM pragma_table_info('runs') WHERE name = 'weather'") == 1);
  CHECK(store_error([&] { db::migrate(second); }) == "TB-STORE-OTHER-SCHEMA");  // as this program sees it
  CHECK(second.integer("PRAGMA user_version") == 2);
}

TEST_CASE("store schema: v_fit_taxels reads the taxels of a fit from its document") {
  NewStore store;
  const std::int64_t run = store_example(store);
  const char* const document = R"({"output":{"unit":"V"},"taxels":[
    {"taxel":0,"status":"fitted","noise":0.001,"figures":{"j":null,"mean_error":0.25,"max_error":0.5,"full_scale":3.5},
     "at_bound":["beta_a"]},
    {"taxel":-1,"status":"dead","noise":0.0}]})";
  store.add_fit({0, run, "elam", true, 1, document, "", "0.1.0", kUtc});
  Connection raw(store.path(), Access::kReadOnly);
  raw.execute("PRAGMA trusted_schema = ON");  // as in sqlite3 and Python
  CHECK(
      raw.text("SELECT taxel || ' ' || status || ' ' || noise || ' ' || mean_error || ' ' || max_error || ' ' || "
               "full_scale || ' ' || unit || ' ' || at_bound || ' ' || (j IS NULL) FROM v_fit_taxels WHERE fit = 1 AND "
               "taxel = 0") == R"(0 fitted 0.001 0.25 0.5 3.5 V ["beta_a"] 1)");
  CHECK(raw.integer("SELECT count(*) FROM v_fit_taxels WHERE status = 'dead' AND mean_error IS NULL") == 1);
}

// The view of frames: counts as they were stored, wrench and place as numbers that SQL alone decodes.

namespace {

constexpr std::array<const char*, 9> kNumbers = {"fx_n",   "fy_n", "fz_n", "tx_nmm", "ty_nmm",
                                                 "tz_nmm", "x_mm", "y_mm", "z_mm"};

struct FrameRow {
  std::array<double, 9> value{};
  std::array<bool, 9> known{};
};

FrameRow row_of(Connection& raw, std::int64_t position) {
  FrameRow row;
  for (std::size_t i = 0; i < kNumbers.size(); ++i) {
    const std::string where = " FROM v_frames WHERE run = 1 AND position = " + std::to_string(position);
    row.known[i] = raw.integer(std::string("SELECT ") + kNumbers[i] + " IS NOT NULL" + where) == 1;
    db::sqlite::Statement number(raw, std::string("SELECT coalesce(") + kNumbers[i] + ", 0.0)" + where);
    REQUIRE(number.step());
    number.read(row.value[i]);
  }
  return row;
}

}  // namespace

TEST_CASE("v_frames: has each wrench and position as stored, bit for bit") {
  NewStore store;
  const Begun begun = begin_example(store);
  std::mt19937_64 random(20);  // NOLINT(bugprone-random-generator-seed): the same each time
  std::uniform_real_distribution<double> mantissa(-1.0, 1.0);
  std::uniform_int_distribution<int> exponent(-70, 40);
  std::vector<FrameRow> stored;
  for (int i = 0; i < 40; ++i) {
    db::FrameRecord frame = example_frame(begun.branch, i);
    FrameRow row;
    for (std::size_t k = 0; k < row.value.size(); ++k) row.value[k] = std::ldexp(mantissa(random), exponent(random));
    if (i == 0) row.value = {0.0, -0.0, 1.0, -1.0, 60.0, 0.1, -6.2, std::ldexp(1.0, 60), std::ldexp(1.0, -120)};
    for (std::size_t k = 0; k < 6; ++k) frame.wrench->wrench.at(k) = row.value[k];
    for (std::size_t k = 0; k < 3; ++k) frame.wrench->place_mm.at(k) = row.value[6 + k];
    stored.push_back(row);
    store.append_frame(begun.run, frame);
  }
  db::FrameRecord without = example_frame(begun.branch, 40);
  without.wrench.reset();
  store.append_frame(begun.run, without);
  db::FrameRecord broken = example_frame(begun.branch, 41);
  broken.wrench->wrench.at(2) = std::numeric_limits<double>::infinity();
  broken.wrench->wrench.at(3) = std::nan("");
  store.append_frame(begun.run, broken);

  Connection raw(store.path(), Access::kReadOnly);
  for (std::size_t i = 0; i < stored.size(); ++i) {
    const FrameRow row = row_of(raw, static_cast<std::int64_t>(i) + 1);
    for (std::size_t k = 0; k < row.value.size(); ++k) {
      CAPTURE(i, kNumbers[k]);
      CHECK(row.known[k]);
      CHECK(row.value[k] == stored[i].value[k]);
    }
  }
  const FrameRow none = row_of(raw, 41), half = row_of(raw, 42);
  for (const bool known : none.known) CHECK_FALSE(known);
  CHECK((half.known[0] && !half.known[2] && !half.known[3] && half.known[8]));
}

TEST_CASE("v_frames: has the raw counts and the volts per count") {
  NewStore store;
  store_example(store);
  Connection raw(store.path(), Access::kReadOnly);
  CHECK(raw.integer("SELECT count(*) FROM v_frames v JOIN frames f ON f.frame = v.run * 1000000000 + v.position "
                    "WHERE v.counts = f.counts AND v.wrench_raw = f.wrench_raw") == 3);
  CHECK(raw.integer("SELECT length(counts) FROM v_frames WHERE position = 1") == 24);
  db::RunRecord other = example_run();
  other.devices = {{"tactile scanner", "", "", "", "simulated", R"({"volts_per_count": 0.25})"},
                   {"regulator", "", "", "", "simulated", R"({"volts_per_count": 9})"}};
  store_example(store, other);
  other.devices.front().calibration_json = "no JSON";
  store_example(store, other);
  CHECK(raw.integer("SELECT count(*) FROM v_frames WHERE run = 2 AND volts_per_count = 0.25") == 3);
  CHECK(raw.integer("SELECT count(*) FROM v_frames WHERE run = 3 AND volts_per_count IS NULL") == 3);
}
