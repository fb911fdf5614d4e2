// A whole report on runs of one taxel that are stored by hand: its input with uncertainties and earlier models, its
// file, and where that goes when a signed report stands in its place. Not a unit test: models are compared by several
// threads.
#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/common/error.h"
#include "bench/reporting/evaluation.h"
#include "tests/bench/reporting/judged_store.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

// Run 1 with models, judged on run 2.
struct WrittenStore : JudgedStore {
  WrittenStore() : JudgedStore(2) { write_file(path("before.json"), analysis::to_text(film_line_model(0.125))); }
  [[nodiscard]] bench::Judged judged(const analysis::Limits& limits) {
    bench::Judged out{bench::gather_evidence(runs, models, evaluations, limits, false), limits, {}};
    out.judgement = analysis::judge(out.evidence, limits);
    return out;
  }
  analysis::Runs runs{store};
  analysis::SensorModel models = film_line_model();
  std::vector<bench::NamedEvaluation> evaluations = bench::evaluate_runs(runs, models, {2});
};

}  // namespace

TEST_CASE(
    "written report: with all of its extras it has uncertainties, conditions of the budget, and what was before") {
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
  CHECK(film_mean_words(input.more.previous->judgement.figures).ends_with(": fail; "));
  CHECK_FALSE(input.more.previous->doubt.empty());
  // Of a run that the models were not made from, no uncertainty is stated.
  const analysis::ReportInput other =
      bench::report_input(made.runs, 2, made.models, made.evaluations, made.judged(film_limits(10.0)));
  CHECK_FALSE(other.uncertainty);
}

TEST_CASE("written report: beside the store under the run's number, or the report's where a signed one stands there") {
  WrittenStore made;
  const bench::Judged judgement = made.judged(film_limits(10.0));
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
