// Checks of a report's options and its signature, before anything is written.

#include <catch2/catch.hpp>
#include <string>
#include <tuple>
#include <vector>

#include "bench/cli/reports/report.h"
#include "bench/cli/reports/report_sign.h"
#include "bench/common/error.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/db/store_example.h"
#include "tests/support/refusal.h"

using namespace tactbench;
using namespace tactbench::bench;

namespace {

template <class Check>
std::string report_refusal(const Check& check) {
  const auto error = tests::refusal_by(check);
  if (!error) return {};
  return error->id() + " at " + error->where();
}

std::string option_refusal(const ReportOptions& options) {
  return report_refusal([&] { check_report_options(options); });
}

}  // namespace

TEST_CASE("report options: a model is named by its run, or by run and fit") {
  const auto named = [](const char* text) {
    const ModelReference model = parse_model_reference(text, 7);
    return std::to_string(model.run) + ":" + std::to_string(model.fit);
  };
  CHECK(named("") == "7:0");
  CHECK(named("1") == "1:0");
  CHECK(named("12:1") == "12:1");
  CHECK(named("12:34") == "12:34");
  for (const char* text : {"0", "-1", "x", "1:", "1:0", "1:-2", "1:x", "1x", "1:2x", ":2", "1;2", " 1",
                           "99999999999999999999", "1:99999999999999999999"}) {
    INFO(text);
    CHECK_THAT(report_refusal([&] { (void)parse_model_reference(text, 7); }), Catch::StartsWith("TB-USAGE at "));
  }
}

TEST_CASE("report options: combinations that are accepted and rejected") {
  ReportOptions options;
  options.runs = {1, 2};
  CHECK(option_refusal(options).empty());
  options.compare = true;
  CHECK(option_refusal(options).empty());
  options.batch = true;
  CHECK_THAT(option_refusal(options), Catch::StartsWith("TB-USAGE at "));
  options.batch = false;
  for (const std::size_t runs : {1U, 3U}) {
    options.runs.resize(runs);
    CHECK_THAT(option_refusal(options), Catch::StartsWith("TB-USAGE at "));
  }
  for (const bool compare : {false, true}) {
    ReportOptions several;
    several.runs = {1, 2};
    several.compare = compare;
    several.batch = !compare;
    CHECK(option_refusal(several).empty());
    for (int which = 0; which < 3; ++which) {
      ReportOptions own = several;
      if (which == 0) own.held_out = {3};
      if (which == 1) own.extras.previous = "1";
      if (which == 2) own.extras.studies = {"3"};
      INFO(which);
      CHECK(option_refusal(own) == "TB-USAGE at report");
      own.compare = own.batch = false;
      CHECK(option_refusal(own).empty());
    }
  }
  ReportOptions dated;
  dated.runs = {1};
  dated.issued = "2026-01-31";
  CHECK(option_refusal(dated).empty());
  dated.issued = "31.1.2026";
  CHECK_THAT(option_refusal(dated), Catch::StartsWith("TB-USAGE at "));
}

TEST_CASE("report: runs are chosen by number, a batch by range or lot, without void runs or runs without models") {
  const tests::TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
  for (int run = 1; run <= 6; ++run) {
    (void)tests::store_example(store);
    if (run != 2 && run != 6) {
      db::FitRecord fit;
      fit.run = run;
      fit.model = "elam";
      fit.stands = true;
      fit.fitted = 1;
      (void)store.add_fit(fit);
    }
    if (run % 2 == 1) store.set_tags(run, {"lot=L7"}, {});
  }
  store.void_run(4, "by hand", "K. Lee", "2026-01-01T00:00:00Z");
  using Numbers = std::vector<std::int64_t>;
  const auto chosen = [&](std::vector<std::string> named, const std::string& lot = "", bool batch = true) {
    ReportOptions options;
    options.named = std::move(named);
    options.metadata.lot = lot;
    options.batch = batch;
    choose_runs(options, store, false);
    return options.runs;
  };
  CHECK(chosen({"2"}, "", false) == Numbers{2});
  CHECK(chosen({"6", "1,4"}) == Numbers{6, 1, 4});  // as named
  CHECK(chosen({"1-99"}) == Numbers{1, 3, 5});
  CHECK(chosen({"1-2", "5"}) == Numbers{1, 5});
  CHECK(chosen({}, "L7") == Numbers{1, 3, 5});
  CHECK(chosen({"2-4"}, "L7") == Numbers{3});
  for (const auto& [named, lot, batch] : {std::tuple(std::vector<std::string>{}, "", false),
                                          {{"1-3"}, "", false},
                                          {{}, "L7", false},
                                          {{}, "L8", true},
                                          {{"run-1"}, "", true},
                                          {{"7-9"}, "", true}})
    CHECK(report_refusal([&] { (void)chosen(named, lot, batch); }).starts_with("TB-USAGE at "));
}

TEST_CASE("report signing: needs a reason if it replaces a report, and rejects a reason otherwise") {
  const db::ReportRecord first{1, "1-a", "h", "K. Lee", "2026-01-01T00:00:00Z", "", ""};
  const db::ReportRecord second{1, "1-b", "i", "K. Lee", "2026-01-02T00:00:00Z", "1-a", "x"};
  const auto reason = [](const std::vector<db::ReportRecord>& before, const char* number, const char* text,
                         bool signing) { return report_refusal([&] { check_reason(before, number, text, signing); }); };
  CHECK(reason({}, "1-a", "", true).empty());
  CHECK(reason({}, "1-a", "", false).empty());
  for (const bool signing : {false, true})
    CHECK_THAT(reason({}, "1-a", "why", signing), Catch::StartsWith("TB-REPORT-REASON at "));
  CHECK_THAT(reason({first}, "1-a", "why", false), Catch::StartsWith("TB-REPORT-REASON at "));
  CHECK(reason({first}, "1-a", "why", true).empty());  // the store refuses it
  CHECK(reason({first}, "1-a", "", true).empty());
  CHECK(reason({first, second}, "1-c", "why", true).empty());
  CHECK(reason({first, second}, "1-c", "why", false).empty());
  CHECK(reason({first, second}, "1-c", "", false).empty());
  CHECK_THAT(reason({first, second}, "1-c", "", true), Catch::StartsWith("TB-REPORT-REASON at "));
}

TEST_CASE("report signing: without a verdict it needs confirmation") {
  Session session;
  session.json = true;
  const auto sign = [&](const analysis::Judgement& judgement, bool without_verdict) {
    return report_refusal([&] { check_signature(judgement, 5, "simulated", without_verdict, session); });
  };
  CHECK_THAT(sign({}, false), Catch::StartsWith("TB-REPORT-NO-VERDICT at "));
  CHECK(sign({}, true).empty());
}

TEST_CASE("report options: runs used for lag and creep are rejected as independent data") {
  const tests::TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
  for (int i = 0; i < 4; ++i) (void)tests::store_example(store);
  analysis::SensorModel fit;
  fit.run = 1;
  const auto refusal = [&](const std::vector<std::int64_t>& held_out) {
    return report_refusal([&] { check_independent_of_dynamics(store, fit, held_out); });
  };
  CHECK(refusal({1, 2, 3, 4}).empty());  // a model without lag and creep
  fit.dynamics.emplace();
  fit.dynamics->rate.run = 2;
  fit.dynamics->creep.run = 3;
  CHECK(refusal({}).empty());
  CHECK(refusal({4}).empty());
  for (const int run : {1, 2, 3}) CHECK_THAT(refusal({4, run}), Catch::StartsWith("TB-RUN-OWN at "));
}
