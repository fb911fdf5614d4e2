// db snapshot, migrate and check: their JSON and the files that they leave.
#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "bench/common/utc.h"
#include "db/schema.h"
#include "db/sqlite.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/db/store_example.h"
#include "tests/support/text.h"

using namespace tactbench;
using namespace tactbench::tests;
using Told = nlohmann::ordered_json;

namespace {

struct StoreForDb : StoreHere {
  StoreForDb() {
    db::RunStore store = open();
    (void)store_example(store);
  }
  Finished copy_to(const std::string& file, std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"runs", "copy", "--to", file});
    return say(bench::add_runs, more);
  }
};

}  // namespace

TEST_CASE("runs copy: copies a whole store and reports its size, and overwrites no file") {
  const StoreForDb of;
  const std::string copy = of.folder.path("copy.db"), second = of.folder.path("second.db");
  CHECK(of.copy_to(copy).code == 0);
  CHECK(db::RunStore::open_read_only(copy).run(1).content_sha256 ==
        db::RunStore::open_read_only(of.path).run(1).content_sha256);
  check_refusal(of.copy_to(copy), 2, "TB-STORE-EXISTS");
  const Told printed = Told::parse(of.copy_to(second, {"--json"}).out);
  CHECK(printed == Told{{"schema", "tactbench.runs.copy"},
                        {"version", 1},
                        {"store", of.path},
                        {"to", second},
                        {"bytes", std::filesystem::file_size(second)}});
}

TEST_CASE("db migrate: leaves a store of the current schema unchanged") {
  const StoreForDb of;
  CHECK(of.say(bench::add_db, {"db", "migrate"}).code == 0);
  const Told printed = Told::parse(of.say(bench::add_db, {"db", "migrate", "--json"}).out);
  CHECK(printed.at("store") == of.path);
  CHECK(printed.at("schema_before") == db::kSchemaVersion);
  CHECK(printed.at("backup") == "");
}

TEST_CASE("db: a missing store is rejected and not created") {
  const TemporaryFolder folder;
  const std::string none = folder.path("none.db");
  check_refusal(verb_here(bench::add_verify, {"verify", "--db", none}), 5, "TB-STORE-OPEN");
  check_refusal(verb_here(bench::add_db, {"db", "migrate", "--db", none}), 5, "TB-STORE-OPEN");
  CHECK_FALSE(std::filesystem::exists(none));
}

TEST_CASE("db migrate: completes a store if its creation was interrupted") {
  const TemporaryFolder folder;
  {  // as a process leaves it that is killed while it makes a store: the journal takes all of it back
    db::sqlite::Connection made(folder.path("made.db"), db::sqlite::Access::kReadWrite);
    made.execute("PRAGMA journal_mode = DELETE; PRAGMA cache_size = 1; BEGIN; PRAGMA application_id = " +
                 std::to_string(db::kApplicationId) + "; CREATE TABLE half (a)");
    for (int i = 0; i < 200; ++i) made.execute("INSERT INTO half VALUES (zeroblob(4000))");
    std::filesystem::copy_file(folder.path("made.db-journal"), folder.path("cut.db-journal"));
    made.execute("COMMIT");
    std::filesystem::copy_file(folder.path("made.db"), folder.path("cut.db"));
  }
  CHECK(verb_here(bench::add_db, {"db", "migrate", "--db", folder.path("cut.db")}).code == 0);
  CHECK(db::RunStore::open_read_only(folder.path("cut.db")).runs().empty());
  CHECK_FALSE(std::filesystem::exists(folder.path("cut.db") + ".schema-0.backup"));
}

TEST_CASE("verify: reports each run that differs, and runs that have not ended") {
  const StoreForDb of;
  {
    db::RunStore store = of.open();
    (void)store_example(store);
    (void)begin_example(store);
  }
  db::sqlite::Connection(of.path, db::sqlite::Access::kReadWrite)
      .execute("UPDATE frames SET status = 9 WHERE frame = 1000000002");
  CHECK(of.say(bench::add_verify, {"verify"}).code == 5);
  const Told printed = Told::parse(of.say(bench::add_verify, {"verify", "--json"}).out);
  CHECK(printed.at("holds") == false);
  CHECK(printed.at("structure").empty());
  REQUIRE(printed.at("runs").size() == 3);
  CHECK(printed.at("runs").at(0).at("holds") == false);
  CHECK(printed.at("runs").at(0).at("ended") == true);
  CHECK_FALSE(printed.at("runs").at(0).at("difference").get<std::string>().empty());
  CHECK(printed.at("runs").at(1) == Told{{"run", 2},
                                         {"ended", true},
                                         {"holds", true},
                                         {"pruned", false},
                                         {"frames", 3},
                                         {"difference", ""},
                                         {"beside", Told::array()}});
  CHECK(printed.at("runs").at(2).at("ended") == false);
  CHECK(printed.at("runs").at(2).at("holds") == true);
}

// import: what it prints and stores of a table, row by row; and the doubts that it reports.

namespace {

// Two sequences, of seven and of five rows, on two taxels.
const std::string kRowsOfTwo =
    "sequence,input,output,taxel\n"
    "up,0,0,0\nup,1,1.5,0\nup,2,2.5,0\nup,3,4,0\nup,2,3.5,0\nup,1,2,0\nup,0,0.1,0\n"
    "two,0,0,3\ntwo,1,1.4,3\ntwo,2,2.6,3\ntwo,1,2.1,3\ntwo,0,0,3\n";

struct TableToImport {
  explicit TableToImport(const std::string& text) { write_file(file, text); }
  Finished import(std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"runs", "import", file, "--db", path});
    return verb_here(bench::add_runs, more);
  }
  [[nodiscard]] db::RunStore store() const { return db::RunStore::open_read_only(path); }
  TemporaryFolder folder;
  std::string file = folder.path("own.csv"), path = folder.path("runs.db");
};

}  // namespace

TEST_CASE("import: the run is stored with its sequences, and summarised") {
  const TableToImport table(kRowsOfTwo);
  CHECK(table.import({"--operator", "K. Lee", "--purpose", "as measured"}).code == 0);
  const db::RunStore store = table.store();
  const db::RunRecord run = store.run(1);
  CHECK((run.origin == "imported" && run.operator_name == "K. Lee" && run.purpose == "as measured"));
  CHECK((run.outcome == db::Outcome::kCompleted && run.safe_state == db::SafeState::kUnknown));
  CHECK_FALSE(run.ended_utc.empty());
  REQUIRE(run.sequences.size() == 2);
  CHECK((run.sequences[0].name == "up" && run.sequences[0].repeats == 1 && run.sequences[0].frames_per_repeat == 7));
  CHECK((run.sequences[1].name == "two" && run.sequences[1].repeats == 1 && run.sequences[1].frames_per_repeat == 5));
  REQUIRE(run.devices.size() == 1);
  CHECK((run.devices[0].role == "table" && run.devices[0].model == "own.csv" && run.devices[0].origin == "imported"));
  CHECK(run.devices[0].serial == db::sha256_hex(kRowsOfTwo));
  CHECK(nlohmann::json::parse(run.devices[0].calibration_json) ==
        nlohmann::json{{"input_unit", ""}, {"output_unit", ""}, {"map", ""}});
  const std::vector<db::SeriesRecord> series = store.series(1);
  REQUIRE(series.size() == 2);
  CHECK((series[0].sequence == 0 && series[0].taxel == 0));
  CHECK(series[0].input == std::vector<double>{0, 1, 2, 3, 2, 1, 0});
  CHECK(series[0].output == std::vector<double>{0, 1.5, 2.5, 4, 3.5, 2, 0.1});
  CHECK((series[1].sequence == 1 && series[1].taxel == 3));
  CHECK(series[1].input == std::vector<double>{0, 1, 2, 1, 0});
  CHECK(series[1].output == std::vector<double>{0, 1.4, 2.6, 2.1, 0});
  CHECK(verb_here(bench::add_verify, {"verify", "1", "--db", table.path}).code == 0);
}

TEST_CASE("import: units of the command line outrank those of the table, and the column mapping is stored") {
  const TableToImport table("sequence,force,volts\n,N,V\na,0,0\na,1,1\na,2,2\na,1,1.5\na,0,0.1\n");
  REQUIRE(table.import({"--map", "input=force,output=3,sequence=sequence"}).code == 0);
  REQUIRE(table.import({"--map", "input=force,output=volts,sequence=1", "--input-unit", "kN", "--output-unit", "mV"})
              .code == 0);
  const auto calibration = [&](std::int64_t run) {
    return nlohmann::json::parse(table.store().run(run).devices.at(0).calibration_json);
  };
  CHECK(calibration(1) ==
        nlohmann::json{{"input_unit", "N"}, {"output_unit", "V"}, {"map", "input=force,output=3,sequence=sequence"}});
  CHECK(calibration(2) ==
        nlohmann::json{{"input_unit", "kN"}, {"output_unit", "mV"}, {"map", "input=force,output=volts,sequence=1"}});
  const auto printed =
      nlohmann::ordered_json::parse(table.import({"--json", "--map", "input=force,output=volts,sequence=1"}).out);
  CHECK(printed == nlohmann::ordered_json{{"schema", "tactbench.import"},
                                          {"version", 1},
                                          {"run", 3},
                                          {"rows", 5},
                                          {"left_out", 0},
                                          {"sequences", 1},
                                          {"sha256", db::sha256_hex(read_file(table.file))}});
}

TEST_CASE("import: counts the rows that are left out") {
  TableToImport table(kRowsOfTwo + "two,x,0,3\n");
  const Finished refused = table.import();
  CHECK(refused.code == 2);
  CHECK(refused.out.empty());
  CHECK_THAT(refused.err, Catch::Contains("[TB-TABLE-ROW]") && Catch::Contains("own.csv:14"));
  CHECK(table.import({"--skip-bad-rows"}).code == 0);
  CHECK(nlohmann::json::parse(table.store().run(1).devices.at(0).calibration_json).at("rows_left_out") == 1);
  CHECK(nlohmann::json::parse(table.import({"--skip-bad-rows", "--json"}).out).at("left_out") == 1);
}

TEST_CASE("import: rejects a table that no model can be fitted to, and stores nothing") {
  const TableToImport table("sequence,input,output\na,0,0\n");
  check_refusal(table.import(), 2, "TB-TABLE-SHORT");
  CHECK_THROWS(table.store());
}

// Dates and rules that verbs of the store take, each at its edges, and what db prune tells of runs that are
// known row by row.

namespace {

struct StoreOfRules : StoreHere {
  Finished prune(const std::string& rule, const std::vector<std::string>& more = {}) const {
    return verb_here(bench::add_db, joined({"db", "prune", "--db", path, "--keep=" + rule}, more));
  }
  Finished since(const std::string& date) const {
    return verb_here(bench::add_runs, {"runs", "list", "--json", "--db", path, "--since=" + date});
  }
};

void add_night_run(db::RunStore& store, const std::string& started, const std::vector<std::string>& tags) {
  db::RunRecord run = example_run();
  run.started_utc = started;
  store.set_tags(store_example(store, run), tags, {});
}

}  // namespace

TEST_CASE("db prune: --keep accepts days, weeks and dates within their limits") {
  const StoreOfRules store;
  (void)store.open();
  for (const char* rule : {"1d", "36500d", "1w", "0000-00-00", "9999-99-99"}) {
    INFO(rule);
    CHECK(store.prune(rule).code == 0);
  }
  for (const char* rule :
       {"d",          "0d",         "0w",         "36501d",       "36501w",     "-1d",         "1m",
        "1dd",        "1 d",        "1",          "99999999999d", "2026-01-3",  "2026-01-311", "/026-01-31",
        ":026-01-31", "2026-01-3/", "2026-01-3:", "2026/01-31",   "2026-01/31", "2026-1-311"}) {
    INFO(rule);
    check_refusal(store.prune(rule), 2, "TB-USAGE", "--keep");
  }
  // Of a day of UTC, which may turn meanwhile.
  for (const auto& [rule, days] : std::vector<std::pair<std::string, int>>{{"3d", 3}, {"2w", 14}, {"1d", 1}}) {
    const std::string before = bench::utc_days_ago(days);
    const nlohmann::json printed = nlohmann::json::parse(store.prune(rule, {"--json"}).out);
    CHECK((before <= printed.at("begin_of_kept") && printed.at("begin_of_kept") <= bench::utc_days_ago(days)));
  }
}

TEST_CASE("runs list: --since accepts a date, a date with time, or a number of days") {
  const StoreOfRules store;
  {
    db::RunStore open = store.open();
    add_night_run(open, "2024-05-01T09:00:00Z", {});
  }
  const auto lists = [&](const std::string& date) {
    const Finished list = store.since(date);
    CHECK(list.code == 0);
    return nlohmann::json::parse(list.out).at("runs").size() == 1;
  };
  for (const char* before : {"2020-01-01", "36500d", "2024-05-01", "2024-05-01T09:00:00Z"}) CHECK(lists(before));
  for (const char* after : {"0d", "2024-05-01T09:00:01Z", "2100-01-01"}) CHECK_FALSE(lists(after));
  for (const char* date : {"2024-05-0", "2024-05", "/024-05-01", ":024-05-01", "2024-05-0/", "2024-05-0:", "2024/05-01",
                           "2024-05:01", "20240-5-01", "yesterday12", "-1d", "d", "7"}) {
    INFO(date);
    check_refusal(store.since(date), 2, "TB-USAGE", "--since");
  }
}

TEST_CASE("db prune: reports what would be removed, what was removed and what remains") {
  const StoreOfRules store;
  {
    db::RunStore open = store.open();
    add_night_run(open, "2024-05-01T09:00:00Z", {"nightly"});
    add_night_run(open, "2024-05-01T10:00:00Z", {"nightly", "pinned"});
    add_night_run(open, "2024-05-01T11:00:00Z", {"other"});
    add_night_run(open, "2024-05-01T12:00:00Z", {"nightly"});
    add_night_run(open, "2024-05-02T00:00:00Z", {"nightly"});  // of the first day to keep
    add_night_run(open, "2024-05-02", {"nightly"});
  }
  const nlohmann::json asked = nlohmann::json::parse(store.prune("2024-05-02", {"--json"}).out);
  CHECK(asked.at("done") == false);
  CHECK(asked.at("runs") == nlohmann::json({1, 4}));
  CHECK(asked.at("frames") == 6);
  CHECK(asked.at("bytes") == 0);
  CHECK(asked.at("file_bytes") == asked.at("file_bytes_before"));
  // 3 frames each of 12 counts of 2 bytes, and 2 points of 16 bytes of their traces.
  CHECK(store.prune("2024-05-01T", {}).code == 2);
  CHECK(store.prune("2024-05-02", {"--yes"}).code == 0);
  CHECK(nlohmann::json::parse(store.prune("2024-05-02", {"--yes", "--shrink", "--json"}).out).at("frames") == 0);
  const nlohmann::json printed = nlohmann::json::parse(store.prune("2024-05-03", {"--yes", "--json"}).out);
  CHECK(printed.at("done") == true);
  CHECK(printed.at("runs") == nlohmann::json({5, 6}));
  CHECK(printed.at("frames") == 6);
  CHECK(printed.at("bytes") == 6 * (24 + 32));
  CHECK(printed.at("kept") == nlohmann::json::parse(R"([{"run": 2, "why": "pinned"}])"));
}

TEST_CASE("db prune: does not prune a damaged run") {
  const StoreOfRules store;
  {
    db::RunStore open = store.open();
    add_night_run(open, "2024-05-01T09:00:00Z", {"nightly"});
    add_night_run(open, "2024-05-01T10:00:00Z", {"nightly"});
  }
  db::sqlite::Connection(store.path, db::sqlite::Access::kReadWrite)
      .execute("UPDATE frames SET reference_psi = reference_psi + 1e-9 WHERE rowid = (SELECT min(rowid) FROM frames)");
  CHECK(store.prune("2024-05-02", {"--yes"}).code == 0);
  CHECK(db::RunStore::open_read_only(store.path).frame_count(1) == 3);
}
