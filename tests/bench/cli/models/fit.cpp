// Arguments that fit refuses, and how runs and sources are named.

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "analysis/models/linearised.h"
#include "analysis/models/mpi.h"
#include "bench/cli/models/fit.h"
#include "bench/cli/models/fit_models.h"
#include "bench/cli/runs/source.h"
#include "bench/common/build_info.h"
#include "db/run_store.h"
#include "tests/analysis/support/judged_figures.h"
#include "tests/bench/cli/models/known_model.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/db/store_example.h"
#include "tests/support/text.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;

namespace {

using FitWords = std::vector<std::string>;

void check_fit_refused(const FitWords& words, const std::string& id, const std::string& place) {
  const Finished finished = verb_here(bench::add_fit, joined({"fit"}, words));
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
    const Finished finished = verb_here(bench::add_fit, joined({"fit", table, "--db", store, "-q"}, more));
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
    const Finished finished = verb_here(add, joined(words, {name, value}));
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

// `fit` of tables of one taxel: what it says of its data, what it scores on, what it keeps, in words and as JSON.

namespace {

using FitTableWords = std::vector<std::string>;

std::string rows_of_play(const std::string& sequence, const std::vector<double>& turns, double sign = 1.0) {
  std::string text;
  for (const PlaySample& sample : play_samples(turns))
    text += sequence + std::to_string(sample.input) + "," + std::to_string(sign * sample.output) + "\n";
  return text;
}

const std::vector<double> kLoops = {0, 10, 0, 10, 5, 10, 0};

// s.csv: sequences "full", "inner" and "more"; t.csv: the first alone.
struct FolderOfTables {
  FolderOfTables() {
    write_file(folder.path("s.csv"), "sequence,input,output\n" + rows_of_play("full,", kLoops) +
                                         rows_of_play("inner,", {0, 8, 2, 6, 3, 10, 0}) +
                                         rows_of_play("more,", {0, 10, 2, 9, 0}));
    write_file(folder.path("t.csv"), "input,output\n" + rows_of_play("", kLoops));
  }
  Finished fit(FitTableWords words) const {
    const auto models = std::ranges::find(words, "--model");
    const bool several = models != words.end() && models[1].find(',') != std::string::npos;
    if (several) *models = "--models";
    words.insert(words.begin(), several ? "compare" : "fit");
    return model_verb(folder, std::move(words));
  }
  nlohmann::json printed(FitTableWords words) const {
    words.emplace_back("--json");
    const Finished finished = fit(std::move(words));
    INFO(finished.err);
    REQUIRE(finished.code == 0);
    return nlohmann::json::parse(finished.out);
  }
  TemporaryFolder folder;
};

}  // namespace

TEST_CASE("fit of a table: the document lists the models with their values and scores in the requested order") {
  const FolderOfTables of;
  const nlohmann::json printed =
      of.printed({"s.csv", "--fit", "full", "--model", "poly,monotone", "--input-unit", "psi", "--output-unit", "V"});
  CHECK(of.printed({"t.csv"}).at("models").at(0).at("model") == "elam");  // where none is named
  check_members(printed, R"({"schema": "tactbench.compare", "source": "s.csv", "origin": "imported"})");
  CHECK((printed.at("input_unit") == "psi" && printed.at("output_unit") == "V"));
  CHECK(printed.at("falling") == false);
  CHECK(printed.at("fitted") == nlohmann::json{"full"});
  CHECK(printed.at("assumed").empty());
  CHECK(printed.at("warnings").size() == 1);
  CHECK(printed.at("turn").get<double>() == Approx(0.01).epsilon(0.01));
  CHECK(printed.at("noise").get<double>() > 0.0);
  CHECK(printed.at("models_left_out").empty());
  REQUIRE(printed.at("models").size() == 2);
  CHECK(printed.at("models").at(0).at("model") == "poly");
  CHECK(printed.at("models").at(1).at("model") == "monotone");
  for (const nlohmann::json& model : printed.at("models")) {
    CHECK(model.at("fit") == 0);  // a table's models have no store
    CHECK(model.at("scores").size() == 1);
    CHECK(model.at("scores").at(0).at("on") == "inner, more of s.csv");
    CHECK_FALSE(model.contains("figures"));
  }
  CHECK_FALSE(std::filesystem::exists(of.folder.path("runs.db")));
  const nlohmann::json whole =
      of.printed({"s.csv", "--model", "monotone"});  // three inner branches: enough to leave some out
  CHECK(whole.at("models").at(0).at("shown_taxel").at("cross_validated").at("samples").get<int>() > 0);
  CHECK(whole.at("models").at(0).at("scores").empty());
}

TEST_CASE("fit of a table: a model that the data do not support is left out, a stored model states how it was made") {
  const FolderOfTables of;
  write_file(of.folder.path("inner.csv"), "input,output\n" + rows_of_play("", {0, 10, 4, 8, 3, 9, 5, 7, 2, 8, 4}));
  const nlohmann::json printed = of.printed({"inner.csv", "--model", "elam,monotone"});
  CHECK(printed.at("models").size() == 1);
  REQUIRE(printed.at("models_left_out").size() == 1);
  CHECK(printed.at("models_left_out").at(0).at("model") == "elam");
  CHECK(of.fit({"inner.csv", "--model", "monotone,elam"}).code == 0);
  check_refusal(of.fit({"inner.csv", "--model", "elam"}), 6, "TB-ANALYSIS-NO-LOOP");
  CHECK(of.fit({"t.csv", "--model", "monotone", "--mount", "glued", "--interface", "film", "--splits", "1", "-o",
                "m.json", "--input-unit", "N"})
            .code == 0);
  const nlohmann::json model = nlohmann::json::parse(read_file(of.folder.path("m.json")));
  CHECK(model.at("validity").at("mount") == "glued");
  CHECK(model.at("validity").at("interface_material") == "film");
  CHECK(model.at("program_version") == bench::build_info().version);
  CHECK(of.fit({"t.csv", "--model", "poly", "-o", "t.csv"}).code == 2);
  CHECK_THAT(read_file(of.folder.path("t.csv")), Catch::StartsWith("input,output\n"));
  write_file(of.folder.path("two.csv"),
             "taxel,input,output\n" + rows_of_play("0,", kLoops) + rows_of_play("1,", kLoops, 2.0));
  const nlohmann::json mean = of.printed({"two.csv", "--mean-taxel", "--model", "monotone"});
  CHECK(mean.at("models").at(0).at("shown_taxel").at("taxel") == -1);
}

TEST_CASE("fit of an imported run: models are stored under its number, the dynamic model is rejected") {
  const FolderOfTables of;
  REQUIRE(
      verb_here(bench::add_runs, {"runs", "import", of.folder.path("t.csv"), "--db", of.folder.path("runs.db")}).code ==
      0);
  CHECK(of.fit({"1", "--model", "dynamic"}).code == 2);
  CHECK(of.printed({"1"}).at("models").at(0).at("model") == "elam");
  const nlohmann::json printed = of.printed({"1", "--model", "poly,monotone", "--score", of.folder.path("s.csv")});
  CHECK((printed.at("models").at(0).at("fit") == 2 && printed.at("models").at(1).at("fit") == 3));
  CHECK(printed.at("source") == "run 1");
  CHECK(of.fit({"1", "--model", "poly", "--held-out", "1"}).code == 2);
  CHECK(model_verb(of.folder, {"model", "show", "1:3"}).code == 0);
}

TEST_CASE("fit --plot: draws the measured loop and each model, and does not overwrite a file of another kind") {
  const FolderOfTables of;
  const std::string plot = of.folder.path("loop.svg");
  (void)of.printed({"t.csv", "--model", "poly,monotone", "--plot", plot});
  const std::string svg = read_file(plot);
  CHECK(svg.starts_with("<svg xmlns=\"http://www.w3.org/2000/svg\""));
  for (const char* label : {"measured", "poly", "monotone"}) CHECK_THAT(svg, Catch::Contains(label));
  (void)of.printed({"t.csv", "--plot", plot});
  CHECK(of.fit({"t.csv", "--plot", of.folder.path("s.csv")}).code == 2);
}

TEST_CASE("report: an imported table is reported without models, or with the errors of each model") {
  const FolderOfTables of;
  const std::string db = of.folder.path("runs.db");
  REQUIRE(verb_here(bench::add_runs, {"runs", "import", of.folder.path("t.csv"), "--db", db}).code == 0);
  const auto report = [&] {
    const std::string file = of.folder.path("r.json");
    CHECK(verb_here(bench::add_report, {"report", "1", "--db", db, "--format", "json", "-o", file}).code == 0);
    return nlohmann::json::parse(read_file(file));
  };
  CHECK(report().at("models").empty());
  const nlohmann::json printed = of.printed({"1", "--model", "poly,monotone", "--score", of.folder.path("t.csv")});
  const nlohmann::json of_models = report();
  REQUIRE(of_models.at("models").size() == 2);
  for (std::size_t i = 0; i < 2; ++i) {
    const nlohmann::json& score = printed.at("models").at(i).at("scores").at(0).at("all");
    CHECK(of_models.at("models").at(i).at("input_error").at("mean") == score.at("compensated").at("mean"));
    CHECK(of_models.at("models").at(i).at("output_error").at("max") == score.at("direct").at("max"));
  }
  CHECK(verb_here(bench::add_report, {"report", "1", "--db", db}).code == 0);
  const std::string page = read_file(of.folder.path("reports/run-1.html"));
  CHECK_THAT(page, Catch::Contains("<svg") && Catch::Contains("monotone"));
  CHECK(verb_here(bench::add_report, {"report", "sign", "1", "--db", db, "--by", "K. Lee"}).code == 2);
}

TEST_CASE("fit: options apply to the model that they belong to") {
  const FolderOfTables of;
  const auto label = [&](const FitTableWords& more) {
    return of.printed(joined({"t.csv"}, more)).at("models").at(0).at("model").get<std::string>();
  };
  CHECK(label({"--model", "elam"}) == "elam");
  CHECK(label({"--model", "elam", "--mode", "paper", "--identify", "exact"}) == "elam");
  CHECK(label({"--model", "elam", "--mode", "free-run", "--memory", "--exact-outer", "--splits", "2"}) ==
        "elam, free run, memory, exact outer, 2 splits");
  CHECK(label({"--model", "mpi", "--linearise"}) == "mpi, linearised");
  const nlohmann::json starts = of.printed({"t.csv", "--model", "gpi", "--starts", "2"});
  CHECK(starts.at("models").at(0).at("shown_taxel").at("starts") == 2);
}

TEST_CASE("fit of a table: accepts tables without header, with lines above it, and with one column per taxel") {
  const FolderOfTables of;
  std::string bare, wide = "force,a,b\n";
  for (const PlaySample& sample : play_samples(kLoops)) {
    const std::string x = std::to_string(sample.input), y = std::to_string(sample.output);
    bare += x + " " + y + "\n";
    wide += x + "," + y + "," + std::to_string(2.0 * sample.output) + "\n";
  }
  write_file(of.folder.path("bare.csv"), bare);
  write_file(of.folder.path("late.csv"), "0 1 2\n" + bare);
  write_file(of.folder.path("wide.csv"), wide);
  const auto j = [&](const FitTableWords& words) {
    return of.printed(joined(words, {"--model", "monotone"})).at("models").at(0).at("shown_taxel").at("j");
  };
  const nlohmann::json named = j({"t.csv"});
  for (const FitTableWords& words : {FitTableWords{"bare.csv", "--map", "input=1,output=2"},
                                     FitTableWords{"bare.csv", "--map", "input=1,output=2", "--no-header"},
                                     FitTableWords{"late.csv", "--map", "input=1,output=2", "--skip-lines", "1"},
                                     FitTableWords{"wide.csv", "--map", "input=force,output=a"}})
    CHECK(j(words) == named);
  check_refusal(of.fit({"late.csv", "--map", "input=1,output=2", "--no-header"}), 2, "TB-TABLE-ROW");
  check_refusal(of.fit({"wide.csv", "--map", "input=force,output=a,output=b"}), 2, "TB-TABLE-MAP");
  CHECK(of.printed({"wide.csv", "--map", "input=force,output=2-3", "--mean-taxel", "--model", "monotone"})
            .at("models")
            .at(0)
            .at("shown_taxel")
            .at("taxel") == -1);  // the mean of both
  REQUIRE(of.fit({"t.csv", "--model", "monotone", "-o", "m.json"}).code == 0);
  const Finished predicted = model_verb(of.folder, {"predict", "m.json", "bare.csv", "--map", "input=1"});
  CHECK(predicted.code == 0);
  CHECK_THAT(predicted.out, Catch::StartsWith("0.000000 0.000000 "));
  check_refusal(model_verb(of.folder, {"compensate", "m.json", "wide.csv", "--map", "output=2-3"}), 2, "TB-TABLE-MAP");
}

TEST_CASE("fit of a table: reports a model with larger errors than a straight line on the scored sequence") {
  const FolderOfTables of;
  std::string straight;
  for (int i = 0; i <= 40; ++i) straight += "line," + std::to_string(0.25 * i) + "," + std::to_string(0.3 * i) + "\n";
  write_file(of.folder.path("line.csv"), read_file(of.folder.path("s.csv")) + straight);
  const auto worse = [&](const char* scored) {
    return of.printed({"line.csv", "--fit", "full", "--score", scored, "--model", "monotone"})
        .at("models")
        .at(0)
        .at("scores")
        .at(0)
        .at("worse_than_line")
        .get<bool>();
  };
  CHECK(worse("line"));
  CHECK_FALSE(worse("more"));
}
