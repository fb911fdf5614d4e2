// verify, result by result: fits and verdicts that follow from their runs, and those that do not.
// On runs of one taxel that are stored by hand.
#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/common/error.h"
#include "bench/reporting/evaluation.h"
#include "tests/bench/reporting/film_runs.h"
#include "tests/bench/reporting/verified_store.h"

using namespace tactbench;
using namespace tactbench::tests;

TEST_CASE("verify results: refitting a run reproduces its stored fits bit for bit") {
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

TEST_CASE("verify results: a fit of one of two sequences is repeated with that sequence only") {
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

TEST_CASE("verify results: a fit by another or an unknown build is compared within 1e-12") {
  VerifiedStore made;
  (void)made.add(film_inner_loops());
  const analysis::SensorModel models = analysis::fit_array(analysis::load_dataset(made.store, 1));
  (void)analysis::store_fit(made.store, models, "1", "2026-03-01T02:00:00Z", "commit 12");
  (void)analysis::store_fit(made.store, models, "1", "2026-03-01T02:00:00Z");
  CHECK(made.verified(1) == VerifiedLines{"1 of 1, elam, 3: holds", "2 of 1, elam, 3: holds"});
  for (const bench::VerifiedResult& result : made.results(1)) CHECK(result.compared.starts_with("1e-12"));
  CHECK_THAT(made.results(1)[0].compared, Catch::Contains("commit 12") && Catch::Contains(bench::this_build()));
}

TEST_CASE("verify results: a fit with other values differs, and the first difference is named") {
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

TEST_CASE("verify results: a damaged model document counts as a difference") {
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

TEST_CASE("verify results: verdicts on a held-out run and on the run of the models, by each limits file") {
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

TEST_CASE("verify results: an altered limits file is a difference, verdicts without a fit are not recomputed") {
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

TEST_CASE("verify results: an overdue reference is recognised from a laboratory file, or from the date of the run") {
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

// verify, result by result: what cannot be worked out again since runs have changed, lost their frames or are not in
// the store, and dynamic models, which rest on several runs.

TEST_CASE("verify results: models of a changed run or a run without frames are not used to judge again") {
  VerifiedStore made;
  for (int i = 0; i < 3; ++i) (void)made.add(film_inner_loops());
  made.judge(made.fitted(1), {2, 3});
  made.prune(3);
  CHECK(made.verified(3) == VerifiedLines{"1 of 1, verdicts, 4: left"});
  made.change("UPDATE frames SET status = 9 WHERE frame = (SELECT min(frame) FROM frames)");  // of run 1
  CHECK(made.verified(2) == VerifiedLines{"1 of 1, verdicts, 4: differs"});
  CHECK_THAT(made.results(2)[0].difference, Catch::Contains("run 1,") && Catch::Contains("frame 1 "));
  CHECK_FALSE(made.results(2)[0].recomputed);
  const bench::RunVerification own = bench::verify_run(made.store, 1);
  CHECK_FALSE(own.content.holds());
  CHECK(own.results.empty());
  CHECK(own.first_difference == own.content.difference);
}

TEST_CASE("verify results: fits of a run without frames are not repeated, and the date of pruning is stated") {
  VerifiedStore made;
  for (int i = 0; i < 2; ++i) (void)made.add(film_inner_loops());
  made.judge(made.fitted(1), {2});
  made.prune(1);
  CHECK(made.verified(1) == VerifiedLines{"1 of 1, elam, 0: left"});
  CHECK(made.verified(2) == VerifiedLines{"1 of 1, verdicts, 4: left"});
  for (const std::int64_t run : {1, 2})
    CHECK_THAT(made.results(run)[0].compared, Catch::Contains("run 1,") && Catch::Contains("2026-04-01T00:00:00Z"));
}

TEST_CASE("verify results: a broken seal is reported as first difference if the results agree") {
  VerifiedStore made;
  (void)made.add(film_inner_loops());
  (void)made.fitted(1);
  made.store.add_report({1, "1-a", "h", "K. Lee", "2026-03-02T00:00:00Z", "", ""});
  made.change("UPDATE reports SET approved_by = 'B'");
  const bench::RunVerification verified = bench::verify_run(made.store, 1);
  REQUIRE(verified.changed_records.size() == 1);
  CHECK(verified.first_difference == verified.changed_records[0]);
}

TEST_CASE("verify results: a dynamic model needs its runs of lag and creep, found by content hash") {
  VerifiedStore made;
  for (int i = 0; i < 3; ++i) (void)made.add(film_inner_loops());
  const analysis::SensorModel alone = [&] {
    analysis::Runs runs(made.store);
    return bench::fit_run_dynamic(made.store, runs, 1);
  }();
  CHECK(made.verified(1) == VerifiedLines{"1 of 1, dynamic, 3: holds"});
  const auto verified_with = [&](std::int64_t run, const std::string& content, bool creep) {
    analysis::SensorModel with = alone;
    analysis::SensorDynamics::Source& source = creep ? with.dynamics->creep : with.dynamics->rate;
    source.run = run;
    source.content_sha256 = content;
    const std::int64_t fit = bench::keep_fit(made.store, with);
    for (const bench::VerifiedResult& result : made.results(1))
      if (result.fit == fit) return result;
    return bench::VerifiedResult();
  };
  made.prune(3);
  const std::string none = std::string(64, '0'), third = made.store.run(3).content_sha256;
  struct Row {
    std::int64_t run;
    std::string content;
    bool creep;
    std::vector<std::string> told;
  };
  for (const Row& row : {Row{77, none, false, {"lag", "run 77", "000000000000"}},
                         Row{78, none, true, {"creep", "run 78", "000000000000"}},
                         Row{77, third, false, {"lag", "run 3"}}, Row{3, "", true, {"creep", "run 3"}}}) {
    const bench::VerifiedResult result = verified_with(row.run, row.content, row.creep);
    INFO(result.compared);
    CHECK((result.what == "dynamic" && !result.recomputed && result.difference.empty()));
    for (const std::string& told : row.told) CHECK(result.compared.find(told) != std::string::npos);
  }
  // Made with one of the two alone, as no program does: made again without either.
  CHECK(verified_with(2, made.store.run(2).content_sha256, false).recomputed);
  made.change("UPDATE frames SET status = 9 WHERE frame = (SELECT max(frame) FROM frames)");  // of run 2
  CHECK_THAT(verified_with(2, made.store.run(2).content_sha256, true).difference,
             Catch::Contains("run 2,") && Catch::EndsWith("[TB-ANALYSIS-FRAME]"));
}

TEST_CASE("verify results: a dynamic model without sources and models of an imported table are not recomputed") {
  VerifiedStore made;
  (void)made.add(film_inner_loops());
  analysis::FitOptions options;
  options.model = "monotone";
  db::FitRecord record;
  record.run = 1;
  record.model = "dynamic";
  record.document = analysis::to_line(analysis::fit_array(analysis::load_dataset(made.store, 1), options));
  (void)made.store.add_fit(record);
  CHECK(made.verified(1) == VerifiedLines{"1 of 1, dynamic, 0: left"});
  FilmRun table = film_inner_loops();
  table.origin = "imported";
  record.run = made.add(table);
  record.model = "monotone";
  (void)made.store.add_fit(record);
  CHECK(made.verified(2) == VerifiedLines{"2 of 2, monotone, 0: left"});
}

// A whole report on runs of one taxel that are stored by hand: its input with uncertainties and earlier models, its
// file, and where that goes when a signed report stands in its place. Not a unit test: models are compared by several
// threads.

namespace {

// Run 1 with models, judged on run 2.
struct WrittenStore : JudgedStore {
  WrittenStore() : JudgedStore(2) { write_file(path("before.json"), analysis::to_text(film_line_model(0.125))); }
  [[nodiscard]] bench::JudgementRecord judged(const analysis::Limits& limits) {
    bench::JudgementRecord out{bench::gather_evidence(runs, models, evaluations, limits, false), limits, {}};
    out.judgement = analysis::judge(out.evidence, limits);
    return out;
  }
  analysis::Runs runs{store};
  analysis::SensorModel models = film_line_model();
  std::vector<bench::NamedEvaluation> evaluations = bench::evaluate_runs(runs, models, {2});
};

}  // namespace

TEST_CASE("report input: with all extras it has uncertainties, conditions of the budget and as-found results") {
  WrittenStore made;
  FilmRun mounted;
  mounted.set = {{"simulation.mount_seed", "1"}};
  (void)made.add(mounted);
  bench::ReportExtras extras;
  extras.previous = made.path("before.json");
  extras.studies = {"3:mount"};
  const analysis::ReportInput input =
      bench::report_input(made.runs, 1, made.models, made.evaluations, made.judged(film_limits(10.0)), {}, &extras);
  REQUIRE(input.uncertainty);
  REQUIRE_FALSE(input.judgement.figures.empty());
  for (const analysis::JudgedFigure& one : input.judgement.figures) CHECK(one.run == 2);
  // The study of mounts is in the budget.
  const auto& open = input.judgement.not_assessed;
  CHECK(std::ranges::find(open, analysis::Source::kRemounting) == open.end());
  CHECK(std::ranges::find(open, analysis::Source::kTemperature) != open.end());
  CHECK(input.more.studies.remount.runs == std::vector<std::int64_t>{1, 3});
  REQUIRE(input.more.previous);
  CHECK(input.more.previous->model == extras.previous);
  CHECK(film_mean_text(input.more.previous->judgement.figures).ends_with(": fail; "));
  CHECK_FALSE(input.more.previous->doubt.empty());
  // Of a run that the models were not made from, no uncertainty is stated.
  const analysis::ReportInput other =
      bench::report_input(made.runs, 2, made.models, made.evaluations, made.judged(film_limits(10.0)));
  CHECK_FALSE(other.uncertainty);
}

TEST_CASE("report: the default path is named by the run, or by the report number if a signed report has that path") {
  WrittenStore made;
  const bench::JudgementRecord judgement = made.judged(film_limits(10.0));
  std::string number;
  const std::string usual = made.path("reports/run-1.html");
  CHECK(bench::write_report(made.runs, made.models, made.evaluations, judgement, "", &number) == usual);
  CHECK(number.starts_with("1-"));
  const std::string page = read_file(usual);
  CHECK(page.find(number) != std::string::npos);
  const std::string own = made.path("own.html");
  CHECK(bench::write_report(made.runs, made.models, made.evaluations, judgement, own, nullptr) == own);
  CHECK(read_file(own) == page);
  write_file(usual, R"({"number":"R-7","identification":{"approvals":[{"number":"R-7"}]}})");
  const std::string numbered = made.path("reports/run-" + number + ".html");
  CHECK(bench::write_report(made.runs, made.models, made.evaluations, judgement, "", &number) == numbered);
  CHECK(read_file(numbered) == page);
  // The report itself, signed, stays as it is.
  const std::string kept =
      R"({"number":")" + number + R"(","identification":{"approvals":[{"number":")" + number + R"("}]}})";
  write_file(own, kept);
  CHECK(bench::write_report(made.runs, made.models, made.evaluations, judgement, own, nullptr) == own);
  CHECK(read_file(own) == kept);
  write_file(own, "dear diary");
  CHECK_THROWS_AS(bench::write_report(made.runs, made.models, made.evaluations, judgement, own, nullptr), bench::Error);
  CHECK(bench::write_report(made.runs, made.models, made.evaluations, judgement, own, nullptr, {}, true) == own);
  CHECK(read_file(own) == page);
}
