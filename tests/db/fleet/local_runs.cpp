// What of a store waits to be pushed, told by the store and the note beside it.
#include "db/fleet/local_runs.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <functional>

#include "db/fleet/remarks.h"
#include "db/fleet/tables.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::db;
using tests::example_run;

TEST_CASE("fleet: each later remark changes a run's fingerprint, and reading it again does not") {
  const tests::TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  RunStore store = RunStore::open(path, Durability::kNormal);
  const std::int64_t run = tests::store_example(store);
  RunRecord other = example_run();
  other.seed = 8;
  const std::int64_t second = tests::store_example(store, other);
  (void)tests::begin_example(store);  // has not ended: does not wait
  fleet::LocalRuns local(path);
  const auto fingerprint = [&] { return local.ended_runs().at(0).fingerprint; };
  const std::string second_before = local.ended_runs().at(1).fingerprint;
  REQUIRE(local.ended_runs().size() == 2);
  CHECK(local.frame_count(run) == 3);

  std::int64_t fit = 0;
  const std::vector<std::function<void()>> remarks = {
      [&] { store.set_tags(run, {"night"}, {}); },
      [&] { store.set_tags(run, {}, {"night"}); },
      [&] { store.add_note(run, "the door was open"); },
      [&] {
        fit = store.add_fit({0, run, "elam", "{}", "{}", "0.1.0", tests::kUtc, "{}"}, {});
      },
      [&] {
        store.replace_verdicts(run, fit, {{run, fit, "c", "array", 1.0, 2.0, "psi", "simple", "pass", "t", "h"}});
      },
      [&] {
        store.replace_figures(run, "sensor", {{"mean_psi", 0.5}});
      },
      [&] {
        store.replace_figures(run, "sensor", {{"mean_psi", 0.6}});
      },
      [&] {
        store.add_report({run, "1-abc", "h", "me", tests::kUtc, "", ""});
      },
      [&] { store.void_run(run, "gauge closed", "me", tests::kUtc); }};
  std::string before = fingerprint(), first = before;
  for (std::size_t i = 0; i < remarks.size(); ++i) {
    INFO("remark " << i);
    const std::int64_t version = local.version();
    remarks[i]();
    CHECK(local.version() != version);
    const std::string now = fingerprint();
    CHECK((now == first) == (i == 1));  // the tag is gone: as if never said
    CHECK(now != before);
    CHECK(fingerprint() == now);
    before = now;
  }
  CHECK(local.ended_runs().at(1).fingerprint == second_before);
  CHECK(second == 2);
}

TEST_CASE("fleet: the hash of a fit and of remarks leaves out the keys that a store assigns") {
  const tests::TemporaryFolder folder;
  std::vector<std::string> hashes;
  for (const int more : {0, 3}) {
    const std::string path = folder.path(std::to_string(more));
    RunStore store = RunStore::open(path, Durability::kNormal);
    for (int i = 0; i < more; ++i) {
      RunRecord other = example_run();
      other.seed = 100 + i;
      const std::int64_t earlier = tests::store_example(store, other);
      (void)store.add_fit({0, earlier, "elam", "{}", "{}", "0.1.0", tests::kUtc, "{}"}, {});
    }
    RunRecord record = example_run();
    record.uuid = "01234567-89ab-4def-8123-456789abcdef";
    const std::int64_t run = tests::store_example(store, record);
    FitTaxelRecord taxel;
    taxel.taxel = 3;
    taxel.status = "fitted";
    taxel.parameters = {1.0 / 3.0};
    const std::int64_t fit = store.add_fit({0, run, "elam", "{}", "{}", "0.1.0", tests::kUtc, "{}"}, {taxel});
    store.replace_verdicts(run, fit, {{run, fit, "c", "array", 1.0, 2.0, "psi", "simple", "pass", "t", "h"}});
    fleet::LocalRuns local(path);
    std::map<std::int64_t, std::pair<std::string, std::string>> names;
    const fleet::Remarks remarks = fleet::remarks_in(local.connection(), run, names);
    const std::vector<fleet::Fit> fits = fleet::fits_in(local.connection(), run);
    REQUIRE(fits.size() == 1);
    CHECK(names.at(fit) == std::pair(record.uuid, fits[0].sha256));
    hashes.push_back(fits[0].sha256 + fleet::sha256_of(remarks));
  }
  CHECK(hashes[0] == hashes[1]);
}

TEST_CASE("fleet: a report without a reason has the hash of before reasons, and a reason changes it") {
  fleet::Remarks remarks;
  fleet::Row row(fleet::reports_table().columns.size());
  row[2].bytes = "1-0a1b2c3d";
  remarks.reports = {row};
  const auto first_columns = [&](std::size_t count) {
    std::string bytes;
    fleet::add_to_digest(bytes, std::vector<fleet::Column>(5, {"", fleet::Kind::kText}), fleet::Row(5));
    const std::vector<fleet::Column>& all = fleet::reports_table().columns;
    fleet::add_to_digest(bytes += "|||", {all.begin(), all.begin() + static_cast<std::ptrdiff_t>(count)}, row, 1);
    return sha256_hex(bytes);
  };
  CHECK(fleet::sha256_of(remarks) == first_columns(7));  // up to `replaces`
  row[7].bytes = "serial corrected";
  remarks.reports = {row};
  CHECK(fleet::sha256_of(remarks) == first_columns(8));
}

TEST_CASE("fleet: the note keeps what was pushed by fleet, and a store without one is as if nothing was") {
  const tests::TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  const fleet::LocalRun run{1, "uuid-1", "content", "2026-01-01", "print"};
  {
    fleet::PushedNote note(path, "a on here:1");
    CHECK(note.fingerprints().empty());
    CHECK(note.last().pushed_utc.empty());
    note.keep(run, "2026-01-02T00:00:00Z");
    note.keep_try("2026-01-03T00:00:00Z", "away");
  }
  fleet::PushedNote again(path, "a on here:1"), other(path, "b on here:1");
  CHECK(again.fingerprints() == std::map<std::string, std::string>{{"uuid-1", "print"}});
  CHECK(again.last().pushed_utc == "2026-01-02T00:00:00Z");
  CHECK(again.last().error == "away");
  CHECK(other.fingerprints().empty());
  fleet::PushedNote nowhere(folder.path("no/such/folder.db"), "a");
  nowhere.keep(run, "t");
  CHECK(nowhere.fingerprints().empty());
}

TEST_CASE("fleet: a note that is damaged, or loses its tables, is as if nothing was pushed") {
  const tests::TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  const fleet::LocalRun run{1, "uuid-1", "content", "2026-01-01", "print"};
  std::ofstream(path + "-fleet") << std::string(4096, 'x');
  CHECK(fleet::PushedNote(path, "a").fingerprints().empty());
  CHECK(fleet::PushedNote(path, "a").last().error.empty());
  std::filesystem::remove(path + "-fleet");

  fleet::PushedNote pushing(path, "a"), trying(path, "a");
  pushing.keep(run, "2026-01-02T00:00:00Z");
  CHECK(trying.fingerprints().size() == 1);
  sqlite::Connection(path + "-fleet", sqlite::Access::kReadWrite).execute("DROP TABLE pushed; DROP TABLE fleets");
  pushing.keep(run, "2026-01-03T00:00:00Z");
  CHECK(pushing.fingerprints().empty());
  trying.keep_try("2026-01-03T00:00:00Z", "away");
  CHECK(trying.last().error.empty());
}

TEST_CASE("fleet's local runs: a view that somebody added to the store is not read") {
  const tests::TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  tests::store_example(store);
  db::sqlite::Connection(store.path(), db::sqlite::Access::kReadWrite).execute("CREATE VIEW mine AS SELECT 1");
  db::fleet::LocalRuns local(store.path());
  CHECK(local.connection().integer("SELECT count(*) FROM runs") == 1);
  CHECK_FALSE(tests::store_error([&] { (void)local.connection().integer("SELECT * FROM mine"); }).empty());
}
