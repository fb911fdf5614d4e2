// Verdicts of before beside new ones: which are taken over, which are named, and what is stored.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tests/bench/reporting/judged_store.h"

using namespace tactbench;
using namespace tactbench::tests;

TEST_CASE("judged runs: stored verdicts by these limits are taken over, of the newest fit, and worse ones are named") {
  JudgedStore made(4);
  const std::int64_t first = made.keep(film_line_model()), second = made.keep(film_line_model());
  const auto stored_row = [&](std::int64_t run, std::int64_t fit, double value, const char* verdict,
                              const std::string& limits) {
    db::VerdictRecord row;
    row.run = run;
    row.fit = fit;
    row.model_run = 1;
    row.criterion = "mean_compensation_error";
    row.value = value;
    row.limit = 7.0;
    row.verdict = verdict;
    row.limits_sha256 = db::sha256_hex(limits);
    return row;
  };
  bench::StoredJudgement stored;
  stored.verdicts = {stored_row(2, first, 5.0, "pass", film_limits_text(1.0)),
                     stored_row(2, second, 6.0, "pass", film_limits_text(1.0)),
                     stored_row(3, second, 8.0, "conditional fail", film_limits_text(2.0)),
                     stored_row(4, second, 9.0, "pass", film_limits_text(2.0)),
                     stored_row(1, second, 9.0, "fail", film_limits_text(2.0))};
  const bench::Judgement both = made.judged(
      {film_evaluation(1, 0.25), film_evaluation(2, 0.5), film_evaluation(3, 0.75)}, film_limits(1.0), false, stored);
  CHECK(film_mean_words(both.verdicts) ==
        "2 mean_compensation_error 6 of 7: pass; 3 mean_compensation_error 0.75 of 1: pass; ");
  CHECK(both.verdicts.size() == 5);
  CHECK(film_mean_words(both.notes.stored_worse) == "3 mean_compensation_error 8 of 7: conditional fail; ");
  // One that is as bad is no worse.
  const bench::Judgement failed = made.judged({film_evaluation(3, 2.0)}, film_limits(1.0), false, stored);
  CHECK(failed.notes.stored_worse.empty());
}

TEST_CASE("stored judgement: rows of all fits with the same models, the newest limits, and what no longer counts") {
  JudgedStore made(5);
  const analysis::SensorModel models = film_line_model(), others = film_line_model(0.03125);
  CHECK(made.kept(models) == "||");
  CHECK(made.kept({}) == "||");
  const std::int64_t other = made.keep(others);
  made.judge(2, other, 0.5, "pass", film_limits_text(1.0, "simple", "of others"));
  CHECK(made.kept(models) == "||of others|lost");
  const std::int64_t first = made.keep(models), second = made.keep(models);
  made.judge(4, first, 0.25, "pass");
  made.judge(3, second, 0.75, "fail", film_limits_text(1.0, "simple", "b"));
  made.judge(1, second, 0.125, "inconclusive", film_limits_text(1.0, "simple", "c"));
  made.judge(4, second, 0.5, "pass", film_limits_text(1.0, "simple", "d"));
  CHECK(made.kept(models) ==
        "4 mean_compensation_error 0.25 of 1: pass; 3 mean_compensation_error 0.75 of 1: fail; 1 "
        "mean_compensation_error 0.125 of 1: inconclusive; 4 mean_compensation_error 0.5 of 1: pass; | 3 4|d");
  CHECK(made.kept(others) == "2 mean_compensation_error 0.5 of 1: pass; | 2|of others");
  made.declare_void(4);
  const std::string left =
      "3 mean_compensation_error 0.75 of 1: fail; 1 mean_compensation_error 0.125 of 1: inconclusive; | 3|d";
  CHECK(made.kept(models) == left + "|lost");
  CHECK_THAT(made.kept(models, true), Catch::EndsWith("| 3 4|d"));
  analysis::SensorModel kept = models;
  kept.fit = first;
  CHECK_THAT(made.kept(kept), Catch::StartsWith(left));
  // A run that lag or creep was taken from is no independent data.
  kept.dynamics.emplace();
  kept.dynamics->rate.run = 3;
  kept.fit = second;
  CHECK_THAT(made.kept(kept), Catch::StartsWith("1 mean_compensation_error 0.125 of 1: inconclusive; ||"));
}

TEST_CASE("judged and stored: rows of each run with the fit, none by a file that only reports, worse ones of before") {
  JudgedStore made(3);
  analysis::SensorModel models = film_line_model();
  models.fit = made.keep(models);
  write_file(made.path("a.toml"), film_limits_text(1.0));
  write_file(made.path("b.toml"), film_limits_text(10.0, "simple", "b"));
  write_file(made.path("r.toml"), film_limits_text(1.0, "report-only", "r"));
  const std::vector<bench::NamedEvaluation> all = {film_evaluation(1, 0.25), film_evaluation(2, 0.5),
                                                   film_evaluation(3, 2.0)};
  const auto judge = [&](const std::string& file, const std::vector<analysis::InstrumentNote>& notes = {}) {
    analysis::Runs runs(made.store);
    return bench::judge_and_store(made.store, runs, models, all, made.path(file), false, notes);
  };
  CHECK(film_mean_words(judge("r.toml").verdicts) ==
        "2 mean_compensation_error 0.5 of 1: report only; 3 mean_compensation_error 2 of 1: report only; ");
  CHECK(made.store.verdicts_of_models(1).empty());
  CHECK(judge("a.toml").notes.stored_worse.empty());
  CHECK(film_mean_words(made.store.verdicts(2)) == "2 mean_compensation_error 0.5 of 1: pass; ");
  CHECK(made.store.verdicts(2).size() == 4);
  CHECK(film_mean_words(made.store.verdicts(3)) == "3 mean_compensation_error 2 of 1: fail; ");
  CHECK(made.store.verdicts(3)[0].fit == models.fit);
  CHECK(made.store.verdicts(1).empty());
  const bench::Judgement later = judge("b.toml");
  CHECK(film_mean_words(later.verdicts) ==
        "2 mean_compensation_error 0.5 of 10: pass; 3 mean_compensation_error 2 of 10: pass; ");
  CHECK(film_mean_words(later.notes.stored_worse) == "3 mean_compensation_error 2 of 1: fail; ");
  // The laboratory knows that the reference was overdue.
  const bench::Judgement withheld = judge("b.toml", {{"R-1", "", "", "", "2026-02-01", ""}});
  CHECK(film_mean_words(withheld.verdicts) ==
        "2 mean_compensation_error 0.5 of 10: inconclusive; 3 mean_compensation_error 2 of 10: inconclusive; ");
  CHECK(film_mean_words(made.store.verdicts(2)) ==
        "2 mean_compensation_error 0.5 of 1: pass; 2 mean_compensation_error 0.5 of 10: inconclusive; ");
  REQUIRE(withheld.notes.remarks.size() == 2);
  CHECK_THAT(withheld.notes.remarks[1], Catch::Contains("2026-02-01") && Catch::Contains("run 3"));
  CHECK_THAT(withheld.notes.untraced, Catch::Contains("2026-02-01"));
}

TEST_CASE("judged for a report: by the file named, else by the limits last used, else not at all") {
  JudgedStore made(2);
  analysis::Runs runs(made.store);
  write_file(made.path("b.toml"), film_limits_text(0.125, "simple", "b"));
  bench::StoredJudgement stored;
  const auto judged = [&](const std::string& file) {
    return film_mean_words(
        bench::judge_for_report(runs, film_line_model(), {film_evaluation(2, 0.5)}, file, stored, false).verdicts);
  };
  CHECK(judged("").empty());
  CHECK(judged(made.path("b.toml")) == "2 mean_compensation_error 0.5 of 0.125: fail; ");
  stored.limits_toml = film_limits_text(4.0);
  CHECK(judged("") == "2 mean_compensation_error 0.5 of 4: pass; ");
  CHECK(judged(made.path("b.toml")) == "2 mean_compensation_error 0.5 of 0.125: fail; ");
}

TEST_CASE("evaluations are named: the fit's own, titles as typed, and numbers of the others") {
  JudgedStore made(3);
  analysis::Runs runs(made.store);
  const auto named = bench::evaluate_runs(runs, film_line_model(), {3, 2}, {"warmer"});
  REQUIRE(named.size() == 3);
  CHECK(named[1].title == "warmer");
  CHECK_THAT(named[2].title, Catch::EndsWith("run 2"));
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(named[i].evaluation.run == std::vector<std::int64_t>{1, 3, 2}[i]);
    CHECK(named[i].evaluation.model_run == 1);
    CHECK(named[i].evaluation.frames == 26);
  }
}
