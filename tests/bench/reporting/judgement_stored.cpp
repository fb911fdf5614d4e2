// Verdicts of before beside new ones, and what is stored.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tests/bench/reporting/judged_store.h"

using namespace tactbench;
using namespace tactbench::tests;

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
    return bench::judge_and_store(made.store, runs, models, all, made.path(file), false, notes).judgement;
  };
  CHECK(film_mean_words(judge("r.toml").figures) ==
        "2 mean_compensation_error 0.5 of 1: report only; 3 mean_compensation_error 2 of 1: report only; ");
  CHECK(made.store.verdicts_of_models(1).empty());
  CHECK(judge("a.toml").stored_worse.empty());
  CHECK(film_mean_words(made.store.verdicts(2)) == "2 mean_compensation_error 0.5 of 1: pass; ");
  CHECK(made.store.verdicts(2).size() == 4);
  CHECK(film_mean_words(made.store.verdicts(3)) == "3 mean_compensation_error 2 of 1: fail; ");
  CHECK(made.store.verdicts(3)[0].fit == models.fit);
  CHECK(made.store.verdicts(3)[0].limits_toml == film_limits_text(1.0));
  CHECK(made.store.verdicts(1).empty());
  const analysis::Judgement later = judge("b.toml");
  CHECK(film_mean_words(later.figures) ==
        "2 mean_compensation_error 0.5 of 10: pass; 3 mean_compensation_error 2 of 10: pass; ");
  CHECK(film_mean_words(later.stored_worse) == "3 mean_compensation_error 2 of 1: fail; ");
  CHECK(later.overall == analysis::Verdict::kFail);
  // The laboratory knows that the reference was overdue.
  const analysis::Judgement withheld = judge("b.toml", {{"R-1", "", "", "", "2026-02-01", ""}});
  CHECK(film_mean_words(withheld.figures) ==
        "2 mean_compensation_error 0.5 of 10: inconclusive; 3 mean_compensation_error 2 of 10: inconclusive; ");
  CHECK(film_mean_words(made.store.verdicts(2)) ==
        "2 mean_compensation_error 0.5 of 1: pass; 2 mean_compensation_error 0.5 of 10: inconclusive; ");
  REQUIRE(withheld.remarks.size() == 2);
  CHECK((withheld.remarks[1].run == 3 && withheld.remarks[1].untraced->overdue_since == "2026-02-01"));
  // Without its file the stored verdict stands; judged again without it, it is replaced.
  analysis::Runs runs(made.store);
  const bench::StoredVerdicts stored = bench::stored_verdicts(runs, models, false);
  CHECK(film_mean_words(
            bench::judge_for_report(runs, models, all, made.path("b.toml"), false, {}, stored).judgement.figures) ==
        film_mean_words(withheld.figures));
  CHECK(film_mean_words(judge("b.toml").figures) == film_mean_words(later.figures));
}

TEST_CASE("judged for a report: by the file named, else by the limits last used, else not at all") {
  JudgedStore made(2);
  analysis::Runs runs(made.store);
  write_file(made.path("b.toml"), film_limits_text(0.125, "simple", "b"));
  bench::StoredVerdicts stored;
  const auto judged = [&](const std::string& file) {
    return film_mean_words(
        bench::judge_for_report(runs, film_line_model(), {film_evaluation(2, 0.5)}, file, false, {}, stored)
            .judgement.figures);
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
