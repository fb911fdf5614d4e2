#include <fmt/format.h>
#include <signal.h>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <pugixml.hpp>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/cli/night/nightly.h"
#include "bench/common/error.h"
#include "bench/common/stop_request.h"
#include "bench/nightly/night.h"
#include "bench/run/recipe_check.h"
#include "db/run_store.h"
#include "sequences/toml/strict_toml.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/support/endless_run.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"
#include "tests/support/refusal.h"
#include "tests/support/text.h"
#include "tests/support/variable.h"

using namespace tactbench;
using namespace tactbench::bench;

namespace {

const char* const kNightHead = "schema = 1\nname = \"s\"\n";
const char* const kOne = "schema = 1\nname = \"s\"\n[[scenario]]\nname = \"one\"\nabout = \"first\"\n";

std::string with(const char* head, const char* rest) { return fmt::format("{}{}", head, rest); }

// "place: what"; a refusal always says what to do.
std::string refusal(const std::string& text) {
  try {
    (void)parse_suite(text, "s.toml");
  } catch (const sequences::FileError& error) {
    CHECK_FALSE(error.remedy().empty());
    return fmt::format("{}: {}", error.where(), error.what());
  }
  return "accepted";
}

// As many lines as rows, each with all parts of its row.
void check_parts(const std::vector<std::string>& lines, const std::vector<std::vector<std::string>>& rows) {
  REQUIRE(lines.size() == rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    for (const std::string& part : rows[i]) {
      INFO(lines[i] << ": " << part);
      CHECK(lines[i].find(part) != std::string::npos);
    }
  }
}

ScenarioResult came_out(const std::string& outcome = "completed", const std::string& error = "") {
  ScenarioResult result;
  result.name = "one";
  result.runs = {{1, outcome, error, "verified", "ab"}};
  result.figures = {{"frames", 211.0}};
  result.verdicts = {{"unfit_taxels", "fail"}, {"mismatch 40 psi up", "pass"}, {"mismatch 40 psi down", "fail"}};
  result.taxels = {{"dead", {3, 4}}};
  result.seconds = 1.5;
  return result;
}

}  // namespace

TEST_CASE("suite: the shipped one has at least thirty scenarios, all readable, and covers every shipped recipe") {
  const Suite suite = read_suite(tactbench::tests::source_path("sequences/nightly.toml"));
  CHECK(suite.scenarios.size() >= 30);
  std::set<std::string> carried_out;
  for (const Scenario& scenario : suite.scenarios)
    for (const std::string& name : scenario.recipes) {
      carried_out.insert(name);
      for (const sequences::Recipe& recipe : read_recipe_file(name).recipes) carried_out.insert(recipe.name);
    }
  for (const auto& file : std::filesystem::directory_iterator(tactbench::tests::source_path("sequences"))) {
    const std::string recipe = file.path().stem().string();
    if (file.path().extension() != ".toml" || recipe == "nightly") continue;
    INFO(recipe);
    CHECK(carried_out.contains(recipe));
  }
}

TEST_CASE("suite: an error in the file names the place, the key or the value") {
  struct Row {
    std::string text, part;
  };
  const std::vector<Row> rows = {
      {kNightHead, "scenario"},
      {with(kOne, "recipe = \"x\"\n"), "s.toml:6"},
      {with(kOne, "recipes = \"ring\"\n"), "recipes"},
      {with(kOne, "recipes = [\"ring\", 3]\n"), "recipes"},
      {with(kOne, "[scenario.taxels]\nbroken = [1]\n"), "broken"},
      {with(kOne, "[scenario.taxels]\ndead = [1.5]\n"), "1.5"},
      {with(kOne, "[scenario.figures]\nframes = [2, 1]\n"), "frames"},
      {with(kOne, "[scenario.figures]\nframes = 1\n"), "frames"},
      {with(kOne, "own_run = true\n[scenario.verdicts]\nmismatch = \"good\"\n"), "mismatch"},
      {with(kOne, "[scenario.verdicts]\nmismatch = \"pass\"\n"), "s.toml"},  // nothing to be judged
      {with(kOne, "own_run = true\nheld_out = []\n"), "held_out"},
      {with(kOne, "void_held_out = true\n"), "s.toml"},  // no held-out run
      {with(kOne, "fits = false\n[scenario.taxels]\ndead = [1]\n"), "fits"},
      {with(kOne, "fits = false\nown_run = true\n[scenario.verdicts]\nmismatch = \"pass\"\n"), "fits"},
      {with(kOne, "outcome = \"lost\"\n"), "outcome"},
      {with(kOne, "safe = \"lost\"\n"), "safe"},
      {with(kOne, "x = 1\n"), "x"},
      {fmt::format("x = 1\n{}", kOne), "x"},
      {with(kOne, "[[scenario]]\nname = \"one\"\nabout = \"again\"\n"), "one"},
      {with(kNightHead, "[[scenario]]\nname = \"../x\"\nabout = \"\"\n"), "../x"}};
  for (const Row& row : rows) {
    INFO(row.text);
    CHECK(refusal(row.text) != "accepted");
    CHECK_THAT(refusal(row.text), Catch::Contains(row.part));
  }
  for (const char* sound : {"own_run = true\n[scenario.verdicts]\nmismatch = \"pass\"\n",
                            "held_out = []\n[scenario.verdicts]\noverall = \"fail\"\n",
                            "fits = false\n[scenario.figures]\nframes = [1, 2]\n"})
    CHECK(refusal(with(kOne, sound)) == "accepted");
}

TEST_CASE("JUnit XML: is well-formed for any scenario text, and lists scenarios that did not run") {
  Suite suite = parse_suite(with(kOne,
                                 "[[scenario]]\nname = \"two\"\nabout = \"<&>\"\n[[scenario]]\nname = "
                                 "\"three\"\nabout = \"never reached\"\n"),
                            "s.toml");
  ScenarioResult red = came_out();
  red.name = "two";
  red.about = "<&>";
  red.wrong = {"said \"<b>\" & \x01", "more"};
  pugi::xml_document xml;
  REQUIRE(xml.load_string(junit_xml(suite, {came_out(), red}).c_str()));
  const pugi::xml_node root = xml.child("testsuite");
  CHECK(root.attribute("tests").as_int() == 3);
  CHECK(root.attribute("failures").as_int() == 1);
  CHECK(root.attribute("errors").as_int() == 1);
  const pugi::xml_node two = root.find_child_by_attribute("testcase", "name", "two");
  CHECK(std::string(two.child("failure").attribute("message").value()) == "said \"<b>\" & ?");
  CHECK(std::string(two.child("failure").text().get()).find("more") != std::string::npos);
  CHECK(root.find_child_by_attribute("testcase", "name", "three").child("error"));
  ScenarioResult moved = came_out();
  moved.remarks = {"shifted <a>"};
  REQUIRE(xml.load_string(junit_xml(suite, {moved}).c_str()));
  const pugi::xml_node one = xml.child("testsuite").find_child_by_attribute("testcase", "name", "one");
  CHECK(std::string(one.child("system-out").text().get()) == "shifted <a>");
  CHECK(one.attribute("time").as_double() == 1.5);
  const std::string metrics = metrics_text(suite, {came_out(), red});
  for (const char* line : {"# TYPE tactbench_nightly_green gauge\n", "tactbench_nightly_green{scenario=\"one\"} 1\n",
                           "tactbench_nightly_green{scenario=\"two\"} 0\n",
                           "tactbench_nightly_green{scenario=\"three\"} 0\n", "# TYPE tactbench_nightly_figure gauge\n",
                           "tactbench_nightly_figure{scenario=\"one\",figure=\"frames\"} 211\n"})
    CHECK(metrics.find(line) != std::string::npos);
}

TEST_CASE("suite: numbers have limits, names are restricted, and a scenario has these defaults") {
  CHECK(refusal(with(kOne, "seed = -1\n")) != "accepted");
  CHECK(refusal(with(kOne, "seed = 0\nsensor_seed = 0\n")) == "accepted");
  CHECK(refusal(with(kOne, "seed = 9007199254740992\nsensor_seed = 9007199254740992\n")) == "accepted");
  CHECK_THAT(refusal(with(kOne, "seed = 1e16\n")), Catch::Contains("9007199254740992"));
  CHECK_THAT(refusal(with(kOne, "sensor_seed = 1e16\n")), Catch::Contains("9007199254740992"));
  CHECK(refusal(with(kOne, "[scenario.taxels]\ndead = [0, 1000000]\n")) == "accepted");
  for (const char* dead : {"-1", "1000001"})
    CHECK(refusal(fmt::format("{}[scenario.taxels]\ndead = [{}]\n", kOne, dead)) != "accepted");
  for (const char* name : {"", "A", "a_b", "a b", "a.b"})
    CHECK(refusal(fmt::format("{}[[scenario]]\nname = \"{}\"\nabout = \"\"\n", kNightHead, name)) != "accepted");
  CHECK(refusal(with(kNightHead, "[[scenario]]\nname = \"az-09\"\nabout = \"\"\n")) == "accepted");
  CHECK(refusal("schema = 2\nname = \"s\"\n[[scenario]]\nname = \"a\"\nabout = \"\"\n") != "accepted");
  const Scenario scenario = parse_suite(kOne, "s.toml").scenarios.front();
  CHECK(scenario.recipes == std::vector<std::string>{"descending", "ascending"});
  CHECK(scenario.held_out.empty());
  CHECK((scenario.fits && !scenario.own_run && !scenario.void_held_out));
  CHECK((scenario.seed == 1 && scenario.sensor_seed == 1));
  CHECK(scenario.label == "one");
  CHECK(scenario.outcome == "completed");
  CHECK(scenario.safe == "verified");
  const Scenario two =
      parse_suite(with(kOne, "held_out = [\"a=1\"]\nheld_out_2 = []\nvoid_held_out = true\n"), "s.toml")
          .scenarios.front();
  CHECK(two.held_out == std::vector<std::vector<std::string>>{{"a=1"}, {}});
  CHECK(two.void_held_out);
}

TEST_CASE("suite: every key of a scenario is read") {
  const Suite suite = parse_suite(
      std::string(kOne) +
          "bench = \"b.toml\"\nrecipes = [\"r\", \"q\"]\nset = [\"a=1\", \"b=2\"]\nheld_out = [\"c=3\"]\nlimits = "
          "\"l.toml\"\nseed = 5\nsensor_seed = 6\noutcome = \"stopped\"\nerror = \"TB-X\"\nsafe = "
          "\"unverified\"\n[scenario.taxels]\ndead = [4, 3]\nunfit = []\n[scenario.verdicts]\noverall = "
          "\"fail\"\n[scenario.figures]\nframes = [1, 2.5]\n",
      "s.toml");
  CHECK(suite.name == "s");
  CHECK(suite.file == "s.toml");
  CHECK(suite.text.starts_with(kOne));
  const Scenario& one = suite.scenarios.at(0);
  CHECK(one.about == "first");
  CHECK(one.bench == "b.toml");
  CHECK(one.recipes == std::vector<std::string>{"r", "q"});
  CHECK(one.set == std::vector<std::string>{"a=1", "b=2"});
  CHECK(one.held_out == std::vector<std::vector<std::string>>{{"c=3"}});
  CHECK(one.limits == "l.toml");
  CHECK((one.seed == 5 && one.sensor_seed == 6));
  CHECK(one.outcome == "stopped");
  CHECK(one.error == "TB-X");
  CHECK(one.safe == "unverified");
  CHECK(one.taxels == std::map<std::string, std::vector<int>>{{"dead", {3, 4}}, {"unfit", {}}});
  CHECK(one.verdicts == std::map<std::string, std::string>{{"overall", "fail"}});
  CHECK(one.figures.at("frames") == std::pair(1.0, 2.5));
  const Suite own = parse_suite(with(kOne, "own_run = true\nfits = true\n"), "s.toml");
  CHECK(own.scenarios[0].own_run);
  CHECK(own.scenarios[0].bench == "simulated.toml");
  CHECK(own.scenarios[0].limits == "nightly-limits.toml");
}

TEST_CASE("scenario result: differences in outcome, taxels and values at their limits are reported") {
  Scenario scenario;
  scenario.error = "TB-X";
  ScenarioResult result;
  result.runs = {{1, "failed", "TB-OLD", "failed", ""}, {2, "aborted", "", "unverified", ""}};
  result.taxels = {{"dead", {7}}};
  const auto lines = [&] { return differences(scenario, result); };
  // The taxels of a run that did not complete say nothing.
  check_parts(lines(), {{"outcome", "aborted", "completed"}, {"error", "TB-X"}, {"unverified", "verified"}});
  scenario.error.clear();
  result.runs.back() = {2, "completed", "", "verified", ""};
  result.taxels = {{"dead", {7}}, {"stuck", {1, 2}}, {"saturated", {3}}, {"unfit", {4}}};
  check_parts(lines(), {{"dead", "7"}, {"stuck", "1, 2"}, {"saturated", "3"}, {"unfit", "4"}});
  scenario.taxels = {{"dead", {7}}, {"stuck", {9}}, {"saturated", {3}}, {"unfit", {4}}};
  check_parts(lines(), {{"stuck", "1, 2", "9"}});
  scenario.taxels.clear();
  scenario.fits = false;
  CHECK(lines().empty());
  scenario.figures = {{"a", {1.0, 2.0}}};
  for (const double inside : {1.0, 1.5, 2.0}) {
    result.figures = {{"a", inside}};
    CHECK(lines().empty());
  }
  for (const double outside :
       {0.5, 2.5, std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    result.figures = {{"a", outside}};
    check_parts(lines(), {{"a is", fmt::format("{:.6g}", outside), "1", "2"}});
  }
  result.figures.clear();
  check_parts(lines(), {{"a"}});  // there is none
  scenario.figures.clear();
  scenario.verdicts = {{"mismatch", "pass"}, {"mis", "pass"}};
  result.verdicts = {{"mismatch", "fail"}, {"mismatch 4 psi", "pass"}, {"mismatched", "fail"}};
  check_parts(lines(), {{"mis", "pass"}, {"mismatch", "fail", "pass"}});
}

TEST_CASE("scenario result: JSON is written and read with every member, NaN included") {
  ScenarioResult result;
  result.name = "n";
  result.about = "a";
  result.wrong = {"w", "x"};
  result.remarks = {"r"};
  result.compared = "c";
  result.runs = {{3, "completed", "TB-X", "verified", "ab"}, {4, "failed", "", "failed", "cd"}};
  result.figures = {{"f", 1.5}, {"g", std::numeric_limits<double>::quiet_NaN()}};
  result.verdicts = {{"v", "pass"}};
  result.taxels = {{"dead", {1, 2}}};
  result.seconds = 2.5;
  const std::string text = to_json(result);
  CHECK(nlohmann::json::parse(text) == nlohmann::json::parse(R"({
    "name": "n", "about": "a", "wrong": ["w", "x"], "remarks": ["r"], "compared": "c",
    "figures": {"f": 1.5, "g": null}, "verdicts": {"v": "pass"}, "taxels": {"dead": [1, 2]}, "seconds": 2.5,
    "runs": [{"run": 3, "outcome": "completed", "error": "TB-X", "safe": "verified", "content_sha256": "ab"},
             {"run": 4, "outcome": "failed", "error": "", "safe": "failed", "content_sha256": "cd"}]})"));
  const ScenarioResult back = result_from_json(text);
  CHECK(to_json(back) == text);
  CHECK(back.figures.at("g") != back.figures.at("g"));
  CHECK(back.runs[1].run == 4);
  for (const char* none : {"{}", "{", R"({"name": 3})"}) CHECK_THROWS_AS(result_from_json(none), std::invalid_argument);
}

// A night's processes: their words, how many run at a time, what becomes of those that fail or do not end, and files of
// others. By scripts in the place of the program.

using namespace tactbench::tests;
namespace fs = std::filesystem;

namespace {

using TalkLines = std::vector<std::string>;

// Scenarios do as they are called: good, bad (exit code 3), struck (by a signal), endless.
class ScriptedNight {
 public:
  explicit ScriptedNight(const std::vector<std::string>& names) {
    options.program = folder.path("program");
    options.stores = folder.path("stores/of/it");
    suite.file = "./s.toml";
    for (const std::string& name : names) {
      Scenario& scenario = suite.scenarios.emplace_back();
      scenario.name = name.substr(0, name.find('-'));
      scenario.label = name;
      scenario.about = "about " + name;
      scenario.seed = 40 + suite.scenarios.size();
    }
    ScenarioResult good;
    good.name = "of the process";
    good.about = "as measured";
    good.figures = {{"frames", 60.0}};
    good.seconds = 1.25;
    write_file(folder.path("good.json"), to_json(good));
    write_file(options.program,
               "#!/bin/sh\ncd '" + folder.path() +
                   "'\nfor last in \"$@\"; do :; done\n"
                   "printf '%s\\n' \"$TACTBENCH_RUNTIME_DIR\" \"$@\" >\"words-$6\"\necho $$ >\"process-$6\"\n"
                   "mkdir \"now-$6\"\nls -d now-* | wc -l >>counts\n"
                   "case $4 in\n  good) sleep 0.2; rmdir \"now-$6\"; echo talk; cp good.json \"$last\" ;;\n"
                   "  bad) rmdir \"now-$6\"; echo 'it says this'; echo 'and this' >&2; exit 3 ;;\n"
                   "  struck) rmdir \"now-$6\"; kill -9 $$ ;;\n"
                   "  endless) sleep 600 & echo $! >sleeper; wait ;;\nesac\n");
    fs::permissions(options.program, fs::perms::owner_all);
  }
  std::vector<ScenarioResult> carry_out() {
    return carry_out_night(suite, options, [&](const std::vector<ScenarioResult>& results) {
      std::string names;
      for (const ScenarioResult& result : results) names += result.name + " ";
      told.push_back(names);
    });
  }
  // "code id place"
  [[nodiscard]] std::string refusal() {
    const auto error = refusal_by([&] { (void)carry_out(); });
    if (!error) return "carried out";
    CHECK_FALSE(error->remedy().empty());
    return std::to_string(static_cast<int>(error->code())) + " " + error->id() + " " + error->where();
  }
  [[nodiscard]] std::string kept(const std::string& name) const { return options.stores + "/" + name; }
  // At most that many processes at a time.
  [[nodiscard]] int most_at_once() const {
    int most = 0;
    for (const std::string& line : lines_of(read_file(folder.path("counts")))) most = std::max(most, std::stoi(line));
    return most;
  }
  TemporaryFolder folder;
  Suite suite;
  NightOptions options;
  TalkLines told;
};

}  // namespace

TEST_CASE("night process: each scenario runs in its own process, results are in the order of the suite") {
  ScriptedNight night({"good-a", "bad", "struck"});
  const std::vector<ScenarioResult> results = night.carry_out();
  REQUIRE(results.size() == 3);
  CHECK(results[0].name == "good-a");
  CHECK(results[0].about == "as measured");
  CHECK(results[0].seconds == 1.25);
  CHECK(results[0].figures.at("frames") == 60.0);
  CHECK(results[0].wrong.empty());
  CHECK(results[1].name == "bad");
  CHECK(results[1].about == "about bad");
  CHECK(results[1].seconds > 0.0);
  CHECK(results[1].seconds < 60.0);
  REQUIRE((results[1].wrong.size() == 2 && results[2].wrong.size() == 2));
  CHECK_THAT(results[1].wrong[0], Catch::Contains("exit code 3"));
  CHECK(results[1].wrong[1] == "it says this\nand this\n");
  CHECK_THAT(results[2].wrong[0], Catch::Contains("signal 9"));
  REQUIRE(night.told.size() == 3);
  CHECK(night.told[2] == "good-a bad struck ");
  CHECK(night.most_at_once() <= 2);
  const TalkLines words = lines_of(read_file(night.folder.path("words-41")));
  REQUIRE(words.size() == 11);
  const std::string scope = words[0];
  CHECK_THAT(scope, Catch::Contains("tactbench-night"));
  CHECK(words == TalkLines{scope, "nightly", "./s.toml", "--only", "good", "--seed", "41", "--db",
                           night.kept("good-a.db"), "--result", scope + "/good-a.json"});
  CHECK_FALSE(fs::exists(scope));
  CHECK_THAT(read_file(night.kept("good-a.log")), Catch::StartsWith("# ") && Catch::EndsWith("\ntalk\n"));
  CHECK_THAT(read_file(night.kept("bad.log")), Catch::EndsWith("\nit says this\nand this\n"));
}

TEST_CASE("night process: runs as many scenarios in parallel as jobs, and on request stops after a failed one") {
  ScriptedNight alone({"good-a", "good-b"});
  alone.options.jobs = 1;
  CHECK(alone.carry_out().size() == 2);
  CHECK(alone.most_at_once() == 1);
  CHECK(alone.told == TalkLines{"good-a ", "good-a good-b "});
  ScriptedNight stops({"good-a", "bad", "good-b"});
  stops.options.jobs = 1;
  stops.options.stop_on_red = true;
  const std::vector<ScenarioResult> results = stops.carry_out();
  REQUIRE(results.size() == 2);
  CHECK(results[1].name == "bad");
  CHECK_FALSE(fs::exists(stops.folder.path("words-43")));
  ScriptedNight goes_on({"bad", "good-b"});
  goes_on.options.jobs = 1;
  CHECK(goes_on.carry_out().size() == 2);
  ScriptedNight none({});
  CHECK(none.carry_out().empty());
}

TEST_CASE("night process: a scenario over its time limit is killed with its children, and fails") {
  ScriptedNight night({"endless", "good-a"});
  night.options.limit_s = 1.4;
  const std::vector<ScenarioResult> results = night.carry_out();
  REQUIRE(results.size() == 2);
  REQUIRE_FALSE(results[0].wrong.empty());
  CHECK_THAT(results[0].wrong[0], Catch::Contains(" 1 s"));
  CHECK(results[0].seconds >= 1.4);
  CHECK(results[1].wrong.empty());
  CHECK(process_ends(lines_of(read_file(night.folder.path("sleeper"))).at(0)));
}

TEST_CASE("night process: a signal ends all scenarios, and the error states how many had finished") {
  const StopRequest signals;
  ScriptedNight night({"bad", "endless"});
  night.options.signals = &signals;
  night.options.jobs = 1;
  const auto ended = refusal_by([&] {
    (void)carry_out_night(night.suite, night.options, [](const std::vector<ScenarioResult>&) { std::raise(SIGTERM); });
  });
  REQUIRE(ended);
  CHECK(ended->id() == "TB-NIGHTLY-STOPPED");
  CHECK(static_cast<int>(ended->code()) == 143);
  CHECK_THAT(ended->what(), Catch::Contains("1 of 2"));
}

TEST_CASE("night process: a program that cannot be started or an unwritable file ends the night") {
  ScriptedNight night({"good-a"});
  night.options.program = night.folder.path("none");
  CHECK(night.refusal() == "70 TB-NIGHTLY-SPAWN " + night.folder.path("none"));
  ScriptedNight folder({"good-a"});
  fs::create_directories(folder.kept("good-a.log"));
  CHECK(folder.refusal() == "2 TB-FILE-WRITE " + folder.kept("good-a.log"));
}

TEST_CASE("night process: stores and logs of an earlier night are replaced, other files are not") {
  ScriptedNight night({"good-a"});
  CHECK(night.carry_out().size() == 1);
  {
    db::RunStore store = db::RunStore::open(night.kept("good-a.db"), db::Durability::kNormal);
    store.add_sensor({"SIM-0001", "t", "", db::sha256_hex(""), "", "simulated array of the nightly suite", ""});
  }
  for (const char* ending : {".db-wal", ".db-shm", ".db-lock"})
    write_file(night.kept(std::string("good-a") + ending), "");
  fs::remove(night.folder.path("counts"));
  CHECK(night.carry_out().size() == 1);
  for (const char* ending : {".db", ".db-wal", ".db-shm", ".db-lock"})
    CHECK_FALSE(fs::exists(night.kept(std::string("good-a") + ending)));
  write_file(night.kept("good-a.db"), "");  // an empty file is nobody's
  CHECK(night.carry_out().size() == 1);
  write_file(night.kept("good-a.db"), "dear diary\n");
  const std::string store = "2 TB-FILE-STORE " + night.kept("good-a.db");
  CHECK(night.refusal() == store);
  night.options.replace = true;
  CHECK(night.refusal() == store);
  fs::remove(night.kept("good-a.db"));
  night.options.replace = false;
  write_file(night.kept("good-a.log"), "dear diary\n");
  CHECK_THAT(night.refusal(), Catch::StartsWith("2 TB-FILE-EXISTS "));
  night.options.replace = true;
  CHECK(night.carry_out().size() == 1);
}

// A night's results: its exit code, its JSON document and each printed line.

namespace {

Suite suite_of(std::size_t scenarios) {
  Suite suite;
  suite.name = "small";
  suite.scenarios.resize(scenarios);
  return suite;
}

ScenarioResult result_with(const std::vector<std::string>& wrong, const std::vector<std::string>& remarks) {
  ScenarioResult result;
  result.name = "short";
  result.about = "a fit";
  result.seconds = 12.34;
  result.wrong = wrong;
  result.remarks = remarks;
  return result;
}

}  // namespace

TEST_CASE("night results: exit code is 1 for a failed or missing scenario, 6 for changes only, and 1 outranks 6") {
  const ScenarioResult green = result_with({}, {}), moved = result_with({}, {"a"}), red = result_with({"b"}, {}),
                       both = result_with({"b"}, {"a"});
  CHECK(code_of_night(suite_of(2), {green, green}) == ExitCode::kPass);
  CHECK(code_of_night(suite_of(2), {green, moved}) == ExitCode::kInconclusive);
  CHECK(code_of_night(suite_of(2), {red, moved}) == ExitCode::kCriterionFailed);
  CHECK(code_of_night(suite_of(1), {both}) == ExitCode::kCriterionFailed);
  CHECK(code_of_night(suite_of(3), {green, green}) == ExitCode::kCriterionFailed);
  CHECK(code_of_night(suite_of(0), {}) == ExitCode::kPass);
}

TEST_CASE("night results: the JSON document counts the failed scenarios and those that did not run") {
  const nlohmann::ordered_json json =
      night_json(suite_of(4), {result_with({"b"}, {}), result_with({}, {"a"}), result_with({"c"}, {})});
  tests::check_members(json, R"({"suite": "small", "origin": "simulated", "red": 2, "not_run": 1})");
  REQUIRE(json.at("scenarios").size() == 3);
  CHECK(json.at("scenarios").at(0).at("wrong") == nlohmann::json({"b"}));
  CHECK(json.at("scenarios").at(1).at("remarks") == nlohmann::json({"a"}));
  CHECK(json.at("scenarios").at(1).at("seconds") == 12.34);
}

TEST_CASE("night results: only requested files are written, a file of another kind is overwritten on request only") {
  const tests::TemporaryFolder folder;
  Session session;
  const Suite suite = suite_of(1);
  write_night_lists({}, suite, {}, session);
  write_night_page({}, suite, {}, session);
  NightFiles files;
  files.junit = folder.path("night.xml");
  write_night_lists(files, suite, {result_with({}, {})}, session);
  CHECK_THAT(tests::read_file(files.junit), Catch::Contains("tests=\"1\" failures=\"0\""));
  CHECK_FALSE(std::filesystem::exists(folder.path("night.prom")));
  files = {};
  files.metrics = folder.path("night.prom");
  files.html = folder.path("night.html");
  write_night_lists(files, suite, {}, session);
  CHECK_THAT(tests::read_file(files.metrics), Catch::Contains("tactbench"));
  CHECK_FALSE(std::filesystem::exists(files.html));
  write_night_page(files, suite, {}, session);
  CHECK_THAT(tests::read_file(files.html), Catch::Contains("<html"));
  for (std::string NightFiles::*file : {&NightFiles::junit, &NightFiles::metrics, &NightFiles::html}) {
    NightFiles own;
    own.*file = folder.path("diary");
    const auto write = [&] {
      write_night_lists(own, suite, {}, session);
      write_night_page(own, suite, {}, session);
    };
    tests::write_file(own.*file, "dear diary\n");
    session.replace = false;
    CHECK_THROWS_AS(write(), Error);
    session.replace = true;
    CHECK_NOTHROW(write());
    CHECK(tests::read_file(own.*file) != "dear diary\n");
  }
}
