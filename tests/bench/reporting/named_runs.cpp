// Runs that verbs name, and signed reports that are not written over: on runs stored by hand.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "bench/common/error.h"
#include "bench/reporting/evaluation.h"
#include "bench/reporting/named_runs.h"
#include "bench/reporting/signed_reports.h"
#include "bench/reporting/source_runs.h"
#include "db/run_store.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/bench/reporting/film_runs.h"
#include "tests/support/process.h"

using namespace tactbench;

namespace {

using RunNumbers = std::vector<std::int64_t>;

class NamedByHand : public tests::FilmStore {
 public:
  // The numbers of those taken, and what is warned of; or the error.
  [[nodiscard]] std::string named(const RunNumbers& numbers, const bench::RunsNamed& named, bool void_too) const {
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

TEST_CASE("named runs: each once, none of the models' own, and void ones only where they may be taken") {
  NamedByHand made;
  for (int i = 0; i < 3; ++i) made.add();
  CHECK(made.named({2, 1}, {.at = "--held-out", .models_of = 3}, false) == "2 1 ");
  CHECK(made.named({}, {.at = "--held-out"}, false).empty());
  CHECK(made.named({1, 2, 1}, {.at = "--held-out"}, true) == "2 TB-RUN-TWICE at --held-out");
  CHECK(made.named({1, 3}, {.at = "--held-out", .models_of = 3}, false) == "2 TB-RUN-OWN at --held-out");
  made.store.void_run(2, "gauge closed", "me", "2026-01-31T12:00:00Z");
  CHECK(made.named({2}, {.at = "runs"}, false) == "2 TB-RUN-VOID at runs");
  CHECK(made.named({2}, {.at = "runs", .void_can_be_taken = false}, true) == "2 TB-RUN-VOID at runs");
  CHECK_THAT(made.named({2, 3}, {.at = "runs"}, true), Catch::StartsWith("2 3 "));
}

TEST_CASE("source runs: known by their content, or by their number where it is not told") {
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

TEST_CASE("signed reports: found in pages, data and by a title in a PDF, and never written over by another") {
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

TEST_CASE("a report is not written over that of another store's run, nor over a signed one") {
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
