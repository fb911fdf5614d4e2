// report: what it tells and writes of runs with models and without, of several runs, in each format, and signed; and
// what it refuses of models and further runs. The runs are small, so that each call takes no longer than its process.
#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/bench/cli/small_bench.h"
#include "tests/support/in_terminal.h"

using namespace tactbench::tests;
using Told = nlohmann::ordered_json;

namespace {

// Runs 1 to 3 of one sensor, run 4 of another; models of run 1, judged on run 2 by the shipped limits.
struct RunsToReport {
  RunsToReport() {
    write_file(folder.path("small.toml"), small_loop_text());
    for (const char* sensor : {"S-1", "S-2"}) well(call(folder, {"sensors", "add", sensor, "--type", "sensor.toml"}));
    for (const char* seed : {"1", "2", "3", "4"})
      well(call(folder, {"run", "small.toml", "--bench", "simulated.toml", "--sensor",
                         std::string(seed) == "4" ? "S-2" : "S-1", "--operator", "t", "-q", "--seed", seed}));
    const Finished fit = call(folder, {"fit", "1", "--model", "elam"}, {"judge", "1", "2", "--limits", "limits.toml"});
    REQUIRE((fit.code == 0 || fit.code == 6));
  }
  Finished report(std::vector<std::string> words) const {
    words.insert(words.begin(), "report");
    return call(folder, words);
  }
  Told told(std::vector<std::string> words) const {
    words.emplace_back("--json");
    return Told::parse(report(std::move(words)).out);
  }
  void refused(const std::vector<std::string>& words, const std::string& said) const {
    const Finished done = report(words);
    CAPTURE(words);
    CHECK(done.code == 2);
    CHECK(done.out.empty());
    CHECK_THAT(done.err, Catch::Contains(said));
  }
  [[nodiscard]] bool exists(const std::string& name) const { return std::filesystem::exists(folder.path(name)); }
  TemporaryFolder folder;
};

}  // namespace

TEST_CASE("report: the verdicts of a judged run, its judgement and its file, also by models of another run") {
  const RunsToReport of;
  CHECK(of.report({"1"}).code == 6);
  const std::string number = of.told({"1"}).at("number");
  CHECK(number.starts_with("1-"));
  CHECK(of.report({"3", "--paper", "letter", "--units", "bar"}).code == 0);
  // The judgement of one run, and its models by another run's.
  const Told one = of.told({"1"});
  CHECK(one.at("schema") == "tactbench.report");
  CHECK(one.at("run") == 1);
  CHECK(one.at("runs") == Told::array({1}));
  CHECK(one.at("number") == number);
  check_members(one, R"({"path": "reports/run-1.html", "written": true, "origin": "simulated"})");
  CHECK(one.at("verdicts").size() == 10);
  CHECK(one.at("judgement").at("overall") == "inconclusive");
  CHECK_FALSE(one.contains("judgements"));
  const Told by_other = of.told({"2", "--model", "1"});
  CHECK(by_other.at("verdicts").size() == 10);
  CHECK(by_other.at("verdicts").at(0).at("run") == 2);
  CHECK(by_other.at("verdicts").at(0).at("model_run") == 1);
  CHECK(of.told({"2", "--model", "1:1"}).at("number") == by_other.at("number"));
  const Told held_out = of.told({"1", "--held-out", "3", "--limits", "limits.toml"});
  CHECK(held_out.at("judgement").at("runs").size() == 1);
  CHECK(held_out.at("judgement").at("runs").at(0).at("run") == 3);
  const Told both = of.told({"2", "--model", "1", "--held-out", "3", "--limits", "limits.toml"});
  CHECK(both.at("judgement").at("runs").size() == 2);
}

TEST_CASE("report: two runs compared and a batch, with the judgement of each") {
  const RunsToReport of;
  CHECK(of.report({"--compare", "1", "2"}).code == 6);
  const std::string number = of.told({"--compare", "1", "2"}).at("number");
  CHECK(number.starts_with("1-2-"));
  CHECK(of.report({"--compare", "1", "4"}).code == 6);  // of another sensor
  const Told told = of.told({"--compare", "1", "2"});
  CHECK(told.at("runs") == Told::array({1, 2}));
  CHECK(told.at("judgements").size() == 2);
  CHECK(told.at("judgements").at(0).at("overall") == "inconclusive");
  CHECK_FALSE(told.contains("judgement"));
  const Told other_way = of.told({"--compare", "2", "1"});
  CHECK(other_way.at("path") == "reports/compare-2-1.html");
  const Told batch = of.told({"--batch", "1", "3", "4"});
  CHECK(batch.at("judgements").size() == 2);  // a row for each sensor
  CHECK(batch.at("path") == "reports/batch-" + batch.at("number").get<std::string>() + ".html");
  CHECK(of.report({"--batch", "3", "4"}).code == 0);
  CHECK(of.told({"--compare", "1", "2", "--format", "json", "-o", "c.json"}).at("path") == "c.json");
  CHECK(Told::parse(read_file(of.folder.path("c.json"))).at("schema") == "tactbench.comparison");
  of.report({"--batch", "3", "4", "--format", "json", "-o", "b.json"});
  CHECK(Told::parse(read_file(of.folder.path("b.json"))).at("schema") == "tactbench.batch");
  // A file of one kind is not written over by another kind.
  of.refused({"1", "--format", "json", "-o", "b.json"}, "b.json");
  of.refused({"1", "-o", "c.json"}, "c.json");
  CHECK(of.report({"1", "--format", "json", "-o", "b.json", "--replace"}).code == 6);
  CHECK(Told::parse(read_file(of.folder.path("b.json"))).at("schema") == "tactbench.report");
  CHECK(of.report({"1", "--format", "json", "-o", "b.json"}).code == 6);
}

TEST_CASE("report: signed once it keeps its number, its file and what replaced it") {
  const RunsToReport of;
  of.refused({"sign", "3", "--by", "K. Lee"}, "[TB-REPORT-NO-VERDICT]");  // nobody is asked: no terminal
  // A file of somebody else ends it before anything is signed.
  of.refused({"sign", "3", "--by", "K. Lee", "--without-verdict", "-o", "small.toml"}, "small.toml");
  CHECK(Told::parse(call(of.folder, {"report", "list", "--json"}).out).at("reports").empty());
  REQUIRE(of.report({"sign", "3", "--by", "K. Lee", "--without-verdict"}).code == 0);
  const std::string number = of.told({"3"}).at("number"), path = "reports/run-" + number + ".html";
  CHECK_FALSE(of.exists("reports/run-3.html"));
  const std::string page = read_file(of.folder.path(path));
  CHECK(call(of.folder, {"report", "verify", number}).code == 0);
  const Finished again = of.report({"3"});
  CHECK(of.told({"3"}).at("written") == false);
  CHECK(read_file(of.folder.path(path)) == page);
  // A file that was changed since does not become the signed one by another call.
  write_file(of.folder.path(path), page + "<!-- more -->");
  CHECK(of.report({"3"}).out == again.out);
  CHECK(call(of.folder, {"report", "verify", number}).code == 1);
  write_file(of.folder.path(path), page);
  CHECK(call(of.folder, {"report", "verify", number}).code == 0);
  const Finished twice = of.report({"sign", "3", "--by", "M. Ito", "--without-verdict"});
  CHECK(twice.code == 5);
  CHECK(twice.out.empty());
  CHECK(of.report({"sign", "3", "2", "--by", "M. Ito", "--without-verdict", "--reason", "one more"}).code == 0);
  const Told listed = Told::parse(call(of.folder, {"report", "list", "3", "--json"}).out).at("reports");
  REQUIRE(listed.size() == 2);
  CHECK(listed.at(0).at("replaces") == "");
  CHECK(listed.at(1).at("replaces") == number);
  CHECK(listed.at(1).at("reason") == "one more");
  CHECK(listed.at(1).at("by") == "M. Ito");
}

TEST_CASE("report: without a verdict a person at the terminal is asked whether to sign") {
  const RunsToReport of;
  const auto answer = [&](const std::string& typed) {
    InTerminal terminal(of.folder.path(), {"report", "sign", "3", "--by", "K. Lee"}, 100, 30);
    REQUIRE(terminal.shows("y/n"));
    terminal.type(typed);
    return terminal.wait();
  };
  for (const char* no : {"n\n", "\n", "yep\n"}) CHECK(answer(no) == 2);
  CHECK(Told::parse(call(of.folder, {"report", "list", "--json"}).out).at("reports").empty());
  CHECK(answer("y\n") == 0);
  CHECK(Told::parse(call(of.folder, {"report", "list", "--json"}).out).at("reports").size() == 1);
}

TEST_CASE("report: models and further runs that it cannot use") {
  const RunsToReport of;
  for (const auto& words : std::vector<std::vector<std::string>>{
           {"9"}, {"1", "--previous", "9"}, {"1", "--studies", "9"}, {"1", "9"}, {"1", "--model", "9"}})
    of.refused(words, "[TB-STORE-NOT-FOUND]");
  of.refused({"1", "--held-out", "1"}, "[TB-RUN-OWN]\n  at: --held-out\n");
  of.refused({"2", "--model", "1", "--held-out", "2"}, "[TB-RUN-TWICE]\n  at: --held-out\n");
  check_refusal(of.report({"1", "4"}), 6, "TB-ANALYSIS-OTHER-SENSOR");
  of.refused({"1", "--lab", "none.toml"}, "none.toml");
  of.refused({"1", "--studies", "1"}, "\n  at: --studies 1\n");
  of.refused({"1", "--studies", "2", "--model", "2"}, "TB-");
  CHECK(call(of.folder, {"runs", "void", "3", "--reason", "door", "--by", "K. Lee"}).code == 0);
  for (const auto& words : std::vector<std::vector<std::string>>{{"1", "3"},
                                                                 {"1", "--held-out", "3"},
                                                                 {"1", "--model", "3"},
                                                                 {"1", "--previous", "3"},
                                                                 {"1", "--studies", "3"},
                                                                 {"--compare", "1", "3"},
                                                                 {"--batch", "1", "3"}})
    of.refused(words, "[TB-RUN-VOID]");
  write_file(of.folder.path("own.csv"), "input,output\n0,0\n1,1\n2,2\n3,3\n2,2.5\n1,1.5\n0,0.1\n");
  CHECK(call(of.folder, {"runs", "import", "own.csv"}).code == 0);
  CHECK(call(of.folder, {"fit", "5", "--model", "elam"}).code == 0);
  of.refused({"1", "--model", "5:2"}, "[TB-USAGE]\n  at: --model\n");
  CHECK(call(of.folder, {"fit", "2", "--model", "elam", "--mean-taxel"}).code == 0);
  of.refused({"1", "--model", "2:3"}, "[TB-USAGE]\n  at: --model\n");
  // A run without a full loop is reported, and corrected by nothing.
  write_file(of.folder.path("up.toml"),
             "schema = 1\nname = \"up\"\nunit = \"psi\"\nturning_points = [0, 60]\nstep = 20\n");
  well(call(of.folder, {"run", "up.toml", "--bench", "simulated.toml", "--sensor", "S-1", "--operator", "t", "-q"}));
  const Finished up = of.report({"6", "--model", "1"});
  CHECK(up.code == 0);
  CHECK(up.err.empty());
  const Finished held_out = of.report({"6", "--model", "1", "--held-out", "2"});
  CHECK(held_out.out.empty());
  CHECK_THAT(held_out.err, Catch::Contains("[TB-ANALYSIS-NO-LOOP]"));
}
