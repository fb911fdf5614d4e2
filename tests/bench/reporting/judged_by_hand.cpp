// Which runs a verdict rests on and what is said of the others, on evaluations and models that are known by hand.

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tests/bench/reporting/judged_store.h"

using namespace tactbench;
using namespace tactbench::tests;

TEST_CASE("judged runs: every row of one evaluation by limits, with the models' run") {
  JudgedStore made(2);
  analysis::Runs runs(made.store);
  std::vector<analysis::JudgedUncertainty> uncertainties(1);
  const std::vector<db::VerdictRecord> rows =
      bench::judge_anew(runs, film_line_model(), film_evaluation(2, 0.5).evaluation, film_limits(0.5), &uncertainties);
  CHECK(film_row_words(rows) ==
        "2 mean_compensation_error 0.5 of 0.5: pass; 2 worst_taxel_error 1.5 of 60: pass; 2 distance_of_mean 0.25 of "
        "1: pass; 2 unfit_taxels 0 of 1: pass; ");
  for (const db::VerdictRecord& row : rows) {
    CHECK(row.model_run == 1);
    CHECK(row.rule == "simple");
    CHECK(row.limits_sha256 == db::sha256_hex(film_limits_text(0.5)));
  }
  CHECK(uncertainties.size() == 1);  // a simple rule asks for none
  CHECK(film_mean_words(bench::judge_anew(runs, film_line_model(), film_evaluation(2, 0.75).evaluation,
                                          film_limits(0.5))) == "2 mean_compensation_error 0.75 of 0.5: fail; ");
}

TEST_CASE("judged runs: a rule that needs U has it worked out for the figures judged, and without a certificate not") {
  JudgedStore made(2);
  analysis::Runs runs(made.store);
  std::vector<analysis::JudgedUncertainty> known(1);
  const std::vector<db::VerdictRecord> rows = bench::judge_anew(
      runs, film_line_model(), film_evaluation(2, 0.5).evaluation, film_limits(10.0, "guarded"), &known);
  CHECK(film_row_words(rows) ==
        "2 mean_compensation_error 0.5 of 10: inconclusive; 2 worst_taxel_error 1.5 of 60: inconclusive; 2 "
        "distance_of_mean 0.25 of 1: pass; 2 unfit_taxels 0 of 1: pass; ");
  REQUIRE(known.size() > 4);
  CHECK(known[0].criterion.empty());  // what was there stays
  CHECK(known[1].criterion == "mean_compensation_error");
  CHECK(known[1].run == 2);
  CHECK_FALSE(known[1].missing.empty());
}

TEST_CASE("judged runs: what rests on an overdue reference is inconclusive") {
  JudgedStore made(1);
  FilmRun overdue;
  overdue.calibration = R"({"calibrated":"2019-01-01","due":"2020-01-01"})";
  REQUIRE(made.add(overdue) == 2);
  analysis::Runs runs(made.store);
  const analysis::Evaluation evaluation = film_evaluation(2, 0.5).evaluation;
  CHECK(film_row_words(bench::judge_anew(runs, film_line_model(), evaluation, film_limits(0.5))) ==
        "2 mean_compensation_error 0.5 of 0.5: inconclusive; 2 worst_taxel_error 1.5 of 60: inconclusive; 2 "
        "distance_of_mean 0.25 of 1: pass; 2 unfit_taxels 0 of 1: pass; ");
}

TEST_CASE(
    "judged runs: each but the models' own, in the order given, and the own figures only where there are no "
    "others") {
  JudgedStore made(3);
  CHECK(made.judged({}, film_limits(1.0)).verdicts.empty());
  const bench::Judgement both =
      made.judged({film_evaluation(1, 0.25), film_evaluation(3, 2.0), film_evaluation(2, 0.5)}, film_limits(1.0));
  CHECK(film_mean_words(both.verdicts) ==
        "3 mean_compensation_error 2 of 1: fail; 2 mean_compensation_error 0.5 of 1: pass; ");
  CHECK(both.verdicts.size() == 8);
  CHECK(film_notes(both).empty());
  CHECK(both.void_runs.empty());
  CHECK(both.notes.trajectories.size() == 2);
  const bench::Judgement own = made.judged({film_evaluation(1, 0.25)}, film_limits(1.0));
  CHECK(film_mean_words(own.verdicts) == "1 mean_compensation_error 0.25 of 1: inconclusive; ");
  CHECK(own.verdicts.size() == 4);
  CHECK(film_notes(own) == "not judged");
  CHECK(own.notes.trajectories.empty());
  const bench::Judgement listed = made.judged({film_evaluation(1, 0.25)}, film_limits(1.0, "report-only"));
  CHECK(film_mean_words(listed.verdicts) == "1 mean_compensation_error 0.25 of 1: report only; ");
  CHECK(film_notes(listed).empty());
}

TEST_CASE("judged runs: a void run is left out with its reason, or counted on request and named") {
  JudgedStore made(3);
  made.declare_void(3);
  const std::vector<bench::NamedEvaluation> all = {film_evaluation(1, 0.25), film_evaluation(3, 2.0),
                                                   film_evaluation(2, 0.5)};
  const bench::Judgement without = made.judged(all, film_limits(1.0));
  CHECK(film_mean_words(without.verdicts) == "2 mean_compensation_error 0.5 of 1: pass; ");
  CHECK(film_notes(without) == " 3");
  CHECK(without.void_runs.empty());
  const bench::Judgement with = made.judged(all, film_limits(1.0), true);
  CHECK(film_mean_words(with.verdicts) ==
        "3 mean_compensation_error 2 of 1: fail; 2 mean_compensation_error 0.5 of 1: pass; ");
  CHECK(film_notes(with) == " 3");
  CHECK_THAT(with.notes.remarks[0], Catch::Contains("gauge closed") && Catch::Contains("--void-too"));
  REQUIRE(with.void_runs.size() == 1);
  CHECK(with.void_runs[0].run == 3);
  bench::StoredJudgement stored;
  stored.lost = {"lost before, of 7"};
  CHECK(film_notes(made.judged(all, film_limits(1.0), false, stored)) == " 7 3");
}

TEST_CASE("judged runs: nothing is judged by models of a void run, unless it is asked for") {
  JudgedStore made(2);
  made.declare_void(1);
  const std::vector<bench::NamedEvaluation> both = {film_evaluation(1, 0.25), film_evaluation(2, 0.5)};
  const bench::Judgement none = made.judged(both, film_limits(1.0));
  CHECK(film_mean_words(none.verdicts) == "1 mean_compensation_error 0.25 of 1: inconclusive; ");
  CHECK(film_notes(none) == "not judged");
  CHECK(none.notes.stored_worse.empty());
  const bench::Judgement with = made.judged(both, film_limits(1.0), true);
  CHECK(film_mean_words(with.verdicts) == "2 mean_compensation_error 0.5 of 1: pass; ");
  CHECK(film_notes(with) == " 1");
  CHECK(with.void_runs.size() == 1);
}
