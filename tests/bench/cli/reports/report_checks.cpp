// What a report's options and its signature are checked for, before anything is written.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "bench/cli/reports/report_options.h"
#include "bench/cli/reports/report_signing.h"
#include "bench/cli/reports/report_stages.h"
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
  return error->id() + " | " + error->what() + " | " + error->where() + " | " + error->remedy();
}

std::string option_refusal(const ReportOptions& options) {
  return report_refusal([&] { check_report_options(options); });
}

}  // namespace

TEST_CASE("report options: models are named by a run, or by a run and a fit") {
  const auto named = [](const char* text) {
    const ModelNamed model = model_named(text, 7);
    return std::to_string(model.run) + ":" + std::to_string(model.fit);
  };
  CHECK(named("") == "7:0");
  CHECK(named("1") == "1:0");
  CHECK(named("12:1") == "12:1");
  CHECK(named("12:34") == "12:34");
  for (const char* text : {"0", "-1", "x", "1:", "1:0", "1:-2", "1:x", "1x", "1:2x", ":2", "1;2", " 1",
                           "99999999999999999999", "1:99999999999999999999"}) {
    INFO(text);
    CHECK(report_refusal([&] { (void)model_named(text, 7); }) ==
          "TB-USAGE | '" + std::string(text) +
              "' names no stored models | --model | RUN, or RUN:FIT (tactbench runs show RUN lists its fits)");
  }
}

TEST_CASE("report options: which go together") {
  ReportOptions options;
  options.runs = {1, 2};
  CHECK(option_refusal(options).empty());
  options.compare = true;
  CHECK(option_refusal(options).empty());
  options.batch = true;
  CHECK(option_refusal(options) == "TB-USAGE | --compare and --batch cannot be combined | report | give one of them");
  options.batch = false;
  for (const std::size_t runs : {1U, 3U}) {
    options.runs.resize(runs);
    CHECK(option_refusal(options) == "TB-USAGE | --compare takes two runs, not " + std::to_string(runs) +
                                         " | report | tactbench report --compare 1 2");
  }
  const std::string one =
      "TB-USAGE | --approve-by, --reason, --held-out, --lab, --previous and --studies belong to the "
      "report of one run | report | report each run by itself, then compare";
  for (const bool compare : {false, true}) {
    ReportOptions several;
    several.runs = {1, 2};
    several.compare = compare;
    several.batch = !compare;
    CHECK(option_refusal(several).empty());
    for (int which = 0; which < 6; ++which) {
      ReportOptions own = several;
      if (which == 0) own.approve_by = "K. Lee";
      if (which == 1) own.reason = "x";
      if (which == 2) own.held_out = {3};
      if (which == 3) own.lab = "lab.toml";
      if (which == 4) own.extras.previous = "1";
      if (which == 5) own.extras.studies = {"3"};
      INFO(which);
      CHECK(option_refusal(own) == one);
      own.compare = own.batch = false;
      CHECK(option_refusal(own).empty());
    }
  }
  ReportOptions dated;
  dated.runs = {1};
  dated.issued = "2026-01-31";
  CHECK(option_refusal(dated).empty());
  dated.issued = "31.1.2026";
  CHECK(option_refusal(dated) == "TB-USAGE | '31.1.2026' is not a date | report | write it as 2026-01-31");
}

TEST_CASE("report signing: a reason where another is replaced, and none otherwise") {
  const db::ReportRecord first{1, "1-a", "h", "K. Lee", "2026-01-01T00:00:00Z", "", ""};
  const db::ReportRecord second{1, "1-b", "i", "K. Lee", "2026-01-02T00:00:00Z", "1-a", "x"};
  const auto reason = [](const std::vector<db::ReportRecord>& before, const char* number, const char* text,
                         bool signing) { return report_refusal([&] { check_reason(before, number, text, signing); }); };
  CHECK(reason({}, "1-a", "", true).empty());
  CHECK(reason({}, "1-a", "", false).empty());
  const std::string out = " | report --reason | leave --reason out";
  for (const bool signing : {false, true})
    CHECK(reason({}, "1-a", "why", signing) ==
          "TB-REPORT-REASON | report 1-a replaces none: no report of this run is signed" + out);
  CHECK(reason({first}, "1-a", "why", false) ==
        "TB-REPORT-REASON | report 1-a is signed already and keeps the reason that it was signed with" + out);
  CHECK(reason({first}, "1-a", "why", true).empty());  // the store refuses it
  CHECK(reason({first}, "1-a", "", true).empty());
  CHECK(reason({first, second}, "1-c", "why", true).empty());
  CHECK(reason({first, second}, "1-c", "why", false).empty());
  CHECK(reason({first, second}, "1-c", "", false).empty());
  CHECK(reason({first, second}, "1-c", "", true) ==
        "TB-REPORT-REASON | report 1-c would replace the signed report 1-b, and no reason is stated | report "
        "--approve-by | state what changed and why: --reason TEXT");
}

TEST_CASE("report signing: without a verdict it is to be confirmed, and a bad one is told") {
  Session session;
  session.json = true;
  const auto sign = [&](const Judgement& judgement, bool without_verdict) {
    return report_refusal([&] { check_signature(judgement, 5, "simulated", without_verdict, session); });
  };
  CHECK(sign({}, false) ==
        "TB-REPORT-NO-VERDICT | the report has no verdict, and signing it was not confirmed | --approve-by, run 5 | "
        "judge "
        "first: tactbench fit 5 --held-out RUN --limits limits.toml; or sign anyway with --without-verdict");
  CHECK(sign({}, true).empty());
  const auto warned = [&](const char* verdict, const std::string& not_judged) {
    Judgement judgement;
    if (*verdict != '\0') judgement.verdicts.emplace_back().verdict = verdict;
    judgement.notes.not_judged = not_judged;
    tests::Captured err(stderr);
    check_signature(judgement, 5, "simulated", false, session);
    return err.text();
  };
  CHECK(warned("pass", "").empty());
  CHECK(warned("conditional pass", "").empty());
  CHECK(warned("fail", "") == "warning: signed with the verdict simulated fail\n");
  CHECK(warned("", "no data") == "warning: signed with the verdict simulated inconclusive, not judged: no data\n");
}

TEST_CASE("report stages: of one run, or one for each run, with their shares, and the writing at the end") {
  const auto stages = [](bool several, const char* format) {
    ReportOptions options;
    options.runs = {3, 4};
    options.batch = several;
    options.format = format;
    std::string text;
    for (const WorkStage& stage : report_stages(options))
      text += fmt::format("{} {:g}{}; ", stage.name, stage.share, stage.counted ? " counted" : "");
    return text;
  };
  CHECK(stages(false, "html") == fmt::format("figures 2; models 4; uncertainty 4; {} 1; ", kWritingReport));
  CHECK(stages(false, "pdf") == fmt::format("figures 2; models 4; uncertainty 4; {} 8; ", kWritingReport));
  CHECK(stages(true, "json") == fmt::format("run 3 2; run 4 2; {} 1; ", kWritingReport));
  ReportOptions compare;
  compare.runs = {3, 4};
  compare.compare = true;
  CHECK(report_stages(compare).size() == 3);
}

TEST_CASE("report options: runs that lag and creep were made from are no independent data") {
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
  for (const int run : {1, 2, 3})
    CHECK(
        refusal({4, run}) ==
        fmt::format("TB-RUN-OWN | the models, or their lag or creep, were made from run {}: it is not independent data "
                    "for them | --held-out | name other runs of the same sensor",
                    run));
}
