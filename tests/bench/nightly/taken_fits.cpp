// Fits, verdicts and figures that were made of a run in another store since it was copied: what is taken, once.
#include "bench/nightly/take_fits.h"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "db/sqlite.h"
#include "tests/bench/nightly/part_store.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

db::FitRecord fit_of_run(std::int64_t run) {
  db::FitRecord fit;
  fit.run = run;
  fit.model = "elam";
  fit.document = R"({"c":1})";
  fit.made_by = "a build";
  fit.program_version = "1";
  fit.created_utc = "2026-01-03T00:00:00Z";
  return fit;
}

db::VerdictRecord taken_row(const std::string& limits, const std::string& verdict) {
  db::VerdictRecord row;
  row.criterion = "mean_compensation_error";
  row.verdict = verdict;
  row.limits_toml = limits;
  row.limits_sha256 = db::sha256_hex(limits);
  return row;
}

// Run 1 of `there` is run 2 of `here`.
class TwoStores {
 public:
  TwoStores() {
    (void)here.add_run("before", 1);
    (void)there.add_run("both", 2);
    (void)here.store.copy_runs_from(there.store, {1});
  }
  std::size_t take() { return bench::take_fits(there.store, 1, here.store, 2); }
  [[nodiscard]] std::string verdicts() const {
    std::string text;
    for (const db::VerdictRecord& row : here.store.verdicts(2))
      text += fmt::format("{} {} {}; ", row.fit, row.limits_toml, row.verdict);
    return text;
  }

 private:
  TemporaryFolder folder_;

 public:
  PartStore there{folder_.path("there.db")}, here{folder_.path("here.db")};
};

}  // namespace

TEST_CASE("taken fits: those that are not here yet, with their verdicts by each limits file") {
  TwoStores made;
  CHECK(made.take() == 0);
  const std::int64_t first = made.there.store.add_fit(fit_of_run(1));
  made.there.store.replace_verdicts(1, first, {taken_row("a", "pass"), taken_row("a", "fail")});
  made.there.store.replace_verdicts(1, first, {taken_row("b", "inconclusive")});
  made.there.store.replace_verdicts(1, 0, {taken_row("c", "pass")});  // without a fit: not taken
  CHECK(made.take() == 1);
  REQUIRE(made.here.store.fits(2).size() == 1);
  CHECK(made.here.store.fits(2)[0].document == R"({"c":1})");
  const std::string all = made.verdicts();
  CHECK_THAT(
      all, Catch::Contains("1 a pass; 1 a fail; ") && Catch::Contains("1 b inconclusive; ") && !Catch::Contains(" c "));
  CHECK(made.take() == 0);
  CHECK(made.verdicts() == all);
  CHECK(made.here.store.fits(1).empty());
}

TEST_CASE("taken fits: one is another when any of its texts is") {
  TwoStores made;
  (void)made.here.store.add_fit(fit_of_run(2));
  (void)made.there.store.add_fit(fit_of_run(1));
  CHECK(made.take() == 0);
  int expected = 0;
  for (std::string db::FitRecord::*text : {&db::FitRecord::model, &db::FitRecord::document, &db::FitRecord::made_by,
                                           &db::FitRecord::program_version, &db::FitRecord::created_utc}) {
    db::FitRecord other = fit_of_run(1);
    other.*text = R"({"x":1})";
    (void)made.there.store.add_fit(other);
    CHECK(made.take() == 1);
    CHECK(made.here.store.fits(2).size() == static_cast<std::size_t>(++expected) + 1);
  }
}

TEST_CASE("taken fits: figures of subjects that have none here") {
  TwoStores made;
  made.here.store.replace_figures(2, "rig/a", {{"a_psi", 1.0}});
  made.there.store.replace_figures(1, "rig/a", {{"a_psi", 2.0}});
  made.there.store.replace_figures(1, "rig/b", {{"b_psi", 3.0}});
  CHECK(made.take() == 0);
  CHECK(made.here.store.figures_of(2, "rig/a").at("a_psi") == 1.0);
  CHECK(made.here.store.figures_of(2, "rig/b").at("b_psi") == 3.0);
}

TEST_CASE("taken fits: nothing of a run whose fits are not what was stored") {
  TwoStores made;
  (void)made.there.store.add_fit(fit_of_run(1));
  db::sqlite::Connection(made.there.store.path(), db::sqlite::Access::kReadWrite)
      .execute("UPDATE fits SET program_version = '2'");
  try {
    (void)made.take();
    FAIL("it was taken");
  } catch (const db::StoreError& error) {
    CHECK(error.id() == "TB-STORE-CONFLICT");
    CHECK_THAT(error.what(), Catch::Contains(made.there.store.path()) && Catch::Contains("run 1"));
  }
  CHECK(made.here.store.fits(2).empty());
}
