// Rows in addition to a run's content have their own hashes: no change or deletion goes unnoticed.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <filesystem>

#include "db/sqlite.h"
#include "tests/db/new_store.h"
#include "tests/support/paths.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::RunStore;
using db::sqlite::Access;
using db::sqlite::Connection;

namespace {

db::VerdictRecord verdict_on(const std::string& criterion) {
  db::VerdictRecord verdict;
  verdict.criterion = criterion;
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

// Which rows of run 1 check_seals finds changed after `sql`.
std::string sealed_rows_after(const std::string& sql) {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  const std::int64_t run = judged_example(store);
  CHECK(store.check_seals(run).empty());
  Connection(store.path(), Access::kReadWrite).execute("PRAGMA foreign_keys = OFF; " + sql);
  CHECK(store.check_content(run).holds());
  const std::vector<std::string> differences = store.check_seals(run);
  CHECK(differences.size() <= 1);
  return differences.empty() ? "" : differences.front().substr(0, differences.front().find(':'));
}

}  // namespace

TEST_CASE("seals: changes and deletions of verdicts, fits, approvals and voids are detected") {
  CHECK(sealed_rows_after("DELETE FROM verdicts") == "verdicts");
  CHECK(sealed_rows_after("DELETE FROM verdicts WHERE criterion = 'unfit_taxels'") == "verdicts");
  CHECK(sealed_rows_after("UPDATE verdicts SET verdict = 'fail' WHERE criterion = 'unfit_taxels'") == "verdicts");
  for (const char* column : {"value", "expanded", "low_psi", "high_psi", "taxel_share"})
    CHECK(sealed_rows_after(fmt::format("UPDATE verdicts SET {0} = coalesce({0}, 0) + 1e-15", column)) == "verdicts");
  CHECK(sealed_rows_after("UPDATE verdicts SET direction = 'up'") == "verdicts");
  for (const char* change : {"document = '[]'", "model = 'gpi'", "stands = 0", "fitted = 2", "made_by = ''"})
    CHECK(sealed_rows_after(std::string("UPDATE fits SET ") + change) == "fits");
  CHECK(sealed_rows_after("UPDATE seals SET sha256 = '' WHERE kind = 'fits'") == "fits");
  CHECK(sealed_rows_after("DELETE FROM reports") == "approvals");
  CHECK(sealed_rows_after("UPDATE reports SET approved_by = 'M. Ito'") == "approvals");
  for (const char* reason : {"''", "'it was better so'"})
    CHECK(sealed_rows_after(std::string("UPDATE reports SET reason = ") + reason + " WHERE reason <> ''") ==
          "approvals");
  CHECK(sealed_rows_after("UPDATE runs SET void_utc = '', void_by = '', void_reason = ''") == "void");
  CHECK(sealed_rows_after("UPDATE runs SET void_reason = 'none'") == "void");
  CHECK(sealed_rows_after("DELETE FROM verdicts; DELETE FROM seals WHERE kind = 'verdicts'") == "verdicts");
  CHECK(sealed_rows_after("UPDATE runs SET tags = 'a', notes = 'b'").empty());
}

TEST_CASE("seals: a run is sealed from its start, so that an added verdict is detected") {
  NewStore store;
  const std::int64_t run = store_example(store);
  CHECK(store.check_seals(run).empty());
  Connection(store.path(), Access::kReadWrite)
      .execute(
          "INSERT INTO verdicts (run, criterion, scope_kind, low_psi, high_psi, direction, taxel_share, unit, rule, "
          "verdict, limits_toml, limits_sha256) "
          "VALUES (1, 'a', 'array', 0, 0, 'both', 1, 'psi', 'simple', 'pass', '', '')");
  REQUIRE(store.check_seals(run).size() == 1);
  CHECK_THAT(store.check_seals(run).front(), Catch::StartsWith("verdicts"));
}

TEST_CASE("structure check: deleted runs and baselines are reported") {
  NewStore store;
  const std::int64_t run = store_example(store);
  store.begin_run(example_run());
  store.replace_figures(run, "rig/a", {{"x_psi", 1.0}});
  store.add_baseline({0, "rig/a", "as delivered", "K. Lee", kUtc, {run}});
  CHECK(store.check_structure().empty());
  Connection raw(store.path(), Access::kReadWrite);
  raw.execute("DELETE FROM baseline_runs; DELETE FROM baselines");
  REQUIRE(store.check_structure().size() == 1);
  CHECK_THAT(store.check_structure().front(), Catch::StartsWith("baselines: 1 "));
  raw.execute(
      "PRAGMA foreign_keys = OFF; DELETE FROM seals WHERE run = 2; DELETE FROM sequences WHERE run = 2; "
      "DELETE FROM devices WHERE run = 2; DELETE FROM runs WHERE run = 2");
  CHECK_THAT(store.check_structure().front(), Catch::StartsWith("runs: 2 "));
}

TEST_CASE("seals: copied runs are sealed in the other store, and a tampered run is not copied") {
  NewStore store, other;
  const std::int64_t run = judged_example(store);
  store_example(other);
  const std::int64_t copy = other.copy_runs_from(store, {run}).front();
  CHECK(other.check_seals(copy).empty());
  Connection(other.path(), Access::kReadWrite).execute("DELETE FROM verdicts WHERE criterion = 'unfit_taxels'");
  CHECK(other.check_seals(copy).size() == 1);
  NewStore third;
  CHECK(store_error([&] { (void)third.copy_runs_from(other, {copy}); }) == "TB-STORE-CONFLICT");
  CHECK(third.runs().empty());
}
