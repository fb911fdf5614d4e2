// `fit` of tables of one taxel: what it says of its data, what it scores on, what it keeps, in words and as JSON.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/common/build_info.h"
#include "tests/bench/cli/models/models_here.h"
#include "tests/bench/cli/play_table.h"

using namespace tactbench;
using namespace tactbench::tests;

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
    return of.printed(joined_arguments({"t.csv"}, more)).at("models").at(0).at("model").get<std::string>();
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
    return of.printed(joined_arguments(words, {"--model", "monotone"})).at("models").at(0).at("shown_taxel").at("j");
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
