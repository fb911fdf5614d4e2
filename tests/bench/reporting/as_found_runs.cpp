// As found: verdicts on earlier models by the limits of the report, and since when measurements with them are in doubt.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "analysis/identify/stored/model_document.h"
#include "bench/reporting/as_found.h"
#include "tests/bench/reporting/judged_store.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

// What is in doubt: "" nothing, "all", or since which day.
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

TEST_CASE("as found: judged by the limits of the report with the earlier models, and in doubt where they fail") {
  AsFoundStore made;
  const analysis::ReportInput passed = made.found(0.5);
  CHECK(film_row_words(passed.more.previous->judgement.figures) ==
        "1 mean_compensation_error 0.5 of 1: pass; 1 worst_taxel_error 1.5 of 60: pass; 1 distance_of_mean 0.25 of 1: "
        "pass; 1 unfit_taxels 0 of 1: pass; ");
  CHECK(passed.more.previous->doubt.empty());
  const analysis::ReportInput failed = made.found(2.0);
  CHECK(film_mean_words(failed.more.previous->judgement.figures) == "1 mean_compensation_error 2 of 1: fail; ");
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

TEST_CASE("as found where no models are named: the newest of the sensor's runs before that counts, else none") {
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

TEST_CASE("as found: an overdue reference withholds, and then nothing is in doubt") {
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
  CHECK(film_mean_words(input.more.previous->judgement.figures) ==
        fmt::format("{} mean_compensation_error 2 of 1: inconclusive; ", run));
  CHECK(input.more.previous->doubt.empty());
}

TEST_CASE("as found: since the last earlier run of that sensor with a passing verdict that stands") {
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
