// Which runs are gathered as evidence and what is measured on them, on evaluations and models that are known by hand.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "bench/reporting/judgement.h"
#include "tests/bench/reporting/film_runs.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

// Of each run: "own", "void", "asked" or "yes", and whether its figures were gathered.
std::string counted_runs(const analysis::Evidence& evidence) {
  std::string text;
  for (const analysis::EvidenceRun& run : evidence.runs) {
    const char* const words[] = {"yes", "asked", "void", "own"};
    text += fmt::format("{} {}{}; ", run.run, words[static_cast<int>(run.counts)], run.figures.empty() ? "" : " +");
  }
  return text;
}

}  // namespace

TEST_CASE("evidence: held-out runs count, the run of the models itself only if there is no other") {
  const JudgedStore made(3);
  const auto own = film_evaluation(1, 0.25), second = film_evaluation(2, 0.5), third = film_evaluation(3, 2.0);
  CHECK(made.evidence({}).runs.empty());
  const analysis::Evidence both = made.evidence({own, third, second});
  CHECK(counted_runs(both) == "1 own; 3 yes +; 2 yes +; ");
  CHECK((both.model_run == 1 && both.models_void.empty()));
  CHECK(both.runs[1].figures[0].value == 2.0);
  CHECK(both.runs[1].figures[1].value == 3.0);
  CHECK(counted_runs(made.evidence({own})) == "1 own +; ");
  analysis::SensorModel with_creep = film_line_model();
  with_creep.dynamics.emplace();
  with_creep.dynamics->creep.run = 2;
  CHECK(counted_runs(made.evidence({own, third, second}, false, {}, with_creep)) == "1 own; 3 yes +; 2 own; ");
}

TEST_CASE("evidence: without a certificate U of an error is unknown, U of a difference is known") {
  const JudgedStore made(2);
  const std::vector<analysis::Figure> figures = made.evidence({film_evaluation(2, 0.5)}).runs[0].figures;
  REQUIRE(figures.size() > 4);
  CHECK(std::isnan(figures[0].u.expanded));
  CHECK_FALSE(figures[0].u.missing.empty());
  CHECK(std::isfinite(figures[2].u.expanded));
  CHECK(figures[3].u.expanded == 0.0);
}

TEST_CASE("evidence: a void run is listed with its reason, and counted only on request") {
  JudgedStore made(3);
  made.declare_void(3);
  const std::vector<bench::NamedEvaluation> all = {film_evaluation(1, 0.25), film_evaluation(3, 2.0),
                                                   film_evaluation(2, 0.5)};
  const analysis::Evidence without = made.evidence(all);
  CHECK(counted_runs(without) == "1 own; 3 void; 2 yes +; ");
  CHECK(without.runs[1].voided.reason == "gauge closed");
  CHECK(counted_runs(made.evidence(all, true)) == "1 own; 3 asked +; 2 yes +; ");
  made.declare_void(1);
  const analysis::Evidence by_void = made.evidence(all);
  REQUIRE(by_void.models_void.size() == 1);
  CHECK(counted_runs(by_void) == "1 own +; 3 void; 2 yes; ");
  CHECK(counted_runs(made.evidence(all, true)) == "1 own; 3 asked +; 2 yes +; ");
}

TEST_CASE("evidence: the reference data are those on the day of the run, updated by a laboratory file") {
  JudgedStore made(1);
  FilmRun dated;
  dated.calibration = R"({"calibrated":"2019-01-01","due":"2020-01-01"})";
  REQUIRE(made.add(dated) == 2);
  REQUIRE(made.add() == 3);
  FilmRun undated;
  undated.calibration = R"({"calibrated":"","due":""})";
  REQUIRE(made.add(undated) == 4);
  const auto of = [&](std::int64_t run, const std::vector<analysis::InstrumentNote>& notes = {}) {
    return made.evidence({film_evaluation(run, 0.5)}, false, notes).runs[0];
  };
  CHECK(of(2).reference.overdue);
  CHECK_FALSE(of(3).reference.overdue);
  CHECK(of(3, {{"R-1", "", "", "", "2026-02-01", ""}}).reference.untraced()->overdue_since == "2026-02-01");
  CHECK(of(2).shows.contains(analysis::Source::kReferenceAge));
  CHECK_FALSE(of(4).shows.contains(analysis::Source::kReferenceAge));
  CHECK(of(4, {{"R-1", "", "", "", "2027-02-01", ""}}).shows.contains(analysis::Source::kReferenceAge));
}

// Earlier verdicts together with new ones, and the stored rows.

TEST_CASE(
    "stored judgement: has verdicts of all fits with the same models and the newest limits, marks lost evidence") {
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

TEST_CASE(
    "judge: verdicts of each run are stored with the fit, except by report-only limits, earlier worse ones count") {
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
  CHECK(film_mean_text(judge("r.toml").figures) ==
        "2 mean_compensation_error 0.5 of 1: report only; 3 mean_compensation_error 2 of 1: report only; ");
  CHECK(made.store.verdicts_of_models(1).empty());
  CHECK(judge("a.toml").stored_worse.empty());
  CHECK(film_mean_text(made.store.verdicts(2)) == "2 mean_compensation_error 0.5 of 1: pass; ");
  CHECK(made.store.verdicts(2).size() == 4);
  CHECK(film_mean_text(made.store.verdicts(3)) == "3 mean_compensation_error 2 of 1: fail; ");
  CHECK(made.store.verdicts(3)[0].fit == models.fit);
  CHECK(made.store.verdicts(3)[0].limits_toml == film_limits_text(1.0));
  CHECK(made.store.verdicts(1).empty());
  const analysis::Judgement later = judge("b.toml");
  CHECK(film_mean_text(later.figures) ==
        "2 mean_compensation_error 0.5 of 10: pass; 3 mean_compensation_error 2 of 10: pass; ");
  CHECK(film_mean_text(later.stored_worse) == "3 mean_compensation_error 2 of 1: fail; ");
  CHECK(later.overall == analysis::Verdict::kFail);
  // The laboratory knows that the reference was overdue.
  const analysis::Judgement withheld = judge("b.toml", {{"R-1", "", "", "", "2026-02-01", ""}});
  CHECK(film_mean_text(withheld.figures) ==
        "2 mean_compensation_error 0.5 of 10: inconclusive; 3 mean_compensation_error 2 of 10: inconclusive; ");
  CHECK(film_mean_text(made.store.verdicts(2)) ==
        "2 mean_compensation_error 0.5 of 1: pass; 2 mean_compensation_error 0.5 of 10: inconclusive; ");
  REQUIRE(withheld.remarks.size() == 2);
  CHECK((withheld.remarks[1].run == 3 && withheld.remarks[1].untraced->overdue_since == "2026-02-01"));
  // Without its file the stored verdict is kept; judged again without it, it is replaced.
  analysis::Runs runs(made.store);
  const bench::StoredVerdicts stored = bench::stored_verdicts(runs, models, false);
  CHECK(film_mean_text(
            bench::judge_for_report(runs, models, all, made.path("b.toml"), false, {}, stored).judgement.figures) ==
        film_mean_text(withheld.figures));
  CHECK(film_mean_text(judge("b.toml").figures) == film_mean_text(later.figures));
}

TEST_CASE("report judgement: by the named limits file, or by the last used limits, or none") {
  JudgedStore made(2);
  analysis::Runs runs(made.store);
  write_file(made.path("b.toml"), film_limits_text(0.125, "simple", "b"));
  bench::StoredVerdicts stored;
  const auto judged = [&](const std::string& file) {
    return film_mean_text(
        bench::judge_for_report(runs, film_line_model(), {film_evaluation(2, 0.5)}, file, false, {}, stored)
            .judgement.figures);
  };
  CHECK(judged("").empty());
  CHECK(judged(made.path("b.toml")) == "2 mean_compensation_error 0.5 of 0.125: fail; ");
  stored.limits_toml = film_limits_text(4.0);
  CHECK(judged("") == "2 mean_compensation_error 0.5 of 4: pass; ");
  CHECK(judged(made.path("b.toml")) == "2 mean_compensation_error 0.5 of 0.125: fail; ");
}

TEST_CASE("evaluations: the run of the fit comes first, others are titled as typed or by run number") {
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

// Which stored verdicts stand, which of them decides, and what is said of the others: on runs and fits stored by hand.

namespace {

class StandingByHand : public tests::FilmStore {
 public:
  void add_runs(int count) {
    for (int i = 0; i < count; ++i) (void)add();
  }
  std::int64_t add_fit(std::int64_t run, const std::string& model = "elam") {
    db::FitRecord fit;
    fit.run = run;
    fit.model = model;
    return store.add_fit(fit);
  }
  void judge(std::int64_t run, std::int64_t fit, const std::string& limits, const std::vector<std::string>& words) {
    std::vector<db::VerdictRecord> rows;
    for (const std::string& word : words) {
      db::VerdictRecord row;
      row.criterion = to_string(static_cast<analysis::Criterion>(rows.size()));
      row.verdict = word;
      row.limits_toml = tests::film_limits_text(1.0, "simple", limits);
      row.limits_sha256 = db::sha256_hex(limits);
      rows.push_back(row);
    }
    store.replace_verdicts(run, fit, rows);
  }
  void declare_void(std::int64_t run) { store.void_run(run, "gauge closed", "me", "2026-03-02T00:00:00Z"); }
  // "run on models' run: verdict; "
  [[nodiscard]] std::string standing(std::int64_t run) const {
    return display_text(bench::standing(store, run).figures);
  }
  [[nodiscard]] std::string decided(std::int64_t run) const {
    return analysis::verdict_text(bench::standing(store, run).verdict);
  }
  static std::string display_text(const std::vector<analysis::JudgedFigure>& rows) {
    std::string text;
    for (const analysis::JudgedFigure& row : rows)
      text += fmt::format("{} on {}: {}; ", row.run, row.model_run, to_string(row.verdict));
    return text;
  }
  // The judgement on that run: its rows, worse ones, and whether it is none.
  [[nodiscard]] std::string judgement(std::int64_t run) const {
    const analysis::Judgement found = bench::judgement_on(store, run);
    return fmt::format("{}| {}| {}", display_text(found.figures), display_text(found.stored_worse),
                       found.not_judged ? "not judged" : "");
  }
};

}  // namespace

TEST_CASE("valid verdicts: those on a run, and those on other runs by its models") {
  StandingByHand made;
  made.add_runs(4);
  const std::int64_t fit = made.add_fit(1), other = made.add_fit(4);
  CHECK(made.standing(1).empty());
  CHECK(made.decided(1).empty());
  CHECK(made.judgement(1) == "| | ");
  made.judge(2, fit, "a", {"pass", "fail"});
  made.judge(3, fit, "a", {"pass"});
  made.judge(2, other, "a", {"pass"});
  CHECK(made.standing(1) == "2 on 1: pass; 2 on 1: fail; 3 on 1: pass; ");
  CHECK(made.standing(2) == "2 on 1: pass; 2 on 1: fail; 2 on 4: pass; ");
  CHECK(made.standing(3) == "3 on 1: pass; ");
  CHECK(made.standing(4) == "2 on 4: pass; ");
  CHECK(made.decided(1) == "fail");
  CHECK(made.decided(3) == "pass");
  CHECK(made.decided(4) == "pass");
}

TEST_CASE("valid verdicts: on the run of the models they are inconclusive, and count only without independent ones") {
  StandingByHand made;
  made.add_runs(3);
  const std::int64_t fit = made.add_fit(1);
  made.judge(1, fit, "a", {"pass", "fail"});
  CHECK(made.standing(1) == "1 on 1: inconclusive; 1 on 1: inconclusive; ");
  CHECK(made.decided(1) == "inconclusive");
  CHECK(made.judgement(1) == "1 on 1: inconclusive; 1 on 1: inconclusive; | | not judged");
  made.judge(2, fit, "a", {"pass"});
  CHECK(made.standing(1) == "2 on 1: pass; ");
  CHECK(made.standing(2) == "2 on 1: pass; ");
  CHECK(made.judgement(2) == "2 on 1: pass; | | ");
  // A verdict on run 1 by the models of another run is independent of its own models, and takes nothing away.
  const std::int64_t other = made.add_fit(3);
  made.judge(1, other, "a", {"fail"});
  CHECK(made.standing(1) == "1 on 3: fail; 2 on 1: pass; ");
}

TEST_CASE("valid verdicts: a void run and models of a void run have no verdict") {
  StandingByHand made;
  made.add_runs(4);
  const std::int64_t fit = made.add_fit(1), other = made.add_fit(4);
  made.judge(2, fit, "a", {"pass"});
  made.judge(3, fit, "a", {"fail"});
  made.judge(2, other, "a", {"fail"});
  made.declare_void(3);
  CHECK(made.standing(1) == "2 on 1: pass; ");
  CHECK(made.standing(3).empty());
  CHECK(made.judgement(3) == "| | not judged");
  made.declare_void(4);
  CHECK(made.standing(2) == "2 on 1: pass; ");
  CHECK(made.standing(4).empty());
  made.declare_void(1);
  CHECK(made.standing(1).empty());
  CHECK(made.standing(2).empty());
  CHECK(made.judgement(2) == "| | not judged");
}

TEST_CASE("valid verdicts: with several limits or fits the newest decide, but a fail by any counts") {
  StandingByHand made;
  made.add_runs(2);
  const std::int64_t fit = made.add_fit(1);
  made.judge(2, fit, "a", {"inconclusive", "pass"});
  made.judge(2, fit, "b", {"pass"});
  CHECK(made.decided(2) == "pass");
  CHECK(made.judgement(2) == "2 on 1: pass; | 2 on 1: inconclusive; | ");
  made.judge(2, fit, "c", {"conditional pass", "pass"});
  CHECK(made.decided(2) == "conditional pass");
  made.judge(2, fit, "d", {"fail"});
  made.judge(2, fit, "e", {"pass"});
  CHECK(made.decided(2) == "fail");
  CHECK(made.judgement(2) == "2 on 1: pass; | 2 on 1: inconclusive; 2 on 1: conditional pass; 2 on 1: fail; | ");
  StandingByHand twice;
  twice.add_runs(2);
  const std::int64_t first = twice.add_fit(1, "gpi"), second = twice.add_fit(1);
  twice.judge(2, first, "a", {"fail"});
  twice.judge(2, second, "a", {"pass", "pass"});
  CHECK(twice.judgement(2) == "2 on 1: pass; 2 on 1: pass; | 2 on 1: fail; | ");
}

TEST_CASE("valid verdicts: a pass rests on means only if no requirement is for single readings") {
  StandingByHand made;
  made.add_runs(2);
  const std::int64_t fit = made.add_fit(1);
  const auto alone = [&] { return bench::standing(made.store, 2).rests_on_means_alone; };
  CHECK_FALSE(alone());
  made.judge(2, fit, "a", {"pass", "conditional pass"});
  CHECK(alone());
  made.judge(2, fit, "b", {"pass", "pass", "pass", "pass", "pass", "pass"});  // the last one is mpe
  CHECK_FALSE(alone());
  made.judge(2, fit, "c", {"fail"});
  CHECK_FALSE(alone());
}
