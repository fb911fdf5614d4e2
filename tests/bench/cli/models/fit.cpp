// Arguments that fit refuses, and how runs and sources are named.
#include <array>
#include <catch2/catch.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "analysis/models/linearised.h"
#include "analysis/models/mpi.h"
#include "bench/cli/models/fit.h"
#include "bench/cli/models/fit_models.h"
#include "bench/cli/runs/source.h"
#include "db/run_store.h"
#include "tests/analysis/support/judged_figures.h"
#include "tests/bench/cli/models/models_here.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/db/store_example.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

using FitWords = std::vector<std::string>;

void check_fit_refused(const FitWords& words, const std::string& id, const std::string& place) {
  const Finished finished = verb_here(bench::add_fit, joined_arguments({"fit"}, words));
  CAPTURE(words);
  CHECK(finished.code == 2);
  CHECK_THAT(finished.err, Catch::Contains("[" + id + "]\n  at: " + place + "\n"));
  CHECK(finished.out.empty());
}

std::string loop_rows(const std::string& head) {
  return head + "\n0,0\n1,1.5\n2,2.5\n3,4\n2,3.5\n1,2\n0,0.1\n1,1.4\n2,2.6\n1,2.1\n0,0\n";
}

}  // namespace

TEST_CASE("fit: rejects unknown model names, and options that do not belong to the model") {
  const std::vector<std::pair<FitWords, std::string>> refused = {
      {{"1", "--model", "elamm"}, "--model"},
      {{"1", "--model", ","}, "--model"},
      {{"1", "--model", "elam,mpi"}, "--model"},
      {{"1", "--model", "elam", "--rate", "2"}, "fit"},
      {{"1", "--model", "elam", "--creep", "2"}, "fit"},
      {{"1", "--rate", "2"}, "fit"},
      {{"1", "--creep", "2"}, "fit"},
      {{"1", "--model", "dynamic", "--mode", "paper"}, "fit"},
      {{"1", "--model", "dynamic", "--identify", "exact"}, "fit"},
      {{"1", "--model", "dynamic", "--linearise"}, "fit"},
      {{"1", "--model", "dynamic", "--memory"}, "fit"},
      {{"1", "--model", "dynamic", "--exact-outer"}, "fit"},
      {{"1", "--model", "dynamic", "--splits", "1"}, "fit"},
      {{"1", "--model", "dynamic", "--starts", "1"}, "fit"},
      {{"1", "--model", "dynamic", "--fit", "up"}, "fit"},
      {{"1", "--model", "dynamic", "--mean-taxel"}, "fit"},
      {{"t.csv", "--rate", "2", "--creep", "3"}, "fit"},
      {{"1-2", "-o", "m.json"}, "fit"},
      {{"1-2", "--score", "3"}, "fit"}};
  for (const auto& [words, place] : refused) check_fit_refused(words, "TB-USAGE", place);
  for (const FitWords& words : {FitWords{"compare", "1", "--models", "elam,elamm"},
                                {"compare", "1", "--models", "dynamic,elam"},
                                {"compare", "1-2"}})
    CHECK_THAT(verb_here(bench::add_compare, words).err, Catch::Contains("[TB-USAGE]"));
}

TEST_CASE("fit: a list of runs is numbers and ranges with commas, void and incomplete runs are left out") {
  for (const char* runs : {"1-2", "1,2", "3-3", "1,", "10-12,3", "1-1,1-1"}) {
    INFO(runs);
    CHECK(bench::is_run_list(runs));
  }
  for (const char* other : {"", "1", "-", ",", "a-b", "2-1", "0-1", "1-2x", "1x-2", "1-2-3", "-1,2", "t-1.csv", "1-",
                            "1,x", "1 ,2", "99999999999999999999-1"}) {
    INFO(other);
    CHECK_FALSE(bench::is_run_list(other));
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
  check_fit_refused({"1-3", "--db", path}, "TB-FIT-NONE", path);
  for (const bool void_too : {false, true}) {
    FitWords words = {"fit", "1-4", "--db", path, "--model", "elam", "--json"};
    if (void_too) words.emplace_back("--void-too");
    const Finished some = verb_here(bench::add_fit, words);
    CHECK(some.code == 6);  // the example holds no loop
    CHECK(nlohmann::json::parse(some.out).at("runs").size() == (void_too ? 2 : 1));
  }
}

TEST_CASE("fit: a table is not scored on itself, and each score target is named only once") {
  const TemporaryFolder folder;
  const std::string table = folder.path("t.csv"), other = folder.path("u.csv"), store = folder.path("runs.db");
  write_file(table, loop_rows("input,output"));
  write_file(other, loop_rows("input,output"));
  const auto said = [&](const FitWords& more) {
    const Finished finished = verb_here(bench::add_fit, joined_arguments({"fit", table, "--db", store, "-q"}, more));
    CHECK(finished.code == 2);
    return finished.err;
  };
  CHECK_THAT(said({"--score", other + "," + other}),
             Catch::Contains("[TB-RUN-TWICE]") && Catch::Contains("\n  at: --score\n"));
  CHECK_THAT(said({"--score", "01,1"}), Catch::Contains("[TB-RUN-TWICE]"));
  CHECK_THAT(said({"--score", table}), Catch::Contains("[TB-RUN-OWN]") && Catch::Contains("\n  at: --score\n"));
  CHECK_THAT(said({"--model", "elam", "--score", folder.path("none.csv")}), Catch::Contains("[TB-TABLE-OPEN]"));
}

TEST_CASE("sources: a run number has up to 18 digits, a list is split at its commas") {
  for (const char* run : {"0", "12", "007", "999999999999999999"}) CHECK(bench::is_run_number(run));
  for (const char* other : {"", "1a", "-1", "1:2", "1.csv", "1000000000000000000"})
    CHECK_FALSE(bench::is_run_number(other));
  CHECK(bench::split_list("a,b") == FitWords{"a", "b"});
  CHECK(bench::split_list(",a,,b c,") == FitWords{"a", "b c"});
  CHECK(bench::split_list("").empty());
}

// The JSON of `fit` for one fitted model with known numbers.

using namespace tactbench::bench;

namespace {

analysis::ModelTaxel taxel_with_divider(int number, double c) {
  analysis::ModelTaxel taxel;
  taxel.taxel = number;
  taxel.status = analysis::TaxelStatus::kFitted;
  auto inner = std::make_shared<analysis::MpiModel>(analysis::MpiParameters{0.1, 0.0, 0.0, 3.0, 5.0}, 0.0, 60.0, 0.0);
  analysis::Divider divider;
  divider.per_amplitude = c;
  taxel.fit.model = std::make_unique<analysis::LinearisedModel>(divider, std::move(inner));
  taxel.fit.j = 0.125;
  taxel.fit.mean_error = 0.02;
  taxel.fit.max_error = 0.06;
  taxel.fit.full_scale = 2.0;
  const std::array<double, 2> x = {0.0, 60.0}, y = {0.5, 2.0};
  taxel.ascending = analysis::PatternCurve(x, y, 0.5, 2.0);
  return taxel;
}

// 4 x 4 taxels, of which all but 0 and 1 are dead, and the mean taxel.
analysis::SensorModel array_model() {
  analysis::SensorModel model;
  model.model = "mpi";
  model.run = 3;
  model.origin = "simulated";
  model.rows = model.columns = 4;
  model.input_unit = "psi";
  model.output_unit = "V";
  model.taxels.push_back(taxel_with_divider(0, 0.0));
  model.taxels.push_back(taxel_with_divider(1, 0.25));
  for (int taxel = 2; taxel < 16; ++taxel) {
    analysis::ModelTaxel& dead = model.taxels.emplace_back();
    dead.taxel = taxel;
    dead.status = analysis::TaxelStatus::kDead;
  }
  model.taxels.push_back(taxel_with_divider(analysis::kMeanTaxel, 0.125));
  return model;
}

}  // namespace

TEST_CASE("fit text: the JSON document of a fit has all its members") {
  analysis::SensorModel model = array_model();
  model.repeats = {{"up", 0.001, 0.0002, 0.003, 0.0004, true}};
  FittedRun fitted;
  fitted.model = &model;
  fitted.evaluations.emplace_back();
  nlohmann::ordered_json json;
  add_fitted_json(fitted, json);
  tests::check_members(json, R"({"run": 3, "taxels": 16, "fitted_taxels": 2})");
  CHECK(json.at("left_out").size() == 14);
  tests::check_members(json.at("left_out").at(0), R"({"taxel": 2, "row": 0, "column": 2, "status": "dead"})");
  const auto& mean = json.at("mean_taxel");
  tests::check_members(mean, R"({"status": "fitted", "j_v2": 0.125, "mean_error_v": 0.02, "max_error_v": 0.06,
                          "full_scale_v": 2.0, "mean_error_fs": 0.01, "c_per_v": 0.125})");
  CHECK_FALSE(mean.contains("alpha_d"));
  CHECK(json.at("evaluations").size() == 1);
  CHECK(json.at("repeats").at(0) == nlohmann::ordered_json::parse(
                                        R"({"sequence": "up", "first_differs": true, "shift_v": 0.001,
                                            "uncertainty_v": 0.0002, "rms_v": 0.003, "others_rms_v": 0.0004})"));
  CHECK(json.at("verdicts").empty());
  CHECK_FALSE(json.contains("judgement"));
  analysis::SensorModel bare = array_model();
  bare.taxels.back().ascending = {};  // its full scale is not known
  FittedRun unscaled;
  unscaled.model = &bare;
  nlohmann::ordered_json without;
  add_fitted_json(unscaled, without);
  CHECK(without.at("mean_taxel").at("mean_error_fs") == 0.0);
  fitted.judgement = analysis::by_hand::judgement_of(
      {analysis::by_hand::judged_figure(2, analysis::Criterion::kMeanError, 1.0, 2.0, analysis::Verdict::kPass)});
  nlohmann::ordered_json judged;
  add_fitted_json(fitted, judged);
  CHECK(judged.at("verdicts").at(0).at("shown") == "simulated pass");
  CHECK(judged.at("judgement").at("overall") == "pass");
}

// Numbers of options at the ends of what is taken, and just beyond, of the verbs of models and of the fleet.

namespace {

struct EdgesOfOption {
  std::string name;
  std::vector<std::string> taken, refused;
};

// `words` fail for another reason than their form: a file that is not there, a server that is away.
void check_edges(AddVerb add, const std::vector<std::string>& words, const std::vector<EdgesOfOption>& options) {
  const auto is_of_form = [&](const std::string& name, const std::string& value) {
    const Finished finished = verb_here(add, joined_arguments(words, {name, value}));
    CHECK(finished.code != 0);
    return !finished.err.starts_with("parse: ");
  };
  for (const EdgesOfOption& option : options) {
    for (const std::string& value : option.taken) {
      INFO(option.name << " " << value);
      CHECK(is_of_form(option.name, value));
    }
    for (const std::string& value : option.refused) {
      INFO(option.name << " " << value);
      CHECK_FALSE(is_of_form(option.name, value));
    }
  }
}

}  // namespace

TEST_CASE("options of fit, live and compensate: smallest and largest accepted values") {
  const TemporaryFolder folder;
  const std::string none = folder.path("none.csv");
  check_edges(bench::add_fit, {"fit", none, "--model", "elam"},
              {{"--splits", {"1", "8"}, {"0", "9"}},
               {"--starts", {"1", "4096"}, {"0", "4097"}},
               {"--rate", {"1"}, {"0", "-1"}},
               {"--creep", {"1"}, {"0", "-1"}},
               {"--mode", {"paper", "free-run"}, {"free", ""}},
               {"--identify", {"exact", "ga"}, {"genetic"}}});
  check_edges(bench::add_live, {"live", "--bench", "simulated.toml", "--model", folder.path("none.json")},
              {{"--frames", {"0", "1"}, {"-1"}},
               {"--interval", {"0", "60"}, {"-0.1", "60.1"}},
               {"--scans", {"1", "64"}, {"0", "65"}}});
  check_edges(bench::add_predict, {"compensate", folder.path("none.json"), none},
              {{"--conditioned", {"0", "1e9"}, {"-1", "1.1e9"}}, {"--taxel", {"0", "1", "mean"}, {"-1", "means"}}});
}

TEST_CASE("options of fleet: smallest and largest accepted values") {
  const TemporaryFolder folder;
  db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
  check_edges(bench::add_fleet,
              {"fleet", "push", "--db", folder.path("runs.db"), "--to", "host=" + folder.path() + " dbname=x"},
              {{"--patience", {"1", "3600"}, {"0", "3601"}}});
  for (const char* verb : {"runs", "trend"})
    check_edges(bench::add_fleet, {"fleet", verb, "--from", "host=" + folder.path() + " dbname=x"},
                {{"--origin", {"hardware", "simulated", "imported"}, {"real", ""}}});
}
