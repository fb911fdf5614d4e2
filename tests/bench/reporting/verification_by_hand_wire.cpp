// verify, result by result: fits and verdicts that follow from their runs, and those that do not.
// On runs of one taxel that are stored by hand.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tests/bench/reporting/verified_store.h"

using namespace tactbench;
using namespace tactbench::tests;

TEST_CASE("verified by hand: fits follow from their run, to the bit") {
  VerifiedStore made;
  (void)made.add(film_inner_loops());
  (void)made.fitted(1);
  analysis::FitOptions monotone;
  monotone.model = "monotone";
  (void)made.fitted(1, monotone);
  analysis::FitOptions outer;
  outer.identify.exact_outer = true;
  (void)made.fitted(1, outer);
  CHECK(made.verified(1) ==
        VerifiedLines{"1 of 1, elam, 3: holds", "2 of 1, monotone, 3: holds", "3 of 1, elam, exact outer, 3: holds"});
  const bool modified = bench::this_build().find("modified") != std::string::npos;
  for (const bench::VerifiedResult& result : made.results(1)) CHECK(result.compared.starts_with("1e-12") == modified);
}

TEST_CASE("verified by hand: a fit of one of two sequences is made again of that one") {
  VerifiedStore made;
  FilmRun two = film_inner_loops({"a", "b"});
  two.error_v = [](int, int repeat, double psi) { return repeat == 1 && psi == 30.0 ? 0.05 : 0.0; };
  (void)made.add(two);
  analysis::FitOptions part;
  part.sequences = {"b"};
  (void)made.fitted(1, part);
  (void)made.fitted(1);
  CHECK(made.verified(1) == VerifiedLines{"1 of 1, elam, 3: holds", "2 of 1, elam, 3: holds"});
}

TEST_CASE(
    "verified by hand: a fit of another build within a millionth of a millionth, and one that does not tell its "
    "build") {
  VerifiedStore made;
  (void)made.add(film_inner_loops());
  const analysis::SensorModel models = analysis::fit_array(analysis::load_dataset(made.store, 1));
  (void)analysis::store_fit(made.store, models, "1", "2026-03-01T02:00:00Z", "commit 12");
  (void)analysis::store_fit(made.store, models, "1", "2026-03-01T02:00:00Z");
  CHECK(made.verified(1) == VerifiedLines{"1 of 1, elam, 3: holds", "2 of 1, elam, 3: holds"});
  for (const bench::VerifiedResult& result : made.results(1)) CHECK(result.compared.starts_with("1e-12"));
  CHECK_THAT(made.results(1)[0].compared, Catch::Contains("commit 12") && Catch::Contains(bench::this_build()));
}

TEST_CASE("verified by hand: a fit whose numbers are others is named with the first of them") {
  VerifiedStore made;
  (void)made.add(film_inner_loops());
  for (const double noise : {0.0, 0.5}) {
    analysis::SensorModel models = analysis::fit_array(analysis::load_dataset(made.store, 1));
    models.taxels.front().noise += noise;
    (void)bench::keep_fit(made.store, models);
  }
  CHECK(made.verified(1) == VerifiedLines{"1 of 1, elam, 3: holds", "2 of 1, elam, 3: differs"});
  CHECK_THAT(bench::verify_run(made.store, 1).first_difference,
             Catch::StartsWith("fit 2") && Catch::Contains("taxel 0."));
}

TEST_CASE("verified by hand: a document that is damaged is a difference") {
  VerifiedStore made;
  (void)made.add(film_inner_loops());
  db::FitRecord damaged;
  damaged.run = 1;
  damaged.model = "monotone";
  damaged.made_by = "x";
  damaged.document = "{}";
  (void)made.store.add_fit(damaged);
  REQUIRE(made.verified(1).size() == 1);
  CHECK_THAT(made.results(1)[0].difference, Catch::EndsWith("[TB-MODEL-STORED]"));
}

TEST_CASE("verified by hand: verdicts on a held-out run and on the models' own, by each limits file in turn") {
  VerifiedStore made;
  for (int i = 0; i < 2; ++i) (void)made.add(film_inner_loops());
  const std::int64_t fit = made.fitted(1);
  made.judge(fit, {2});
  CHECK(made.verified(2) == VerifiedLines{"1 of 1, verdicts, 4: holds"});
  std::vector<db::VerdictRecord> rows = made.store.verdicts(2);
  for (db::VerdictRecord& row : rows) {
    row.limits_toml += "# another\n";
    row.limits_sha256 = db::sha256_hex(row.limits_toml);
  }
  rows[1].value += 0.5;
  made.store.replace_verdicts(2, fit, rows);
  CHECK(made.verified(2) == VerifiedLines{"1 of 1, verdicts, 4: holds", "1 of 1, verdicts, 4: differs"});
  CHECK_THAT(made.results(2)[1].difference, Catch::Contains("worst_taxel_error") && Catch::Contains("value"));
  // On the models' own run they are withheld.
  made.judge(fit, {});
  CHECK(made.verified(1).at(1) == "1 of 1, verdicts, 4: holds");
  rows = made.store.verdicts(1);
  for (db::VerdictRecord& row : rows) {
    CHECK(row.verdict == "inconclusive");
    row.verdict = "pass";
  }
  made.store.replace_verdicts(1, fit, rows);
  CHECK_THAT(made.results(1).at(1).difference,
             Catch::Contains("mean_compensation_error") && Catch::Contains("'inconclusive'"));
}

TEST_CASE("verified by hand: a limits file that is not what it was, and verdicts without a fit") {
  VerifiedStore made;
  for (int i = 0; i < 2; ++i) (void)made.add(film_inner_loops());
  made.judge(made.fitted(1), {2});
  std::vector<db::VerdictRecord> rows = made.store.verdicts(2);
  for (db::VerdictRecord& row : rows) row.limits_toml += "#";
  made.store.replace_verdicts(2, 1, rows);
  CHECK(made.verified(2) == VerifiedLines{"1 of 1, verdicts, 4: differs"});
  made.store.replace_verdicts(1, 0, rows);
  CHECK(made.verified(1).at(1) == "0 of 0, verdicts, 4: left");
}

TEST_CASE("verified by hand: a reference that was overdue by a laboratory file, and by the date of its run") {
  VerifiedStore made;
  (void)made.add(film_inner_loops());
  (void)made.add(film_inner_loops());
  const std::int64_t fit = made.fitted(1);
  made.judge(fit, {2}, {{"R-1", "", "", "", "2026-02-01", ""}});
  CHECK(made.store.verdicts(2)[0].verdict == "inconclusive");
  CHECK(made.verified(2) == VerifiedLines{"1 of 1, verdicts, 4: holds"});
  CHECK_THAT(made.results(2)[0].compared, Catch::Contains("laboratory"));
  FilmRun dated = film_inner_loops();
  dated.calibration = R"({"calibrated":"2019-01-01","due":"2020-01-01"})";
  const std::int64_t dated_run = made.add(dated);
  made.judge(fit, {dated_run});
  std::vector<db::VerdictRecord> rows = made.store.verdicts(dated_run);
  for (db::VerdictRecord& row : rows) row.verdict = "pass";
  made.store.replace_verdicts(dated_run, fit, rows);
  CHECK_THAT(made.results(dated_run)[0].difference,
             Catch::Contains("mean_compensation_error") && Catch::Contains("'inconclusive'"));
}
