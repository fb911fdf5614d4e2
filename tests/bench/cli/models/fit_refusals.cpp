// What fit, predict and compensate refuse of their words, each with what it says.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <string>
#include <utility>
#include <vector>

#include "bench/cli/models/fit_choice.h"
#include "bench/cli/models/fit_many.h"
#include "bench/cli/runs/source.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/db/store_example.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

using FitWords = std::vector<std::string>;

void check_fit_refused(const FitWords& words, const std::string& said) {
  FitWords all = {"fit"};
  all.insert(all.end(), words.begin(), words.end());
  const Finished finished = verb_here(bench::add_fit, all);
  CAPTURE(words);
  CHECK(finished.code == 2);
  CHECK(finished.err == "error: " + said + "\n");
  CHECK(finished.out.empty());
}

std::string loop_rows(const std::string& head) {
  return head + "\n0,0\n1,1.5\n2,2.5\n3,4\n2,3.5\n1,2\n0,0.1\n1,1.4\n2,2.6\n1,2.1\n0,0\n";
}

}  // namespace

TEST_CASE("fit: models are named by their words, and the dynamic one alone with its own options") {
  check_fit_refused({"1", "--model", "elam,elamm"},
                    "there is no model 'elamm' [TB-USAGE]\n  at: --model\n  try: all, or some of elam, gpi, mpi, poly, "
                    "preisach, monotone; or dynamic alone");
  check_fit_refused({"1", "--model", ","}, "no model is named [TB-USAGE]\n  at: --model\n  try: e.g. --model all");
  const std::string at = " [TB-USAGE]\n  at: fit\n  try: ";
  for (const char* option : {"--rate", "--creep"})
    check_fit_refused({"1", "--model", "elam", option, "2"},
                      "--rate and --creep are of the dynamic model, and another is named" + at +
                          "add --model dynamic, or leave them out");
  check_fit_refused({"1", "--model", "dynamic", "--check", "m.json"},
                    "--check fits nothing, and the dynamic model is named to be fitted" + at +
                        "leave out --model, --rate and --creep to check a model, or --check to fit");
  check_fit_refused({"1", "--model", "dynamic,elam"},
                    "the dynamic model is fitted alone, and several models are named" + at +
                        "--model dynamic --rate RUN --creep RUN");
  for (const char* option : {"--rate", "--creep"})
    check_fit_refused(
        {"1", option, "2"},
        "lag and creep come from two further runs of the sensor, one of recipe rate and one of "
        "creep-levels, and one alone is named" +
            at +
            "measure the other (tactbench run rate creep-levels) and name both, --rate RUN --creep RUN; or "
            "name none, and both are left in");
  const std::string own =
      "the dynamic model is of all sequences of a run and of its whole array, always on the "
      "linearised output" +
      at + "leave out --fit, --mean-taxel and the options of other models";
  for (const FitWords& more : std::vector<FitWords>{{"--mode", "paper"},
                                                    {"--identify", "exact"},
                                                    {"--linearise"},
                                                    {"--memory"},
                                                    {"--exact-outer"},
                                                    {"--splits", "1"},
                                                    {"--starts", "1"},
                                                    {"--fit", "up"},
                                                    {"--mean-taxel"}}) {
    FitWords words = {"1", "--model", "dynamic"};
    words.insert(words.end(), more.begin(), more.end());
    check_fit_refused(words, own);
  }
  check_fit_refused({"t.csv", "--model", "dynamic"}, own);
  check_fit_refused(
      {"1", "--lab", "lab.toml"},
      "--lab is for judging, and there are no limits [TB-USAGE]\n  at: --lab\n  try: add --limits FILE, or "
      "leave --lab out");
  check_fit_refused(
      {"1", "--model", "elam,mpi", "-o", "m.json"},
      "--output takes one model, and several are named [TB-USAGE]\n  at: fit --output\n  try: name one with "
      "--model");
  check_fit_refused({"1", "--model", "elam,mpi", "--limits", "limits.toml"},
                    "--limits judges one model, and several are named" + at + "name one with --model");
}

TEST_CASE("fit: several runs are numbers and ranges with commas between, and not judged") {
  for (const char* runs : {"1-2", "1,2", "3-3", "1,", "10-12,3", "1-1,1-1"}) {
    INFO(runs);
    CHECK(bench::names_runs(runs));
  }
  for (const char* other : {"", "1", "-", ",", "a-b", "2-1", "0-1", "1-2x", "1x-2", "1-2-3", "-1,2", "t-1.csv", "1-",
                            "1,x", "1 ,2", "99999999999999999999-1"}) {
    INFO(other);
    CHECK_FALSE(bench::names_runs(other));
  }
  const std::string judged =
      "several runs are fitted with one model each, and not judged [TB-USAGE]\n  at: fit\n  try: leave out --score, "
      "--held-out, --rate, --creep, --output, and name one --model; or name one run";
  for (const FitWords& more :
       std::vector<FitWords>{{"--model", "elam,mpi"}, {"-o", "m.json"}, {"--score", "3"}, {"--held-out", "3"}}) {
    FitWords words = {"1-2"};
    words.insert(words.end(), more.begin(), more.end());
    check_fit_refused(words, judged);
  }
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  {
    db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
    (void)store_example(store);  // run 1, void
    (void)begin_example(store);  // run 2 has not ended
    db::RunRecord bare = example_run();
    store.end_run(store.begin_run(bare), db::Outcome::kFailed, "", db::SafeState::kVerified, kUtc);  // without frames
    (void)store_example(store);                                                                      // run 4
    store.void_run(1, "x", "y", kUtc);
  }
  check_fit_refused({"1-3", "--db", path},
                    "of the runs 1-3 none can be fitted [TB-FIT-NONE]\n  at: " + path +
                        "\n  try: tactbench runs list shows what there is; void runs are taken with --void-too");
  for (const FitWords& more : std::vector<FitWords>{{}, {"--void-too"}}) {
    FitWords words = {"fit", "1-4", "--db", path, "--model", "elam"};
    words.insert(words.end(), more.begin(), more.end());
    const Finished some = verb_here(bench::add_fit, words);
    CHECK(some.code == 6);  // the example holds no loop
    CHECK((some.out.find("run     1: not fitted: ") != std::string::npos) == !more.empty());
    CHECK(some.out.find("run     4: not fitted: ") != std::string::npos);
    CHECK_THAT(some.out, Catch::EndsWith(more.empty() ? "\n0 runs fitted, 1 not\n" : "\n0 runs fitted, 2 not\n"));
  }
}

TEST_CASE("fit: a table is not judged, not scored on itself, and each target is named once") {
  const TemporaryFolder folder;
  const std::string table = folder.path("t.csv"), other = folder.path("u.csv"), store = folder.path("runs.db");
  write_file(table, loop_rows("input,output"));
  write_file(other, loop_rows("input,output"));
  const auto said = [&](const FitWords& more) {
    FitWords words = {"fit", table, "--db", store, "-q"};
    words.insert(words.end(), more.begin(), more.end());
    const Finished finished = verb_here(bench::add_fit, words);
    CHECK(finished.code == 2);
    return finished.err;
  };
  const std::string no_run =
      "error: --limits and --held-out take figures of an array's run, and this is a table or the mean taxel alone "
      "[TB-USAGE]\n  at: fit\n  try: leave them out, or fit a run that the bench made, without --mean-taxel\n";
  CHECK_THAT(said({"--limits", "limits.toml"}), Catch::EndsWith(no_run));
  CHECK_THAT(said({"--held-out", "2"}), Catch::EndsWith(no_run));
  CHECK_THAT(said({"--score", other + "," + other}),
             Catch::EndsWith("error: '" + other +
                             "' is named twice [TB-RUN-TWICE]\n  at: --score\n  try: name each run, "
                             "table or sequence once\n"));
  CHECK_THAT(said({"--score", "01,1"}), Catch::Contains("error: '1' is named twice [TB-RUN-TWICE]"));
  CHECK_THAT(said({"--score", table}),
             Catch::EndsWith("error: the models are made from " + table +
                             ": it is no independent data for them [TB-RUN-OWN]\n  at: --score\n  try: name other runs "
                             "or tables, or with --fit the sequences to fit, and score on the others\n"));
  CHECK_THAT(said({"--model", "elam,poly", "--score", folder.path("none.csv")}), Catch::Contains("[TB-TABLE-OPEN]"));
}

TEST_CASE("fit: the stages of its progress, with the shares of the time that each model takes") {
  const auto stages = [](const std::vector<std::string>& models) {
    std::string text;
    for (const bench::WorkStage& stage : bench::fit_stages(models))
      text += fmt::format("{} {:g}{}; ", stage.name, stage.share, stage.counted ? "" : " uncounted");
    return text;
  };
  const std::string begin = "reading the data 1; ", end = fmt::format("{} 1 uncounted; ", bench::kFiguresStage);
  CHECK(stages({}) == begin + "dynamic 10; elam 1; " + end);
  CHECK(stages({"gpi", "mpi", "poly", "preisach", "monotone", "elam", "dynamic", "other"}) ==
        begin + "gpi 85; mpi 4; poly 4; preisach 5; monotone 0.5; elam 1; dynamic 10; other 1; " + end);
}

TEST_CASE("fit: why ELAM is made where no model is named") {
  bench::FitModelsOptions options;
  analysis::Histories histories;
  histories.origin = "simulated";
  CHECK(bench::why_elam(options, histories).empty());
  histories.origin = "imported";
  histories.source = "t.csv";
  options.source = "t.csv";
  CHECK(bench::why_elam(options, histories) == "that is of runs of a bench, and t.csv is a table");
  histories.source = "run 3";
  options.source = "3";
  CHECK(bench::why_elam(options, histories) == "that is of runs of a bench, and run 3 is imported");
  for (const char* origin : {"imported", "simulated"}) {
    histories.origin = origin;
    options.elam_since = "so";
    CHECK(bench::why_elam(options, histories) == "so");
  }
  // Inner branches are open where every fitted taxel leaves something open.
  analysis::SensorModel model;
  CHECK(bench::without_inner_branches(model));
  for (int taxel = 0; taxel < 2; ++taxel) {
    model.taxels.emplace_back().status = analysis::TaxelStatus::kFitted;
    model.taxels.back().fit.undetermined = {"w"};
  }
  model.taxels.emplace_back().status = analysis::TaxelStatus::kDead;
  CHECK(bench::without_inner_branches(model));
  model.taxels[1].fit.undetermined.clear();
  CHECK_FALSE(bench::without_inner_branches(model));
}

TEST_CASE("sources: a run is named by up to eighteen digits, and a list by its commas") {
  for (const char* run : {"0", "12", "007", "999999999999999999"}) CHECK(bench::names_run(run));
  for (const char* other : {"", "1a", "-1", "1:2", "1.csv", "1000000000000000000"})
    CHECK_FALSE(bench::names_run(other));
  CHECK(bench::split_list("a,b") == FitWords{"a", "b"});
  CHECK(bench::split_list(",a,,b c,") == FitWords{"a", "b c"});
  CHECK(bench::split_list("").empty());
}

TEST_CASE("predict: taxels and columns that a table needs, by the exact words") {
  const TemporaryFolder folder;
  const std::string table = folder.path("t.csv"), model = folder.path("m.json");
  write_file(table, loop_rows("input,output"));
  REQUIRE(verb_here(bench::add_fit, {"fit", table, "--model", "poly", "-q", "-o", model}).code == 0);
  const auto predict = [&](const FitWords& more) {
    FitWords words = {"predict", model};
    words.insert(words.end(), more.begin(), more.end());
    return verb_here(bench::add_predict, words);
  };
  const Finished good = predict({table});
  CHECK(good.code == 0);
  CHECK_THAT(good.out, Catch::StartsWith("input,output,predicted\n0,0,"));
  const std::string missing = folder.path("none.csv");
  CHECK(predict({missing}).code == 2);
  CHECK_THAT(predict({missing}).err,
             Catch::Contains("[TB-TABLE-OPEN]") && Catch::Contains("check its name and rights; - is standard input"));
  write_file(folder.path("far.csv"), "input\n0\n3\n4\n3\n-1\n");
  const Finished far = predict({folder.path("far.csv")});
  CHECK(far.code == 0);
  CHECK_THAT(far.err, Catch::Contains("2 of 5 inputs lie outside the model's validity, 0 to 3 "));
  write_file(folder.path("semicolon.csv"), "input;output\n0,5;1\n1,5;2\n");
  const Finished comma = predict({folder.path("semicolon.csv")});
  CHECK(comma.code == 0);
  const std::string row = comma.out.substr(comma.out.find('\n') + 1, comma.out.find('\n', comma.out.find('\n') + 1));
  CHECK_THAT(row, Catch::StartsWith("0,5;1;") && !Catch::Contains("."));
}
