// Rows beside a run's content lie under hashes of their own: no change or deletion goes unnoticed.
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

namespace {

db::VerdictRecord verdict_on(const std::string& criterion) {
  db::VerdictRecord verdict;
  verdict.criterion = criterion;
  verdict.scope = "array";
  verdict.verdict = "pass";
  verdict.value = 0.1;
  verdict.limit = 1.0 / 3.0;
  return verdict;
}

// A run with a fit, two verdicts, two approvals and a void.
std::int64_t judged_example(RunStore& store) {
  const std::int64_t run = store_example(store);
  const std::int64_t fit = store.add_fit({0, run, "elam", true, 1, "{}", "a build", "0.1.0", kUtc});
  store.replace_verdicts(run, fit, {verdict_on("mean_compensation_error"), verdict_on("unfit_taxels")});
  store.add_report({run, "1-0a1b2c3d", "0a1b2c3d", "K. Lee", kUtc, "", ""});
  store.add_report({run, "1-ffffffff", "ffffffff", "K. Lee", kUtc, "1-0a1b2c3d", "serial corrected"});
  store.void_run(run, "gauge closed", "K. Lee", kUtc);
  return run;
}

// The report of check_seals on run 1 after `sql`.
std::string report_after(const std::string& sql) {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  const std::int64_t run = judged_example(store);
  CHECK(store.check_seals(run).empty());
  Connection(store.path(), Access::kReadWrite).execute("PRAGMA foreign_keys = OFF; " + sql);
  CHECK(store.check_content(run).holds());
  std::string said;
  for (const std::string& line : store.check_seals(run)) said += line + "\n";
  return said;
}

}  // namespace

TEST_CASE("changes and deletions of verdicts, fits, approvals and voids are noticed") {
  CHECK(report_after("DELETE FROM verdicts") == "verdicts: 2 were stored, 0 there now\n");
  CHECK(report_after("DELETE FROM verdicts WHERE criterion = 'unfit_taxels'") ==
        "verdicts: 2 were stored, 1 there now\n");
  CHECK(report_after("UPDATE verdicts SET verdict = 'fail' WHERE criterion = 'unfit_taxels'") ==
        "verdicts: what is there is not what was stored\n");
  CHECK(report_after("UPDATE verdicts SET value = value + 1e-15") ==
        "verdicts: what is there is not what was stored\n");
  for (const char* change : {"document = '[]'", "model = 'gpi'", "stands = 0", "fitted = 2", "made_by = ''"})
    CHECK(report_after(std::string("UPDATE fits SET ") + change) == "fits: what is there is not what was stored\n");
  CHECK(report_after("UPDATE seals SET sha256 = '' WHERE kind = 'fits'") ==
        "fits: what is there is not what was stored\n");
  CHECK(report_after("DELETE FROM reports") == "approvals: 2 were stored, 0 there now\n");
  CHECK(report_after("UPDATE reports SET approved_by = 'M. Ito'") ==
        "approvals: what is there is not what was stored\n");
  for (const char* reason : {"''", "'it was better so'"})
    CHECK(report_after(std::string("UPDATE reports SET reason = ") + reason + " WHERE reason <> ''") ==
          "approvals: what is there is not what was stored\n");
  CHECK(report_after("UPDATE runs SET void_utc = '', void_by = '', void_reason = ''") ==
        "void: 1 were stored, 0 there now\n");
  CHECK(report_after("UPDATE runs SET void_reason = 'none'") == "void: what is there is not what was stored\n");
  CHECK_THAT(report_after("DELETE FROM verdicts; DELETE FROM seals WHERE kind = 'verdicts'"),
             Catch::Contains("verdicts: the count and hash of what was stored are missing"));
  CHECK(report_after("UPDATE runs SET tags = 'a', notes = 'b'").empty());
}

TEST_CASE("a run that was never judged is sealed from its start") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  const std::int64_t run = store_example(store);
  CHECK(store.check_seals(run).empty());
  Connection(store.path(), Access::kReadWrite)
      .execute(
          "INSERT INTO verdicts (run, criterion, scope, unit, rule, verdict, limits_toml, limits_sha256) "
          "VALUES (1, 'a', 'b', '', 'simple', 'pass', '', '')");
  CHECK(store.check_seals(run) == std::vector<std::string>{"verdicts: 0 were stored, 1 there now"});
}

TEST_CASE("missing runs and baselines are noticed") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  const std::int64_t run = store_example(store);
  store.begin_run(example_run());
  store.replace_figures(run, "rig/a", {{"x_psi", 1.0}});
  store.add_baseline({0, "rig/a", "as delivered", "K. Lee", kUtc, {run}});
  CHECK(store.check_structure().empty());
  Connection raw(store.path(), Access::kReadWrite);
  raw.execute("DELETE FROM baseline_runs; DELETE FROM baselines");
  REQUIRE(store.check_structure().size() == 1);
  CHECK_THAT(store.check_structure().front(), Catch::Contains("baselines: 1 were stored, 0 are there"));
  raw.execute(
      "PRAGMA foreign_keys = OFF; DELETE FROM seals WHERE run = 2; DELETE FROM sequences WHERE run = 2; "
      "DELETE FROM devices WHERE run = 2; DELETE FROM runs WHERE run = 2");
  CHECK_THAT(store.check_structure().front(), Catch::Contains("runs: 2 were stored, 1 are there"));
}

TEST_CASE("copied runs are sealed in the other store, and one that was tampered with is not copied") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db")), other = RunStore::open(folder.path("other.db"));
  const std::int64_t run = judged_example(store);
  store_example(other);
  const std::int64_t copy = other.copy_runs_from(store, {run}).front();
  CHECK(other.check_seals(copy).empty());
  Connection(other.path(), Access::kReadWrite).execute("DELETE FROM verdicts WHERE criterion = 'unfit_taxels'");
  CHECK(other.check_seals(copy).size() == 1);
  RunStore third = RunStore::open(folder.path("third.db"));
  std::string message;
  CHECK(store_error([&] { (void)third.copy_runs_from(other, {copy}); }, &message) == "TB-STORE-CONFLICT");
  CHECK_THAT(message, Catch::Contains("verdicts: 2 were stored, 1 there now"));
  CHECK(third.runs().empty());
}
