// Whether a sensor drifted, by which models and since when; its verdict and until when it counts.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "analysis/identify/stored/model_document.h"
#include "bench/common/error.h"
#include "bench/reporting/evaluation.h"
#include "bench/reporting/evidence.h"
#include "bench/reporting/report_results.h"
#include "bench/reporting/sensor_state.h"
#include "bench/reporting/signed_reports.h"
#include "db/run_store.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/bench/reporting/film_runs.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

struct SensorOverTime : FilmStore {
  void measure(const std::string& day, double zero_v = 0.0) {
    FilmRun run;
    run.started_utc = day + "T00:00:00Z";
    run.error_v = [zero_v](int, int, double) { return zero_v; };
    (void)add(run);
  }
  analysis::SensorModel fit(std::int64_t run) {
    analysis::Runs runs(store);
    return bench::fit_run(store, runs.dataset(run));
  }
  void judge(std::int64_t run, std::int64_t fit) {
    db::VerdictRecord row;
    row.verdict = "pass";
    row.limits_toml = film_limits_text(1.0);
    row.limits_sha256 = db::sha256_hex(row.limits_toml);
    store.replace_verdicts(run, fit, {row});
  }
  [[nodiscard]] bench::SensorState state(const analysis::Laboratory& laboratory = {}) const {
    return bench::sensor_state(store, "S-1", laboratory);
  }
};

}  // namespace

TEST_CASE("sensor state: drift is judged by the models before the newest run, since the first drifted run") {
  SensorOverTime made;
  CHECK(made.state().runs.empty());
  CHECK_FALSE(made.state().drift);
  made.measure("2026-03-01");
  const analysis::SensorModel first = made.fit(1);
  CHECK_FALSE(made.state().drift);  // nothing later to check
  made.measure("2026-03-02");
  const auto sound = made.state().drift;
  REQUIRE(sound);
  CHECK((sound->run == 2 && sound->model_run == 1));
  CHECK_FALSE(sound->drift.drifted());
  CHECK(std::abs(sound->drift.zero) <= sound->drift.zero_u);
  CHECK(sound->since_utc.empty());
  made.measure("2026-06-01", 0.1);
  made.measure("2026-06-02", 0.1);
  const auto off = made.state().drift;
  REQUIRE(off);
  CHECK((off->run == 4 && off->model_run == 1));
  CHECK(off->since_utc == "2026-06-01T00:00:00Z");
  CHECK(off->drift.verdict == analysis::DriftVerdict::kZero);
  const double zero = 0.1 / first.taxels.front().fit.full_scale;
  CHECK(off->drift.zero == Approx(zero).margin(off->drift.zero_u));
  CHECK(off->drift.zero_u < 0.2 * zero);
  const auto adjusts = [&] { return drift_text(made.state()).find("model adjust 1 4 --zero ") != std::string::npos; };
  CHECK(adjusts());
  // Calibrated again: run 4 is held out for the new models, and still shows how the sensor was found.
  const analysis::SensorModel second = made.fit(3);
  made.judge(4, second.fit);
  CHECK(made.state().drift->model_run == 1);
  CHECK(made.state().drift->drift.drifted());
  CHECK_FALSE(adjusts());
  made.measure("2026-06-03", 0.1);
  const auto later = made.state().drift;
  CHECK((later->run == 5 && later->model_run == 3));
  CHECK_FALSE(later->drift.drifted());
  made.store.void_run(5, "gauge closed", "me", "2026-06-04T00:00:00Z");
  CHECK(made.state().drift->run == 4);
}

TEST_CASE("sensor state: the verdict is the newest valid one, and expires as the laboratory file states") {
  SensorOverTime made;
  made.measure("2026-03-01");
  made.measure("2026-03-02");
  CHECK_FALSE(made.state().verdict);
  made.judge(2, made.fit(1).fit);
  made.measure("2026-09-01");
  analysis::Laboratory laboratory;
  laboratory.recalibrate_after_months = 12;
  const bench::SensorState state = made.state(laboratory);
  REQUIRE(state.verdict);
  CHECK(state.verdict->verdict == analysis::Verdict::kPass);
  CHECK(state.judged_run == 2);
  CHECK(state.valid_until == "2027-03-02");
  CHECK(state.runs.size() == 3);
  CHECK(made.state().valid_until.empty());
}

// As found: verdicts on earlier models by the limits of the report, and since when measurements with them are in doubt.

namespace {

// Measurements in doubt: "" none, "all", or since which day.
std::string in_doubt(const analysis::ReportInput& input) {
  const std::string& doubt = input.more.previous->doubt;
  const std::size_t day = doubt.find("20");
  return doubt.empty() ? "" : day == std::string::npos ? "all" : doubt.substr(day, 10);
}

class AsFoundStore : public JudgedStore {
 public:
  AsFoundStore() : JudgedStore(1) {
    write_file(path("before.json"), analysis::to_text(film_line_model(0.03125)));
    for (int i = 0; i < 2; ++i) {
      FilmRun early;
      early.started_utc = "2025-01-01T00:00:00Z";
      (void)add(early);  // 2 and 3, whose models judge the others
      fits_.push_back(keep_of(i + 2));
    }
  }
  // Made on that day and judged so by the models of run 2.
  std::int64_t add_judged(const std::string& started_utc, const std::string& verdict, const std::string& sensor = "S-1",
                          const std::string& origin = "simulated") {
    FilmRun made;
    made.started_utc = started_utc;
    made.sensor = sensor;
    made.origin = origin;
    const std::int64_t run = add(made);
    judge(run, fits_[0], 0.5, verdict);
    return run;
  }
  // The report's run 1, as found with an evaluation that errs so much.
  analysis::ReportInput found(double error_psi, const std::string& limits = film_limits_text(1.0)) {
    analysis::ReportInput input;
    input.run = store.run(1);
    input.judgement.figures.resize(1);
    input.more.previous.emplace();
    input.more.previous->evaluation = film_evaluation(1, error_psi).evaluation;
    analysis::Runs runs(store);
    bench::judge_as_found(runs, input, path("before.json"), bench::parse_limits(limits, "a.toml"));
    return input;
  }
  std::string doubt(double error_psi = 2.0) { return in_doubt(found(error_psi)); }

 private:
  std::int64_t keep_of(std::int64_t run) {
    analysis::SensorModel model = film_line_model();
    model.run = run;
    return keep(model);
  }
  std::vector<std::int64_t> fits_ = {};
};

}  // namespace

TEST_CASE("as found: earlier models are judged by the limits of the report, and results are in doubt if they fail") {
  AsFoundStore made;
  const analysis::ReportInput passed = made.found(0.5);
  CHECK(film_row_text(passed.more.previous->judgement.figures) ==
        "1 mean_compensation_error 0.5 of 1: pass; 1 worst_taxel_error 1.5 of 60: pass; 1 distance_of_mean 0.25 of 1: "
        "pass; 1 unfit_taxels 0 of 1: pass; ");
  CHECK(passed.more.previous->doubt.empty());
  const analysis::ReportInput failed = made.found(2.0);
  CHECK(film_mean_text(failed.more.previous->judgement.figures) == "1 mean_compensation_error 2 of 1: fail; ");
  CHECK(in_doubt(failed) == "all");
  CHECK(made.found(2.0, film_limits_text(1.0, "report-only")).more.previous->doubt.empty());
  analysis::Runs runs(made.store);
  analysis::ReportInput without;
  without.run = made.store.run(1);
  without.judgement.figures.resize(1);
  bench::judge_as_found(runs, without, made.path("none.json"),
                        film_limits(1.0));  // without earlier models nothing is read
  CHECK_FALSE(without.more.previous);
  without.judgement = {};
  without.more.previous.emplace();
  bench::judge_as_found(runs, without, made.path("none.json"), film_limits(1.0));
  CHECK(without.more.previous->judgement.figures.empty());
}

TEST_CASE("as found: without named models, those of the sensor's newest earlier valid run are used, else none") {
  AsFoundStore made;
  const std::int64_t later = made.add_judged("2025-02-01T00:00:00Z", "pass"),
                     other = made.add_judged("2025-02-01T00:00:00Z", "pass", "S-2");
  const auto before = [&](std::int64_t run) {
    analysis::Runs runs(made.store);
    const std::string models = bench::models_before(runs, run);
    return models.substr(0, models.find(':'));
  };
  CHECK(before(later) == "3");
  CHECK(before(1).empty());
  CHECK(before(2).empty());
  CHECK(before(other).empty());
  made.store.void_run(3, "gauge closed", "me", "2025-03-01T00:00:00Z");
  CHECK(before(later) == "2");
}

TEST_CASE("as found: with an overdue reference there is no verdict, and nothing is in doubt") {
  AsFoundStore made;
  FilmRun overdue;
  overdue.calibration = R"({"calibrated":"2019-01-01","due":"2020-01-01"})";
  const std::int64_t run = made.add(overdue);
  analysis::ReportInput input;
  input.run = made.store.run(run);
  input.judgement.figures.resize(1);
  input.more.previous.emplace();
  input.more.previous->evaluation = film_evaluation(run, 2.0).evaluation;
  // Recorded with it, the evaluation is of that run.
  analysis::Runs runs(made.store);
  bench::judge_as_found(runs, input, made.path("before.json"), film_limits(1.0));
  CHECK(film_mean_text(input.more.previous->judgement.figures) ==
        fmt::format("{} mean_compensation_error 2 of 1: inconclusive; ", run));
  CHECK(input.more.previous->doubt.empty());
}

TEST_CASE("as found: doubt starts at the last earlier run of the sensor with a valid passing verdict") {
  AsFoundStore made;
  CHECK(made.doubt() == "all");
  (void)made.add_judged("2026-01-15T12:00:00Z", "fail");
  (void)made.add_judged("2026-01-16T12:00:00Z", "inconclusive");
  CHECK(made.doubt() == "all");
  (void)made.add_judged("2026-01-10T12:00:00Z", "pass");
  CHECK(made.doubt() == "2026-01-10");
  const std::int64_t later = made.add_judged("2026-01-12T12:00:00Z", "conditional pass");
  CHECK(made.doubt() == "2026-01-12");
  (void)made.add_judged("2026-01-11T12:00:00Z", "pass");
  CHECK(made.doubt() == "2026-01-12");
  (void)made.add_judged("2026-01-13T12:00:00Z", "conditional fail");
  (void)made.add_judged("2026-03-01T00:00:00Z", "pass");  // of the same second, and a higher number
  (void)made.add_judged("2026-03-01T00:00:01Z", "pass");
  (void)made.add_judged("2026-02-01T00:00:00Z", "pass", "S-2");
  (void)made.add_judged("2026-02-02T00:00:00Z", "pass", "S-1", "hardware");
  CHECK(made.doubt() == "2026-01-12");
  made.store.void_run(later, "by hand", "me", "2026-03-02T00:00:00Z");
  CHECK(made.doubt() == "2026-01-11");
  CHECK(made.doubt(0.5).empty());
}

// Runs that verbs name, and signed reports that are not written over: on runs stored by hand.

namespace {

using RunNumbers = std::vector<std::int64_t>;

class NamedByHand : public tests::FilmStore {
 public:
  // The numbers of those taken, and what is warned of; or the error.
  [[nodiscard]] std::string named(const RunNumbers& numbers, const bench::RunSelectionRules& named,
                                  bool void_too) const {
    analysis::Runs runs(store);
    tests::Captured warned(stderr);
    std::string text;
    try {
      for (const db::RunRecord& run : bench::named_runs(runs, numbers, named, void_too))
        text += fmt::format("{} ", run.run);
    } catch (const bench::Error& error) {
      return fmt::format("{} {} at {}", static_cast<int>(error.code()), error.id(), error.where());
    }
    return text + warned.text();
  }
};

}  // namespace

TEST_CASE("named runs: duplicates and runs of the models are rejected, void runs are accepted only where allowed") {
  NamedByHand made;
  for (int i = 0; i < 3; ++i) made.add();
  CHECK(made.named({2, 1}, {.at = "--held-out", .models_of = 3}, false) == "2 1 ");
  CHECK(made.named({}, {.at = "--held-out"}, false).empty());
  CHECK(made.named({1, 2, 1}, {.at = "--held-out"}, true) == "2 TB-RUN-TWICE at --held-out");
  CHECK(made.named({1, 3}, {.at = "--held-out", .models_of = 3}, false) == "2 TB-RUN-OWN at --held-out");
  made.store.void_run(2, "gauge closed", "me", "2026-01-31T12:00:00Z");
  CHECK(made.named({2}, {.at = "runs"}, false) == "2 TB-RUN-VOID at runs");
  CHECK(made.named({2}, {.at = "runs", .void_can_be_used = false}, true) == "2 TB-RUN-VOID at runs");
  CHECK_THAT(made.named({2, 3}, {.at = "runs"}, true), Catch::StartsWith("2 3 "));
}

TEST_CASE("source runs: are found by content hash, or by number if no hash is stored") {
  NamedByHand made;
  for (int i = 0; i < 3; ++i) made.add();
  const std::string second = made.store.run(2).content_sha256;
  REQUIRE(second.size() == 64);
  const auto run_of = [&](std::int64_t run, const std::string& content) {
    analysis::SensorDynamics::Source source;
    source.run = run;
    source.content_sha256 = content;
    return bench::run_of_source(made.store, source).value_or(-1);
  };
  CHECK(run_of(3, "") == 3);
  CHECK(run_of(4, "") == -1);
  CHECK(run_of(2, second) == 2);
  CHECK(run_of(77, second) == 2);  // of another store, where it had another number
  CHECK(run_of(2, std::string(64, '0')) == -1);
  analysis::SensorModel fit;
  CHECK(bench::source_runs(made.store, fit).empty());
  fit.run = 1;
  CHECK(bench::source_runs(made.store, fit) == RunNumbers{1});
  fit.dynamics.emplace();
  fit.dynamics->rate.run = 3;
  fit.dynamics->creep.run = 9;
  fit.dynamics->creep.content_sha256 = second;
  CHECK(bench::source_runs(made.store, fit) == RunNumbers{1, 3, 2});
  fit.dynamics->creep = fit.dynamics->rate;
  CHECK(bench::source_runs(made.store, fit) == RunNumbers{1, 3});
}

TEST_CASE("signed reports: are recognised in HTML, JSON and PDF, and never overwritten by another file") {
  NamedByHand made;
  const auto holds = [&](const std::string& text) {
    tests::write_file(made.path("r"), text);
    return bench::signed_report_in(made.path("r"), made.store);
  };
  const std::string data = R"({"number":"R-7","identification":{"approvals":[{"number":"R-6"},{"number":"R-7"}]}})";
  CHECK(bench::signed_report_in(made.path("none"), made.store).empty());
  CHECK(bench::signed_report_in(made.path(""), made.store).empty());  // a folder
  CHECK(holds("").empty());
  CHECK(holds(data) == "R-7");
  CHECK(holds("<!DOCTYPE html><title>x</title><script id=\"report-data\">" + data + "</script>") == "R-7");
  CHECK(holds("<!DOCTYPE html><script id=\"report-data\">" + data).empty());  // cut off
  CHECK(holds("<!DOCTYPE html><title>R-7, signed</title>").empty());
  CHECK(holds(R"({"number":"R-7","identification":{"approvals":[{"number":"R-6"}]}})").empty());
  CHECK(holds(R"({"number":"R-7","identification":{"approvals":["R-7"]}})").empty());
  CHECK(holds(R"({"number":"R-7","identification":{}})").empty());
  CHECK(holds(R"({"number":"R-7","identification":7})").empty());
  CHECK(holds(R"({"number":"R-7"})").empty());
  CHECK(holds(R"({"identification":{"approvals":[{"number":""}]}})").empty());
  CHECK(holds("%PDF-1.7 R-7, signed").empty());  // signed in no report of this store
  tests::write_file(made.path("r"), data);
  CHECK_FALSE(bench::may_be_written(made.path("r"), "R-7", made.store));  // it is there already
  CHECK(bench::may_be_written(made.path("none"), "R-7", made.store));
  try {
    (void)bench::may_be_written(made.path("r"), "R-8", made.store);
    FAIL("the signed report would be written over");
  } catch (const bench::Error& error) {
    CHECK(error.code() == bench::ExitCode::kUsage);
    CHECK(error.id() == "TB-REPORT-SIGNED");
    CHECK(error.where() == made.path("r"));
  }
  CHECK(bench::report_path(made.store, "x.html") == made.path("reports/x.html"));
}

TEST_CASE("report path: does not overwrite the report of another store, nor a signed report") {
  NamedByHand made;
  const auto path = [&](const std::string& uuid, const char* ending) {
    const std::string dot = std::string(".") + ending;
    return bench::free_report_path(made.store, "run-1" + dot, "run-1-abc" + dot, uuid);
  };
  std::filesystem::create_directories(made.path("reports"));
  for (const auto& [ending, text] : {std::pair{"html", R"(<!DOCTYPE html><script>{"uuid":"u-1"}</script>)"},
                                     std::pair{"json", R"({"number":"1-abc","uuid":"u-1"})"},
                                     std::pair{"pdf", "%PDF-1.4 /Title (1-abc, run u-1)"}}) {
    const std::string usual = made.path(std::string("reports/run-1.") + ending);
    CHECK(path("u-2", ending) == usual);
    tests::write_file(usual, text);
    CHECK(path("u-1", ending) == usual);
    CHECK(path("u-2", ending) == made.path(std::string("reports/run-1-abc.") + ending));
  }
}
