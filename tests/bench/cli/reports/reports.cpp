// Checks of a report's options and its signature, before anything is written.

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "analysis/report/document/document.h"
#include "bench/cli/judgement_output.h"
#include "bench/cli/reports/report.h"
#include "bench/cli/reports/report_sign.h"
#include "bench/cli/session.h"
#include "bench/common/error.h"
#include "bench/nightly/suite.h"
#include "db/sqlite.h"
#include "sequences/toml/strict_toml.h"
#include "tests/analysis/support/judged_figures.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/bench/run/quick_store.h"
#include "tests/db/store_example.h"
#include "tests/support/refusal.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;
using analysis::Verdict;
using analysis::by_hand::judged_figure;
using analysis::by_hand::judgement_of;

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
  QuickStore store;
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
  QuickStore store;
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

// report list and report verify of a store whose signed reports are known row by row.

namespace {

// Two runs; of the first two signed reports, of the second, which is hardware's, one.
struct SignedStore : OpenStoreHere {
  SignedStore() {
    store_example(store);
    db::RunRecord other = example_run();
    other.origin = "hardware";
    store_example(store, other);
    store.add_report({1, "1-0000000a", "h", "K. Lee", "2026-01-02T00:00:00Z", "", ""});
    store.add_report({1, "1-0000000b", "i", "M. Ito", "2026-01-03T00:00:00Z", "1-0000000a", "serial corrected"});
    store.add_report({2,
                      "2-0000000c",
                      "j",
                      "K. Lee",
                      "2026-01-04T00:00:00Z",
                      "",
                      "",
                      {{2, store.run(2).content_sha256}, {1, store.run(1).content_sha256}}});
  }
  Finished reports(std::vector<std::string> words) const {
    words.insert(words.begin(), "report");
    return say(bench::add_report, words);
  }
  // The file of a report where `report` puts it, and its hash in the notes of the run.
  std::string write_report_file(std::int64_t run, const std::string& name, const std::string& number) {
    std::filesystem::create_directories(folder.path("reports"));
    std::string file = folder.path("reports/" + name);
    const std::string text = "<p>" + name + "</p><title>" + number + ", signed</title>";
    write_file(file, text);
    store.add_note(run, "2026-01-05T00:00:00Z " + bench::report_file_note(number, db::sha256_hex(text)));
    return file;
  }
};

}  // namespace

TEST_CASE("report list: shows each signed report with run, signer, replaced report and reason") {
  SignedStore store;
  CHECK_THAT(store.reports({"list", "3"}).err, Catch::Contains("[TB-STORE-NOT-FOUND]"));
  const std::string file = store.write_report_file(2, "run-2-0000000c.pdf", "2-0000000c");
  const auto printed = nlohmann::json::parse(store.reports({"list", "--json"}).out).at("reports");
  REQUIRE(printed.size() == 3);
  CHECK(printed.at(1) == nlohmann::json{{"number", "1-0000000b"},
                                        {"run", 1},
                                        {"sensor", "S-1"},
                                        {"origin", "simulated"},
                                        {"signed", "2026-01-03T00:00:00Z"},
                                        {"by", "M. Ito"},
                                        {"replaces", "1-0000000a"},
                                        {"reason", "serial corrected"},
                                        {"sha256", "i"},
                                        {"void_evidence", nlohmann::json::array()},
                                        {"file", ""}});
  CHECK(printed.at(2).at("file") == file);
  CHECK(nlohmann::json::parse(store.reports({"list", "1", "--json"}).out).at("reports").size() == 2);
}

TEST_CASE("report verify: rejects text that is neither file nor number, and reports unsigned numbers") {
  SignedStore store;
  for (const char* word : {"what", "1-0000000", "1-0000000aa", "-0000000a", "a-0000000a", "1-0000000g", "1-0000000A",
                           "10000000a", "", "1-"}) {
    INFO(word);
    check_refusal(verb_here(bench::add_report, {"report", "verify", "--db", store.path, "--", word}), 2, "TB-USAGE",
                  "report verify");
  }
  CHECK(store.reports({"verify", "1234567890-09afaf90"}).code == 1);
  const auto printed = nlohmann::json::parse(store.reports({"verify", "1-ffffffff", "--json"}).out);
  CHECK(printed.at("signed") == false);
  CHECK(printed.at("files").at(0).at("state") == "unknown");
  CHECK_FALSE(printed.contains("run"));
}

TEST_CASE("report verify: reports a file as unchanged, changed, of an earlier report, or missing") {
  SignedStore store;
  // The states of the files of a report, and the exit code.
  const auto states = [&](const std::string& named) {
    const Finished verified = store.reports({"verify", named, "--json"});
    std::string text = std::to_string(verified.code);
    const nlohmann::json printed = nlohmann::json::parse(verified.out);
    for (const auto& file : printed.at("files")) text += " " + file.at("state").get<std::string>();
    return text;
  };
  CHECK(store.reports({"verify", "1-0000000a"}).code == 6);
  const std::string page = store.write_report_file(2, "run-2-0000000c.html", "2-0000000c");
  CHECK(states("2-0000000c") == "0 unchanged");
  CHECK(states(page) == "0 unchanged");
  const std::string copy = store.write_report_file(2, "run-2-0000000c.json", "2-0000000c");
  CHECK(states("2-0000000c") == "0 unchanged unchanged");
  write_file(page, read_file(page) + " ");
  CHECK(states("2-0000000c") == "1 changed unchanged");
  // Signed by a program that kept no hash of the file.
  const std::string old = store.folder.path("old");
  write_file(old, "1-0000000a, signed");
  CHECK(store.reports({"verify", old}).code == 6);
  const std::string letter = store.folder.path("letter");
  write_file(letter, "dear diary");
  CHECK(store.reports({"verify", letter}).code == 6);
  const auto printed = nlohmann::json::parse(store.reports({"verify", page, "--json"}).out);
  CHECK(printed.at("files").at(0) ==
        nlohmann::json{{"file", page}, {"sha256", db::sha256_hex(read_file(page))}, {"state", "changed"}});
  CHECK(printed.at("replaced_by") == "");
  CHECK(nlohmann::json::parse(store.reports({"verify", old, "--json"}).out).at("replaced_because") ==
        "serial corrected");
}

TEST_CASE("report verify: a void run or a changed store outranks an unchanged file") {
  SignedStore store;
  const std::string page = store.write_report_file(2, "run-2-0000000c.html", "2-0000000c");
  store.store.void_run(2, "gauge closed", "K. Lee", kUtc);
  CHECK(store.reports({"verify", page}).code == 1);
  db::sqlite::Connection(store.path, db::sqlite::Access::kReadWrite)
      .execute(
          "UPDATE frames SET status = 9 WHERE frame / 1000000000 = 2; UPDATE reports SET approved_by = 'B' WHERE run "
          "= 2");
  CHECK(store.reports({"verify", page}).code == 1);
}

TEST_CASE("report verify: after voiding a run used as evidence, void names the signed reports and verify fails them") {
  SignedStore store;
  const std::string page = store.write_report_file(2, "run-2-0000000c.html", "2-0000000c");
  const auto evidence = [&](const std::string& in) {
    return nlohmann::json::parse(verb_here(bench::add_report, {"report", "verify", page, "--json", "--db", in}).out)
        .at("evidence")
        .at("state");
  };
  CHECK(evidence(store.path) == "holds");
  const auto voided =
      store.printed<nlohmann::json>(bench::add_runs, {"runs", "void", "1", "--reason", "gauge closed", "--by", "me"});
  CHECK(voided.at("signed_reports") == nlohmann::json{"1-0000000b", "2-0000000c"});
  CHECK(store.reports({"verify", page}).code == 1);
  CHECK(evidence(store.path) == "fallen");
  CHECK(nlohmann::json::parse(store.reports({"list", "2", "--json"}).out)
            .at("reports")
            .at(0)
            .at("void_evidence")
            .size() == 1);
  // A copy without the run on which it was judged cannot be checked.
  const std::string copy = store.folder.path("copy.db");
  db::RunStore::open(copy).copy_runs_from(store.store, {2});
  CHECK(evidence(copy) == "unknown");
}

TEST_CASE("report signing: the hash of a report file is stored once, and only for signed reports") {
  SignedStore store;
  bench::Session session;
  session.db = store.path;
  const std::string file = store.folder.path("r.html");
  write_file(file, "page");
  const auto notes = [&] { return store.store.run(1).notes; };
  const std::string before = notes();
  bench::record_signed_file(file, "1-ffffffff", 1, session);
  bench::record_signed_file(file + ".none", "1-0000000a", 1, session);
  CHECK(notes() == before);
  bench::record_signed_file(file, "1-0000000a", 1, session);
  const std::string kept = notes();
  CHECK(kept != before);
  bench::record_signed_file(file, "1-0000000a", 1, session);
  CHECK(notes() == kept);
}

// The exit code of each verdict, and a judgement as programs read it.

TEST_CASE("verdict text: each verdict has its exit code, and a worse verdict never has a better code") {
  CHECK(exit_code_of(std::nullopt) == ExitCode::kPass);
  for (const Verdict good : {Verdict::kReportOnly, Verdict::kPass, Verdict::kConditionalPass})
    CHECK(exit_code_of(good) == ExitCode::kPass);
  for (const Verdict open : {Verdict::kConditionalFail, Verdict::kInconclusive})
    CHECK(exit_code_of(open) == ExitCode::kInconclusive);
  CHECK(exit_code_of(Verdict::kFail) == ExitCode::kCriterionFailed);
  const std::vector<ExitCode> better_first = {ExitCode::kPass, ExitCode::kInconclusive, ExitCode::kCriterionFailed};
  std::ptrdiff_t before = 0;
  for (const Verdict verdict : analysis::kVerdicts) {
    const auto place = std::ranges::find(better_first, exit_code_of(verdict)) - better_first.begin();
    CHECK(place >= before);
    before = place;
  }
}

namespace {

analysis::JudgedFigure mean_error(std::int64_t run, double value, double limit, Verdict verdict) {
  return judged_figure(run, analysis::Criterion::kMeanError, value, limit, verdict);
}

constexpr analysis::PressureUnit kPsi = analysis::PressureUnit::kPsi;

std::string shown(const analysis::Judgement& judgement, bool all = false) {
  return to_text(judgement_document(judgement, "simulated", kPsi, all), kPsi, 200);
}

std::size_t times(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

}  // namespace

TEST_CASE("verdict text: the verdict comes first, agrees with the exit code, and is followed by the deciding value") {
  for (const Verdict verdict :
       {Verdict::kPass, Verdict::kConditionalPass, Verdict::kConditionalFail, Verdict::kInconclusive, Verdict::kFail}) {
    INFO(to_string(verdict));
    const analysis::Judgement judgement =
        judgement_of({mean_error(2, 0.125, 3.0, Verdict::kPass), mean_error(3, 6.25, 3.0, verdict)});
    const ExitCode code = exit_code_of(verdict);
    const std::string word = verdict_banner(judgement), text = shown(judgement);
    CHECK(word == (code == ExitCode::kPass ? "PASS" : code == ExitCode::kInconclusive ? "INCONCLUSIVE" : "FAIL"));
    CHECK(text.starts_with(word + " (simulated)"));
    CHECK(text.substr(0, text.find('\n')).find("6.25 psi") != std::string::npos);
    CHECK(times(text, "simulated") == 1);
    CHECK(times(text, word) == 1);
  }
  CHECK(verdict_banner(judgement_of({mean_error(2, 1.0, 3.0, Verdict::kReportOnly)})).empty());
  analysis::Judgement own = judgement_of({mean_error(2, 1.0, 3.0, Verdict::kPass)});
  own.not_judged = {analysis::Remark::Kind::kNoIndependentData};
  conclude(own);
  CHECK(verdict_banner(own) == "INCONCLUSIVE");
}

TEST_CASE("verdict text: a pass based on means only is marked, and passed values are listed only on request") {
  std::vector<analysis::JudgedFigure> figures;
  for (const double value : {0.5, 1.5, 2.5, 1.0}) figures.push_back(mean_error(2, value, 3.0, Verdict::kPass));
  CHECK(times(headline(judgement_of(figures), "hardware", kPsi), "means") == 1);
  const std::string brief = shown(judgement_of(figures)), all = shown(judgement_of(figures), true);
  for (const char* value : {"0.50 psi", "1.50 psi", "1.00 psi"}) {
    CHECK(times(brief, value) == 0);
    CHECK(times(all, value) == 1);
  }
  CHECK(times(brief, "2.50 psi") == 1);  // the closest to its limit
  figures.push_back(judged_figure(2, analysis::Criterion::kMpe, 1.0, 3.0, Verdict::kPass));
  CHECK(times(headline(judgement_of(figures), "hardware", kPsi), "means") == 0);
  figures.push_back(mean_error(3, 9.0, 3.0, Verdict::kFail));
  figures.push_back(mean_error(4, 8.0, 3.0, Verdict::kFail));
  const std::string failed = shown(judgement_of(figures));
  CHECK(failed.find("9.00 psi") < failed.find("8.00 psi"));
  CHECK(failed.find("8.00 psi") < failed.find("2.50 psi"));  // the closest pass
}

TEST_CASE("pass by readings: names the kinds of history without U in any judged run, a fail names none") {
  using analysis::UseCondition;
  const auto of_kinds = [](std::int64_t run, Verdict verdict, std::vector<UseCondition> kinds) {
    analysis::JudgedFigure figure = judged_figure(run, analysis::Criterion::kMpe, 1.0, 3.0, verdict);
    figure.u.kinds = std::move(kinds);
    return figure;
  };
  const auto named = [](const analysis::Judgement& judgement) {
    std::vector<std::string> found;
    for (std::size_t kind = 0; kind < analysis::kHistoryKinds; ++kind)
      if (const std::string name = name_of(static_cast<UseCondition>(kind)); times(shown(judgement), name) == 1)
        found.push_back(name);
    CHECK(found == kinds_left_open(judgement));
    return found.size();
  };
  const auto sweeps = of_kinds(2, Verdict::kPass, {UseCondition::kFullSweeps, UseCondition::kReversals});
  CHECK(named(judgement_of({sweeps})) == 2);
  CHECK(named(judgement_of({sweeps, of_kinds(3, Verdict::kPass, {UseCondition::kHeld})})) == 1);
  CHECK(named(judgement_of({sweeps, of_kinds(3, Verdict::kFail, {})})) == 0);
  CHECK(named(judgement_of({of_kinds(2, Verdict::kPass, {})})) == 0);  // a stored one
}

TEST_CASE("suite: a scenario can expect every verdict that a store can hold, and no other") {
  const auto suite = [](const std::string& word) {
    return parse_suite(
        "schema = 1\nname = \"s\"\n[[scenario]]\nname = \"a\"\nabout = \"b\"\nheld_out = []\n"
        "[scenario.verdicts]\noverall = \"" +
            word + "\"\n",
        "s.toml");
  };
  for (const std::string& word : analysis::verdict_names())
    CHECK(suite(word).scenarios.at(0).verdicts.at("overall") == word);
  CHECK_THROWS_AS(suite("report only"), sequences::FileError);
}

TEST_CASE("operator: an empty name is rejected") {
  for (const char* nobody : {"", " ", " \t\r\n"}) CHECK_THROWS_AS(check_operator(nobody), Error);
  CHECK_NOTHROW(check_operator(" A. Operator"));
}

TEST_CASE("verdict text: the judgement as JSON has all members, and empty text if there is no verdict") {
  using analysis::by_hand::judged_figure;
  const auto row = [](std::int64_t run, Verdict verdict) {
    return judged_figure(run, analysis::Criterion::kUnfitTaxels, 1.0, 1.0, verdict, {}, 1);
  };
  analysis::Judgement judgement = analysis::by_hand::judgement_of({row(4, Verdict::kFail), row(2, Verdict::kPass)});
  judgement.not_assessed = {analysis::Source::kRemounting};
  judgement.stored_worse = {row(5, Verdict::kFail)};
  judgement.void_counted = {{9, "K. Lee", "2026-01-01T00:00:00Z", "door"}};
  judgement.remarks = {{analysis::Remark::Kind::kVoidCounted, judgement.void_counted[0]}};
  judgement.untraced = analysis::TraceabilityGap{.overdue_since = "2020-01-31"};
  const auto json = judgement_json(judgement, "simulated");
  CHECK(json.at("overall") == "fail");
  CHECK(json.at("shown") == "simulated fail");
  CHECK_THAT(json.at("statement").get<std::string>(), Catch::StartsWith("fail"));
  REQUIRE(json.at("runs").size() == 2);
  CHECK((json["runs"][0]["run"] == 4 && json["runs"][0]["verdict"] == "fail"));
  CHECK(json["runs"][1].at("trajectory").contains("reversals"));
  CHECK((json.at("not_assessed").size() == 1 && json["not_assessed"][0]["source"] == "re-mounting"));
  CHECK_THAT(json.at("untraced").get<std::string>(), Catch::Contains("2020-01-31"));
  CHECK(json.at("not_judged") == "");
  CHECK(json.at("decided_by") == nlohmann::ordered_json({4}));
  CHECK((json.at("deciding").at("run") == 4 && json.at("closest_pass").at("run") == 2));
  CHECK(json.at("rests_on_means_alone") == false);
  CHECK(json.at("void_runs") ==
        nlohmann::ordered_json::parse(
            R"([{"run": 9, "reason": "door", "by": "K. Lee", "utc": "2026-01-01T00:00:00Z"}])"));
  CHECK((json.at("stored_worse").size() == 1 && json.at("remarks").size() == 1));
  judgement.not_judged = {analysis::Remark::Kind::kNoIndependentData};
  conclude(judgement);
  CHECK(judgement_json(judgement, "hardware").at("shown") == "inconclusive");
  const auto nothing = judgement_json({}, "simulated");
  CHECK((nothing.at("shown") == "" && nothing.at("statement") == "" && nothing.at("runs").empty()));
  CHECK(nothing.at("deciding").is_null());
}
