// Models on any table, as a person uses them: exit codes, files.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "bench/common/build_info.h"
#include "db/run_store.h"
#include "tests/bench/cli/models/known_model.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/support/process.h"
#include "tests/support/run_recipe.h"
#include "tests/support/text.h"

using namespace tactbench::tests;
using nlohmann::json;

namespace {

// Sequences "full" (two cycles) and "inner".
std::string table(double sign = 1.0) {
  std::string text = "sequence,step,input,output\n";
  const auto add = [&](const std::string& name, const std::vector<double>& turns) {
    for (const PlaySample& sample : play_samples(turns))
      text += name + "," + std::to_string(sample.step) + "," + std::to_string(sample.input) + "," +
              std::to_string(sign * sample.output) + "\n";
  };
  add("full", {0, 10, 0, 10, 5, 10, 0});
  add("inner", {0, 8, 2, 6, 3, 10, 0});
  return text;
}

}  // namespace

TEST_CASE("compare: all models are fitted on one sequence of a table and scored on another") {
  const TemporaryFolder folder;
  write_file(folder.path("t.csv"), table());
  const json document = json::parse(well(call(folder, {"compare", "t.csv", "--fit", "full", "--json"})).out);
  REQUIRE(document["models"].size() == 6);
  CHECK(document["origin"] == "imported");
  double monotone = 0.0, preisach = 0.0;
  for (const json& model : document["models"]) {
    const json& score = model["scores"][0];
    CHECK(score["on"] == "inner of t.csv");
    CHECK(score["all"]["direct"]["samples"] == 240);
    CHECK(model["shown_taxel"]["parameters"].size() > 1);
    (model["model"] == "monotone" ? monotone : preisach) = score["all"]["compensated"]["mean"];
    if (model["model"] == "preisach") break;
  }
}

TEST_CASE("predict and compensate: a stored model works in a pipe, compensate restores the inputs of predict") {
  const TemporaryFolder folder;
  write_file(folder.path("t.csv"), table());
  REQUIRE(call(folder, {"fit", "t.csv", "--model", "preisach", "-o", "m.json"}).code == 0);
  const Finished predicted = call(folder, {"predict", "m.json", "t.csv"});
  INFO(predicted.err);
  REQUIRE(predicted.code == 0);
  const auto rows = cells_of(predicted.out);
  REQUIRE(rows.size() == 483);
  CHECK(rows[0].back() == "predicted");
  double worst = 0.0;
  for (std::size_t i = 1; i < rows.size(); ++i)
    worst = std::max(worst, std::abs(std::stod(rows[i][4]) - std::stod(rows[i][3])));
  CHECK(worst < 0.6);
  // What is predicted is compensated back to the very inputs.
  REQUIRE(call(folder, {"predict", "m.json", "t.csv", "-o", "p.csv"}).code == 0);
  CHECK(read_file(folder.path("p.csv")) == predicted.out);
  const Finished back = call(folder, {"compensate", "m.json", "p.csv", "--map", "output=predicted"});
  const auto inputs = cells_of(back.out);
  REQUIRE(inputs.size() == 483);
  int near = 0;
  for (std::size_t i = 1; i < inputs.size(); ++i)
    near += std::abs(std::stod(inputs[i][5]) - std::stod(inputs[i][2])) < 0.3 ? 1 : 0;
  CHECK(near > 440);
}

TEST_CASE("fit: a sensor with falling output is fitted and predicted with its own sign") {
  const TemporaryFolder folder;
  write_file(folder.path("t.csv"), table(-1.0));
  REQUIRE(call(folder, {"fit", "t.csv", "-o", "m.json"}).code == 0);
  const auto rows = cells_of(call(folder, {"predict", "m.json", "t.csv"}).out);
  REQUIRE(rows.size() == 483);
  CHECK(std::stod(rows[40][4]) < -5.0);
  CHECK(std::stod(rows[40][4]) == Approx(std::stod(rows[40][3])).margin(0.3));
}

TEST_CASE("fit: bad tables and models are rejected with an error id and exit code") {
  const TemporaryFolder folder;
  write_file(folder.path("t.csv"), table());
  write_file(folder.path("nan.csv"), "input,output\n1,2\n2,nan\n");
  write_file(folder.path("ragged.csv"), "input,output\n1,2\n2\n");
  write_file(folder.path("empty.csv"), "");
  write_file(folder.path("constant.csv"), "input,output\n1,2\n1,3\n1,4\n1,5\n");
  write_file(folder.path("up.csv"), "input,output\n0,0\n1,1\n2,2\n3,3\n4,4\n");
  well(call(folder, {"fit", "t.csv", "-o", "m.json"}));
  well(call(folder, {"fit", "up.csv", "--model", "monotone"}));
  struct RefusedTable {
    const char* words;
    int code;
    const char* id;
  };
  for (const auto& [words, code, id] :
       {RefusedTable{"fit nan.csv", 2, "TB-TABLE-ROW"}, RefusedTable{"fit ragged.csv", 2, "TB-TABLE-ROW"},
        RefusedTable{"fit empty.csv", 2, "TB-TABLE-EMPTY"}, RefusedTable{"fit missing.csv", 2, "TB-TABLE-OPEN"},
        RefusedTable{"fit constant.csv", 2, "TB-TABLE-CONSTANT"}, RefusedTable{"fit up.csv", 6, "TB-ANALYSIS-NO-LOOP"},
        RefusedTable{"fit up.csv --model preisach", 6, "TB-ANALYSIS-MODEL"},
        RefusedTable{"runs import nan.csv", 2, "TB-TABLE-ROW"}, RefusedTable{"fit t.csv --model duhem", 2, "TB-USAGE"},
        RefusedTable{"fit t.csv --fit sideways", 2, "TB-MODEL-SEQUENCE"},
        RefusedTable{"predict t.csv t.csv", 2, "TB-MODEL-DOCUMENT"},
        RefusedTable{"predict none.json t.csv", 2, "TB-MODEL-OPEN"},
        RefusedTable{"predict /dev/zero t.csv", 2, "TB-MODEL-OPEN"},
        RefusedTable{"model show /proc/self/mem", 2, "TB-MODEL-DOCUMENT"},  // says it is empty
        RefusedTable{"fit /dev/zero", 2, "TB-TABLE-OPEN"},
        RefusedTable{"predict m.json up.csv --map input=x", 2, "TB-TABLE-COLUMN"},
        RefusedTable{"compensate m.json t.csv --taxel 7", 2, "TB-MODEL-TAXEL"}}) {
    INFO(words);
    std::istringstream stream(words);
    check_refusal(call(folder, {std::istream_iterator<std::string>(stream), {}}), code, id);
  }
  CHECK_FALSE(std::filesystem::exists(folder.path("runs.db")));
}

// `fit` and the verbs that use models treat every model that can be inverted like ELAM.

TEST_CASE(
    "models: every kind is judged, verified, adjusted, streamed live and used as the as-found model of a report") {
  const TemporaryFolder folder;
  init_small_array(folder);
  well(call(folder, {"sensors", "add", "S-1", "--type", "sensor.toml"}));
  write_file(folder.path("small.toml"), small_loop_text(10));
  write_file(folder.path("wide.toml"), limits_text("simple", 60));
  for (const char* seed : {"1", "2"}) measure_small(folder, seed);
  REQUIRE(call(folder, {"fit", "1", "--model", "elam"}).code == 0);
  int fits = 1;
  for (const std::string model : {"gpi", "mpi", "poly", "preisach"}) {
    INFO(model);
    const std::string own = "1:" + std::to_string(fits + 1);
    const json document = json::parse(well(call(folder, {"fit", "1", "--model", model, "--starts", "1"},
                                                {"judge", own, "2", "--limits", "wide.toml", "--json"}))
                                          .out);
    CHECK(document["model"] == model);
    CHECK(document["evaluations"].size() == 2);
    CHECK(document["verdicts"].size() == 4);
    const std::string name = "1:" + std::to_string(++fits);
    well(call(folder, {"verify", "1"}));
    CHECK(call(folder, {"verify", "2"}).code == 0);
    REQUIRE(call(folder, {"model", "adjust", name, "2", "--zero", "-o", model + ".json"}).code == 0);
    // The report is of ELAM, which was not judged: it needs its own evidence.
    CHECK(call(folder, {"report", "1", "--held-out", "2", "--previous", model + ".json", "-o", "r.html"}).code == 0);
    const Finished live =
        call(folder, {"live", "--bench", "bench.toml", "--model", model + ".json", "--frames", "3", "--json"});
    INFO(live.err);
    CHECK(live.code == 0);
    CHECK(json::parse(live.out)["frames"] == 3);
  }
}

// `fit` of runs that the simulated rig made in seconds: figures, judgement, scores, limits of the profile, many runs.

using namespace tactbench;

namespace {

using FitRunWords = std::vector<std::string>;

// Runs 1 and 2 of one recipe with an inner loop, and run 3 of one without.
struct FolderOfRuns {
  FolderOfRuns() {
    REQUIRE(call(folder, {"init", "--operator", "tester"}).code == 0);
    REQUIRE(call(folder, {"sensors", "add", "S-1"}).code == 0);
    const std::string head = "schema = 1\nunit = \"psi\"\nstep = 10\nrepeats = 1\ndwell_s = 1.0\n";
    write_file(folder.path("a.toml"), head + "name = \"small\"\nturning_points = [0, 60, 20, 60, 0]\n");
    write_file(folder.path("b.toml"), head + "name = \"loop\"\nturning_points = [0, 60, 0]\n");
    for (const char* recipe : {"./a.toml", "./a.toml", "./b.toml"})
      REQUIRE(call(folder, {"run", recipe, "--bench", "bench.toml", "--sensor", "S-1", "-q", "--no-seating"}).code ==
              0);
    write_file(folder.path("wide.toml"), limits_text("simple", 60));
    write_file(folder.path("strict.toml"), limits_text("simple", 0.001));
  }
  Finished fit(FitRunWords words) const {
    words.insert(words.begin(), "fit");
    return call(folder, words);
  }
  nlohmann::json printed(FitRunWords words) const {
    words.emplace_back("--json");
    const Finished finished = fit(std::move(words));
    INFO(finished.err);
    REQUIRE_FALSE(finished.out.empty());
    return nlohmann::json::parse(finished.out);
  }
  std::size_t models() const {
    const db::RunStore store = db::RunStore::open_read_only(folder.path("runs.db"));
    std::size_t count = 0;
    for (const db::RunRecord& run : store.runs()) count += store.fits(run.run).size();
    return count;
  }
  TemporaryFolder folder;
};

}  // namespace

TEST_CASE("fit and judge: of a run one model is stored, its verdict is given as JSON and exit code") {
  const FolderOfRuns of;
  CHECK(of.fit({"1", "--model", "mpi", "-o", "m.json"}).code == 0);
  CHECK(of.models() == 1);
  const nlohmann::json document = nlohmann::json::parse(read_file(of.folder.path("m.json")));
  CHECK(document.at("model") == "mpi");
  CHECK(document.at("program_version") == bench::build_info().version);
  const auto judge = [&](const FitRunWords& more) { return call(of.folder, joined({"judge", "1:1"}, more)); };
  CHECK(judge({"2", "--limits", "./wide.toml"}).code == 0);
  CHECK(judge({"2", "--limits", "./strict.toml"}).code == 1);
  const nlohmann::json strict = nlohmann::json::parse(judge({"2", "--limits", "./strict.toml", "--json"}).out);
  CHECK(strict.at("model") == "mpi");
  CHECK((strict.at("taxels") == 256 && strict.at("fitted_taxels") == 256));
  REQUIRE(strict.at("evaluations").size() == 2);
  CHECK((strict.at("evaluations").at(0).at("run") == 1 && strict.at("evaluations").at(1).at("run") == 2));
  CHECK(strict.at("verdicts").size() == 4);
  CHECK(strict.at("judgement").at("overall") == "fail");
  for (const FitRunWords& wrong :
       {FitRunWords{}, FitRunWords{"2", "2"}, FitRunWords{"1"}, FitRunWords{"2", "--limits", "none.toml"},
        FitRunWords{"2", "--lab", "none.toml", "--limits", "./wide.toml"}})
    CHECK(judge(wrong).code == 2);
  CHECK_THAT(of.fit({"9", "--model", "mpi"}).err, Catch::Contains("[TB-STORE-NOT-FOUND]"));
  CHECK_THAT(call(of.folder, {"judge", "1:9", "2"}).err, Catch::Contains("[TB-STORE-NOT-FOUND]"));
  CHECK(of.models() == 1);
}

TEST_CASE("compare: of a run several models are stored and scored") {
  const FolderOfRuns of;
  const FitRunWords words = {"compare", "1", "--models", "mpi,poly", "--score", "2,3"};
  CHECK(call(of.folder, joined(words, {"--html", "c.html"})).code == 0);
  CHECK(of.models() == 2);
  CHECK_THAT(read_file(of.folder.path("c.html")), Catch::StartsWith("<!DOCTYPE html>"));
  const nlohmann::json compared = nlohmann::json::parse(call(of.folder, joined(words, {"--json"})).out);
  REQUIRE(compared.at("models").size() == 2);
  for (std::size_t i = 0; i < 2; ++i) {
    const nlohmann::json& model = compared.at("models").at(i);
    CHECK(model.at("fit") == 3 + i);
    REQUIRE(model.at("scores").size() == 2);
    CHECK((model.at("scores").at(0).at("on") == "run 2" && model.at("scores").at(1).at("on") == "run 3"));
    CHECK(model.at("scores").at(0).at("taxels") == 256);
  }
  CHECK((compared.at("origin") == "simulated" && compared.at("source") == "run 1"));
  CHECK_THAT(of.fit({"1", "--model", "mpi", "--score", "2,02"}).err, Catch::Contains("[TB-RUN-TWICE]"));
}

TEST_CASE("fit: of a run the default is the dynamic model, or ELAM if the run has no inner branches") {
  const FolderOfRuns of;
  CHECK(of.fit({"1", "-o", "m.json"}).code == 0);
  const nlohmann::json document = nlohmann::json::parse(read_file(of.folder.path("m.json")));
  CHECK(document.at("dynamics").at("rate").at("run") == 0);
  CHECK(document.at("program_version") == bench::build_info().version);
  const nlohmann::json run = nlohmann::json::parse(call(of.folder, {"runs", "show", "1", "--json"}).out);
  CHECK_THAT(document.dump(), Catch::Contains(run.at("content_sha256").get<std::string>()));
  const nlohmann::json scored = of.printed({"1", "--score", "2"});
  CHECK(scored.at("models").at(0).at("model") == "dynamic");
  CHECK(scored.at("models").at(0).at("scores").size() == 1);
  CHECK_FALSE(scored.at("models").at(0).at("shown_taxel").contains("cross_validated"));
  CHECK(of.printed({"3"}).at("model") == "elam");
  CHECK(of.fit({"3", "--model", "dynamic"}).code == 0);
  CHECK(of.fit({"3", "-q"}).err.empty());
  CHECK_THAT(of.fit({"1", "--rate", "9", "--creep", "2"}).err, Catch::Contains("[TB-STORE-NOT-FOUND]"));
}

TEST_CASE("fit: of several runs each run gets its own model, and a run that cannot be fitted gets an error") {
  const FolderOfRuns of;
  CHECK(of.fit({"1-3", "--model", "mpi"}).code == 0);
  const nlohmann::json printed = of.printed({"1,3", "--model", "mpi"});
  CHECK(printed.at("schema") == "tactbench.fit.runs");
  CHECK(printed.at("store") == "runs.db");
  REQUIRE(printed.at("runs").size() == 2);
  CHECK((printed.at("runs").at(0).at("run") == 1 && printed.at("runs").at(0).at("fit") == 4));
  CHECK((printed.at("runs").at(1).at("run") == 3 && printed.at("runs").at(1).at("taxels") == 256));
  const nlohmann::json single = of.printed({"3", "--model", "mpi"});
  CHECK(printed.at("runs").at(1).at("mean_error_psi") == single.at("evaluations").at(0).at("mean_error_psi"));
  CHECK(of.models() == 6);
  CHECK(of.fit({"1-3", "--model", "poly", "--fit", "small"}).code == 6);
  CHECK(of.fit({"1-2", "--model", "poly", "--mean-taxel"}).code == 2);
  // Some sequences of a run that has several.
  REQUIRE(call(of.folder, {"run", "./a.toml", "./b.toml", "--bench", "bench.toml", "--sensor", "S-1", "-q"}).code == 0);
  CHECK(of.fit({"4-4", "--model", "poly", "--fit", "loop"}).code == 0);
  const nlohmann::json failed = of.printed({"3-3", "--model", "poly", "--fit", "small"});
  CHECK(failed.at("runs").at(0).at("error").get<std::string>().starts_with("TB-"));
  CHECK_FALSE(failed.at("runs").at(0).contains("fit"));
}

// Samples that are none, and rows that no sensor gives: what fit and compensate make of them.

namespace {

using Rows = std::vector<std::string>;

const std::vector<double> kWay = {0, 10, 0, 10, 2, 8, 3, 10, 5, 9, 0, 10, 0};

Rows rows_of_way(int columns = 1) {
  Rows rows;
  for (const PlaySample& sample : play_samples(kWay)) {
    rows.push_back(std::to_string(sample.input));
    for (int k = 1; k <= columns; ++k) rows.back() += "," + std::to_string(k * sample.output);
  }
  return rows;
}

std::string text_of(const std::string& names, const Rows& rows) {
  std::string text = names + "\n";
  for (const std::string& row : rows) text += row + "\n";
  return text;
}

class FolderOfSamples {
 public:
  FolderOfSamples(const std::string& names, int columns, Rows options = {})
      : names_(names), rows_(rows_of_way(columns)) {
    write_file(folder_.path("t.csv"), text_of(names, rows_));
    options.insert(options.begin(), {"fit", "t.csv", "--model", "elam", "-o", "m.json"});
    REQUIRE(call(folder_, options).code == 0);
  }
  [[nodiscard]] const Rows& rows() const { return rows_; }
  [[nodiscard]] Finished verb(Rows words, const Rows& rows) const {
    write_file(folder_.path("x.csv"), text_of(names_, rows));
    return call(folder_, std::move(words));
  }

 private:
  TemporaryFolder folder_;
  std::string names_;
  Rows rows_;
};

}  // namespace

TEST_CASE("compensate: a row without an output is passed through and flagged, the other rows are unchanged") {
  const FolderOfSamples of("input,output", 1);
  constexpr std::size_t kPlace = 30;
  Rows without = of.rows();
  without.erase(without.begin() + kPlace);
  const Rows clean = lines_of(of.verb({"compensate", "m.json", "x.csv"}, without).out);
  for (const char* bad : {"5,nan", "5,", "5,OL", "5,-inf", "5,1e999", "5"}) {
    Rows rows = of.rows();
    rows[kPlace] = bad;
    const Finished done = of.verb({"compensate", "m.json", "x.csv"}, rows);
    INFO(bad << "\n" << done.err);
    CHECK(done.code == 0);
    CHECK_THAT(done.err, Catch::Contains("x.csv:32"));  // a line of names, and counted from 1
    Rows lines = lines_of(done.out);
    REQUIRE(lines.size() == clean.size() + 1);
    CHECK_THAT(lines[kPlace + 1], Catch::EndsWith(",nan,nan,bad"));
    lines.erase(lines.begin() + kPlace + 1);
    CHECK(lines == clean);
  }
}

TEST_CASE("compensate: an output outside the range of the taxel is flagged and ignored, the next rows are unchanged") {
  const FolderOfSamples of("input,output", 1);
  constexpr std::size_t kPlace = 30;
  Rows rows = of.rows(), without = rows;
  without.erase(without.begin() + kPlace);
  rows[kPlace] = "5,1000";
  const Rows clean = lines_of(of.verb({"compensate", "m.json", "x.csv"}, without).out);
  Rows lines = lines_of(of.verb({"compensate", "m.json", "x.csv"}, rows).out);
  REQUIRE(lines.size() == clean.size() + 1);
  CHECK_THAT(lines[kPlace + 1], Catch::EndsWith(",nan,nan,range"));
  lines.erase(lines.begin() + kPlace + 1);
  CHECK(lines == clean);
}

TEST_CASE("compensate: in a table with one column per taxel a missing output affects only its own taxel") {
  const FolderOfSamples of("input,s0,s1", 2, {"--map", "output=s*"});
  Rows rows = of.rows();
  const std::string row = rows[30];
  rows[30] = row.substr(0, row.rfind(',')) + ",OL";
  const Rows words = {"compensate", "m.json", "x.csv", "--map", "output=s*"};
  const Rows clean = lines_of(of.verb(words, of.rows()).out), lines = lines_of(of.verb(words, rows).out);
  REQUIRE(lines.size() == clean.size());
  CHECK_THAT(lines[31], Catch::EndsWith(",nan,nan,bad"));
  const auto first_taxel = [](const std::string& line) {  // behind the three columns of the table
    std::size_t at = 0;
    for (int k = 0; k < 3; ++k) at = line.find(',', at) + 1;
    return line.substr(at, line.find(',', at) - at);
  };
  for (std::size_t i = 0; i < lines.size(); ++i) CHECK(first_taxel(lines[i]) == first_taxel(clean[i]));
  for (std::string& own : rows) own = own.substr(0, own.rfind(',')) + ",OL";
  CHECK(of.verb(words, rows).code == 0);  // the other has outputs
}

TEST_CASE("compensate: rejects a table without any output, predict rejects a row without an input") {
  const FolderOfSamples of("input,output", 1);
  const Finished none = of.verb({"compensate", "m.json", "x.csv"}, {"1,a", "2,b", "3,c"});
  CHECK(none.code == 2);
  CHECK_THAT(none.err, Catch::Contains("TB-TABLE-SKIPPED"));
  const Finished predicted = of.verb({"predict", "m.json", "x.csv"}, {"1,1", "OL,2", "3,3"});
  CHECK(predicted.code == 2);
  CHECK_THAT(predicted.err, Catch::Contains("TB-TABLE-ROW") && !Catch::Contains("--skip-bad-rows"));
}

TEST_CASE("compare: an outlier is reported with its line and makes the taxel unfit, or its row is skipped on request") {
  const FolderOfSamples of("input,output", 1);
  Rows rows = of.rows();
  const auto cell = [](const std::string& row) { return row.substr(0, row.find(',')) + ",83886.07"; };
  rows[40] = cell(rows[40]);
  const Rows fit = {"compare", "x.csv", "--models", "elam,monotone"};
  const auto with = [&](const char* option) {
    Rows words = fit;
    words.emplace_back(option);
    return of.verb(words, rows);
  };
  const Finished printed = of.verb(fit, rows);
  CHECK(printed.code == 6);
  CHECK_THAT(printed.err, Catch::Contains("line 42"));
  CHECK_THAT(printed.out, Catch::Contains("unfit"));
  const auto reported_json = nlohmann::json::parse(with("--json").out);
  for (const auto& model : reported_json.at("models")) CHECK(model.at("left_out").at(0).at("status") == "unfit");
  Rows low = of.rows();  // where it would turn the sign of what follows the input
  low[1] = cell(low[1]);
  const Finished still = of.verb(fit, low);
  CHECK((still.code == 6 && still.out.find("unfit") != std::string::npos));
  const Finished without = with("--skip-bad-rows");
  CHECK(without.code == 0);
  CHECK_THAT(without.err, Catch::Contains("line 42"));
  Rows clean = of.rows();
  clean.erase(clean.begin() + 40);
  const Finished same = of.verb(fit, clean);
  CHECK(without.out == same.out);
}
