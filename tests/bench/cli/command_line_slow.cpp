// Refusals of the command line before a verb begins.

#include <sqlite3.h>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdint>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "bench/cli/session.h"
#include "db/schema.h"
#include "db/sqlite.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"
#include "tests/support/run_recipe.h"
#include "tests/support/text.h"

using namespace tactbench;
using namespace tactbench::tests;
using nlohmann::json;
using tactbench::db::sqlite::Access;
using tactbench::db::sqlite::Connection;

namespace {

std::vector<std::string> parts_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> parts;
  for (std::string part; stream >> part;) parts.push_back(part);
  return parts;
}

}  // namespace

TEST_CASE("command line: rejects numbers out of range") {
  const TemporaryFolder folder;
  // Those of fit and live: fit.cpp.
  for (const char* line : {"live --bench simulated.toml --interval 1e9", "live --bench simulated.toml --frames -1",
                           "devices calibrate-reference --bench simulated.toml --gauge g --uncertainty 1e9",
                           "simulate --rate 1e9", "simulate --for -1", "nightly nightly --jobs 1000000",
                           "nightly nightly --seeds 1000000", "nightly nightly --limit 0"}) {
    INFO(line);
    check_refusal(call(folder, parts_of(line)), 2, "TB-USAGE");
  }
}

TEST_CASE("command line: rejects unknown verbs and options, with the rig state if a verb may have touched the rig") {
  const TemporaryFolder folder;
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{"rn"},
                                             {"zzzzzzzz"},
                                             {"runs"},
                                             {"runs", "lst"},
                                             {"runs", "--all"},
                                             {"runs", "list", "--sensr=x", "-5"},
                                             {"runs", "list", "-z"},
                                             {"runs", "list", "-5"},
                                             {"runs", "list", "x"},
                                             {"runs", "show", "x"},
                                             {"-5"}}) {
    const Finished finished = call(folder, words);
    CAPTURE(words);
    check_refusal(finished, 2, "TB-USAGE", "command line");
    CHECK(finished.out.empty());
  }
  CHECK(call(folder, {}).code == 0);  // greets
  CHECK(nlohmann::json::parse(well(call(folder, {"rn", "--json"}), 2).out).at("id") == "TB-USAGE");
  for (const char* const judging : {"--limits", "--held-out", "--lab"})
    CHECK_THAT(call(folder, {"fit", "1", judging, "2"}).err, Catch::Contains("tactbench judge "));
  CHECK_THAT(call(folder, {"fit", "1", "--model", "elam,poly"}).err, Catch::Contains("tactbench compare 1"));
  // The state of the rig is told where a verb may have touched it.
  for (const char* verb :
       {"run", "calibrate", "resume", "devices", "live", "pause", "stop", "panic", "simulate", "dead-man", "demo"})
    CHECK_THAT(call(folder, {verb, "--zzzzzz"}).err, Catch::Contains("\n  state: "));
  for (const char* verb : {"plan", "fit", "runs", "status", "nightly", "init", "selfcheck"})
    CHECK_THAT(call(folder, {verb, "--zzzzzz"}).err, !Catch::Contains("\n  state: "));
}

// The program as a person uses it: words, exit codes, files.

namespace {

std::vector<std::string> small_run(const std::vector<std::string>& more = {}) {
  return joined({"run", "small.toml", "--bench", "bench.toml", "--sensor", "S-1", "--operator", "tester", "-q"}, more);
}

// The lines of an error, its exit code and identifier. `devices`: of a verb that could have touched some.
void check_error(const Finished& finished, int code, const std::string& id, bool devices = false) {
  check_refusal(finished, code, id);
  CHECK_THAT(finished.err, Catch::Contains("error: "));
  CHECK((finished.err.find("\n  state: ") != std::string::npos) == devices);
  CHECK(finished.err.find('\x1b') == std::string::npos);
}

}  // namespace

TEST_CASE("end to end: init, run, fit, judge and report work as separate commands") {
  const TemporaryFolder folder;
  begin_bench(folder, small_loop_text(10, 2));
  CHECK_THAT(well(call(folder, small_run())).out, Catch::Contains("vented, verified"));
  const json second = json::parse(well(call(folder, small_run({"--seed", "2", "--json"}))).out);
  check_members(second, R"({"schema": "tactbench.run", "run": 2, "branches_redone": 0})");
  CHECK((second["process_seconds"] > 42.0 && second["most_exchanges_a_step"] > 0));  // 42 frames, a second's dwell each
  CHECK_FALSE(second["time_spent"].get<std::string>().empty());
  const json fitted = json::parse(well(call(folder, {"fit", "1"}, {"judge", "1", "2", "--json"})).out);
  CHECK(fitted["schema"] == "tactbench.judge");
  CHECK(fitted["fitted_taxels"] == 256);
  CHECK(fitted["evaluations"].size() == 2);
  CHECK(fitted["origin"] == "simulated");
  REQUIRE(call(folder, {"report", "1", "--held-out", "2"}).code == 0);
  CHECK_THAT(read_file(folder.path("reports/run-1.html")), Catch::Contains("SIMULATED"));
  CHECK(json::parse(call(folder, {"runs", "list", "--json"}).out)["runs"].size() == 2);
  CHECK(json::parse(call(folder, {"runs", "show", "1", "--json"}).out)["safe_state"] == "verified");
  CHECK(json::parse(call(folder, {"sensors", "show", "S-1", "--json"}).out)["runs"] == json::array({1, 2}));
}

TEST_CASE("plan: descending and ascending have 3310 frames, descending with one repeat has 211") {
  const TemporaryFolder folder;
  const Finished plan = call(folder, {"plan", "descending", "ascending", "--json"});
  REQUIRE(plan.code == 0);
  CHECK(json::parse(plan.out)["frames"] == 3310);
  CHECK(json::parse(call(folder, {"plan", "descending", "--set", "recipe.repeats=1", "--json"}).out)["frames"] == 211);
  check_error(call(folder, {"plan", "descending", "--set", "limits.command_psi=59"}), 2, "TB-RECIPE-LIMIT");
}

TEST_CASE("command line: usage and configuration errors end with exit code 2 and change nothing") {
  const TemporaryFolder folder;
  begin_bench(folder);
  check_error(call(folder, {"reprot", "1"}), 2, "TB-USAGE");
  check_error(call(folder, {"run", "small.toml"}), 2, "TB-USAGE", true);
  check_error(call(folder, small_run({"--set", "limits.comand_psi=50"})), 2, "TB-FILE-KEY", true);
  check_error(call(folder, small_run({"--set", "nonsense"})), 2, "TB-USAGE", true);
  check_error(call(folder, small_run({"--set", "limits.command_psi=\"60 mbar\""})), 2, "TB-FILE-VALUE", true);
  std::vector<std::string> by_nobody = small_run();
  *std::find(by_nobody.begin(), by_nobody.end(), "tester") = " ";
  check_error(call(folder, by_nobody), 2, "TB-USAGE", true);
  check_error(call(folder, {"devices", "reset", "--bench", "bench.toml", "--operator", ""}), 2, "TB-USAGE", true);
  check_error(call(folder, {"plan", "no-such-recipe"}), 2, "TB-FILE-MISSING");
  write_file(folder.path("wrong.toml"), small_loop_text() + "dwel_s = 1\n");
  const Finished wrong = call(folder, {"plan", "wrong.toml"});
  check_error(wrong, 2, "TB-FILE-KEY");
  CHECK_THAT(wrong.err, Catch::Contains("wrong.toml:8:1"));
  check_error(call(folder, {"run", "small.toml", "--bench", "bench.toml", "--sensor", "S-9", "--operator", "t"}), 2,
              "TB-SENSOR-UNKNOWN", true);
  check_error(call(folder, {"fit", "7"}), 2, "TB-STORE-NOT-FOUND");
  check_error(call(folder, {"init"}), 2, "TB-FILE-EXISTS");
  CHECK(json::parse(call(folder, {"fit", "7", "--json"}).out)["exit_code"] == 2);
  CHECK(json::parse(call(folder, {"runs", "list", "--json"}).out)["runs"].empty());
}

TEST_CASE("run: device faults end with exit code 3, an unproved safe state with 7, and the frames remain stored") {
  const TemporaryFolder folder;
  begin_bench(folder, small_loop_text(10, 2));
  const Finished scanner = call(folder, small_run({"--set", "simulation.wire_faults.scanner_silent_after_scans=12",
                                                   "--set", "scanner.frame_timeout_ms=100"}));
  check_error(scanner, 3, "TB-SCANNER-TIMEOUT", true);
  CHECK_THAT(scanner.err, Catch::Contains("vented, verified"));
  const Finished module = call(folder, small_run({"--set", "simulation.wire_faults.module_dead_after_requests=100",
                                                  "--set", "module.response_timeout_ms=100"}));
  CHECK(module.code == 7);
  CHECK_THAT(module.err, Catch::Contains("NOT verified"));
  const json runs = json::parse(call(folder, {"runs", "list", "--json"}).out)["runs"];
  REQUIRE(runs.size() == 2);
  CHECK(runs[0]["outcome"] == "failed");
  CHECK(runs[0]["frames"] == 4);
  CHECK(runs[1]["safe_state"] == "unverified");
  check_error(call(folder, {"fit", "1"}), 6, "TB-ANALYSIS-EMPTY");
}

TEST_CASE("store: another schema, a foreign file and a missing store are rejected with exit code 5") {
  const TemporaryFolder folder;
  begin_bench(folder);
  db::sqlite::Connection(folder.path("runs.db"), db::sqlite::Access::kReadWrite).execute("PRAGMA user_version = 9999");
  check_error(call(folder, small_run()), 5, "TB-STORE-OTHER-SCHEMA", true);
  check_error(call(folder, {"runs", "list"}), 5, "TB-STORE-OTHER-SCHEMA");
  write_file(folder.path("text.db"), std::string(5000, 'x'));
  check_error(call(folder, {"runs", "list", "--db", "text.db"}), 5, "TB-STORE-OPEN");
  check_error(call(folder, {"runs", "list", "--db", "none.db"}), 5, "TB-STORE-OPEN");
}

TEST_CASE("demo: measures the sequences of the paper, and its models are scored on held-out runs") {
  const TemporaryFolder folder;
  CHECK(call(folder, {"demo", "--specimen", "harch"}).code == 2);
  const json result = json::parse(well(call(folder, {"demo", "--json", "-q"})).out);
  REQUIRE(result["evaluations"].size() == 6);
  const json& own = result["evaluations"][0];
  const json& held_out = result["evaluations"][1];
  const json& reversals = result["evaluations"][2];
  CHECK(own["frames"] == 3310);
  CHECK(held_out["frames"] == 662);
  CHECK(reversals["frames"] == 463);
  CHECK(result["specimen"] == "paper");
  CHECK(json::parse(call(folder, {"runs", "show", "1", "--json"}).out)["specimen"] == "paper");
  // A trajectory that was not fitted costs more than the same one again, and a simpler model errs more.
  CHECK(reversals["mean_error_psi"] > 1.1 * held_out["mean_error_psi"].get<double>());
  const json& errors = result["mean_error_psi"];
  CHECK(errors["dynamic"] == reversals["mean_error_psi"]);
  CHECK(errors["dynamic"] < errors["elam"]);
  CHECK(errors["elam"] < errors["monotone"]);
  CHECK(result["runs"] == json::array({1, 2, 3, 4, 5, 6}));
  CHECK(result["origin"] == "simulated");
  CHECK(result["report"] == "reports/run-1.html");
  CHECK(result["verdicts"].size() == 50);
  CHECK(result["timing_s"].size() == 10);
  CHECK(own["hysteresis_max_fs"].get<double>() == Approx(0.253).margin(0.015));
  CHECK(own["hysteresis_mean_fs"].get<double>() == Approx(0.100).margin(0.012));
  CHECK(own["full_scale_v"].get<double>() == Approx(3.5).margin(0.05));
  CHECK(held_out["raw_distance_fs"].get<double>() == Approx(0.10).margin(0.012));
  CHECK(held_out["comp_distance_of_mean_fs"].get<double>() < 0.015);
  CHECK(held_out["comp_distance_of_mean_fs"].get<double>() > 0.0);
  // On the sensor as measured, and re-mounted, all means pass; a month later and warmer it is out of its
  // limits. Of single readings one long way, or one mount, says too little.
  for (const json& verdict : result["verdicts"]) {
    if (verdict["run"] != 5 && verdict["criterion"] != "mpe") CHECK(verdict["shown"] == "simulated pass");
    if ((verdict["run"] == 3 || verdict["run"] == 4) && verdict["criterion"] == "mpe")
      CHECK(verdict["verdict"] == "inconclusive");
  }
  CHECK(result["judgement"]["runs"].size() == 5);
  CHECK(result["judgement"]["overall"] == "fail");
  CHECK(result["judgement"]["decided_by"] == json::array({5}));
  CHECK_FALSE(result["on_purpose"].get<std::string>().empty());
  CHECK(result["model"] == "dynamic");
}

// Escape sequences in arguments, files and stores: none reaches a terminal, whichever verb prints it.

namespace {

// Colour, window title, bell, return, backspace, delete, the C1 form of ESC [, a change of direction.
const std::string kEvil = "x\x1b[31m\x1b]0;t\x07\r\b\x7f\u009b2J\u202ey";

bool harmless(const std::string& text) {
  const bool plain = std::all_of(text.begin(), text.end(), [](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return (byte >= 0x20 && byte != 0x7F) || c == '\n' || c == '\t';
  });
  return plain && text.find("\u009b") == std::string::npos && text.find("\u202e") == std::string::npos &&
         text.find('\xff') == std::string::npos;
}

class Terminal {
 public:
  Finished run(const std::vector<std::string>& words) {
    Finished finished = run_program(program_path(), words, folder.path());
    std::string line;
    for (const std::string& word : words) line += word + " ";
    INFO(line << "\n" << finished.out << finished.err);
    CHECK(harmless(finished.out));
    CHECK(harmless(finished.err));
    return finished;
  }
  const TemporaryFolder folder;
};

}  // namespace

TEST_CASE(
    "terminal output: escape sequences in arguments and stored text are printed escaped, not sent to the terminal") {
  Terminal terminal;
  REQUIRE(terminal.run({"init"}).code == 0);
  write_file(terminal.folder.path("small.toml"),
             "schema = 1\nname = \"n\\u001b[2Jm\"\ntitle = \"t\\u009b\\u202e\"\nunit = \"psi\"\n"
             "turning_points = [0, 60, 20, 60, 0]\nstep = 20\nrepeats = 1\ndwell_s = 1.0\n");
  const std::string& evil = kEvil;
  CHECK(terminal.run({"sensors", "add", evil + "\xff", "--type", "sensor.toml"}).code == 2);  // a stray byte: no text
  CHECK(terminal.run({"sensors", "add", evil, "--type", "sensor.toml", "--note", evil}).code == 0);
  CHECK(terminal.run({"plan", "small.toml"}).code == 0);
  const std::vector<std::string> set = {"--set", "bench.location=\"a\\u001b[31m\"", "--set",
                                        "reference.serial=\"r\\u001b]0;t\\u0007\""};
  REQUIRE(terminal
              .run(joined({"run", "small.toml", "--bench", "bench.toml", "--sensor", evil, "--operator", evil,
                           "--purpose", evil},
                          set))
              .code == 0);
  CHECK_THAT(terminal.run(joined({"devices", "check", "--bench", "bench.toml"}, set)).out,
             Catch::Contains("r\\x1b]0;t\\x07"));
  CHECK_THAT(terminal.run(joined({"config", "--origin", "--bench", "bench.toml"}, set)).out,
             Catch::Contains("a\\x1b[31m"));
  CHECK(terminal.run({"runs", "note", "1", evil}).code == 0);
  CHECK(terminal.run({"runs", "void", "1", "--reason", evil, "--by", evil}).code == 0);
  Connection(terminal.folder.path("runs.db"), Access::kReadWrite)
      .execute("UPDATE events SET detail = 'd' || char(27) || '[31m' || char(13), id = char(7)");
  const std::string list = terminal.run({"runs", "list", "--all"}).out;
  CHECK_THAT(list, Catch::Contains("x\\x1b[31m"));
  CHECK(std::count(list.begin(), list.end(), '\n') == 3);  // head, run, origin
  CHECK_THAT(terminal.run({"runs", "show", "1"}).out, Catch::Contains("\\x0d"));
  for (const char* verb : {"list", "show"}) {
    std::vector<std::string> sensors = {"sensors", verb};
    if (std::string(verb) == "show") sensors.push_back(evil);
    CHECK_THAT(terminal.run(sensors).out, Catch::Contains("x\\x1b[31m"));
    sensors.push_back("--json");
    CHECK_NOTHROW(nlohmann::json::parse(terminal.run(sensors).out));  // what stands for escapes there is JSON
  }
  CHECK_NOTHROW(nlohmann::json::parse(terminal.run({"runs", "show", "1", "--json"}).out));
  (void)terminal.run({"verify", "1"});
  (void)terminal.run({"fit", "1"});
  (void)terminal.run({"trend"});
}

TEST_CASE("terminal output: escape sequences in rejected input are printed escaped in the error") {
  Terminal terminal;
  const std::string& evil = kEvil;
  CHECK(terminal.run({"plan", evil}).code == 2);
  CHECK(terminal.run({evil}).code == 2);
  CHECK(terminal.run({"plan", "production", "--set", "recipe." + evil + "=1"}).code == 2);
  CHECK(terminal.run({"plan", "production", "--set", "bench." + evil + "=" + evil}).code == 2);
  CHECK(terminal.run({"run", "--" + evil}).code == 2);
  write_file(terminal.folder.path("bad.toml"), "schema = 1\n\"k\\u001b[31m\" = \"v\\u001b]0;t\\u0007\"\n");
  CHECK(terminal.run({"plan", "bad.toml"}).code == 2);
  CHECK(terminal.run({"nightly", "bad.toml", "--list"}).code == 2);
  write_file(terminal.folder.path("columns.csv"), evil + "," + evil + "b\n1,2\n");
  CHECK_THAT(well(terminal.run({"fit", "columns.csv"}), 2).err, Catch::Contains("\\x08"));  // behind its line end CR
  write_file(terminal.folder.path("wide.csv"), std::string(900'000, '\x1b') + ",b\n1,2\n");
  CHECK(terminal.run({"fit", "wide.csv"}).err.size() < 5000);
  write_file(terminal.folder.path("cell.csv"), "input,output\n1," + evil + "\n");
  CHECK(terminal.run({"fit", "cell.csv"}).code == 2);
  write_file(terminal.folder.path("suite.toml"),
             "schema = 1\nname = \"s\\u001b[31m\"\n[[scenario]]\nname = \"one\"\nabout = \"a\\u001b[31m\\u000d\"\n");
  CHECK_THAT(terminal.run({"nightly", "suite.toml", "--list"}).out, Catch::Contains("a\\x1b[31m\\x0d"));
}

// A command reads each run once, however many figures of it are asked for. SQLite itself is asked: it names every
// statement that it carries out for a verb, which runs in this process.

namespace {

// How the store asks for the frames of a run, up to the first bound value; and what such a statement has besides.
constexpr std::string_view kFramesFrom = "FROM frames WHERE frame > ", kWithCounts = ", counts,";

// The run of each statement that reads frames, on all connections opened while this lives; they must be closed before
// it goes.
class ReadLog {
 public:
  ReadLog() {
    current_ = this;
    REQUIRE(sqlite3_auto_extension(entry()) == SQLITE_OK);
  }
  ~ReadLog() {
    (void)sqlite3_cancel_auto_extension(entry());
    current_ = nullptr;
  }
  ReadLog(const ReadLog&) = delete;
  ReadLog& operator=(const ReadLog&) = delete;
  [[nodiscard]] std::vector<std::int64_t> sorted() const {
    std::vector<std::int64_t> runs = runs_;
    std::ranges::sort(runs);
    return runs;
  }

 private:
  using Entry = void (*)();
  static Entry entry() { return reinterpret_cast<Entry>(&attach); }
  static int attach(sqlite3* connection, char** /*error*/, const sqlite3_api_routines* /*api*/) {
    return sqlite3_trace_v2(connection, SQLITE_TRACE_STMT, &see, current_);
  }
  static int see(unsigned /*event*/, void* log, void* statement, void* /*sql*/) {
    static_cast<ReadLog*>(log)->note(static_cast<sqlite3_stmt*>(statement));
    return 0;
  }
  void note(sqlite3_stmt* statement) {
    const std::string_view sql = sqlite3_sql(statement);
    const std::size_t from = sql.find(kFramesFrom);
    if (from == std::string_view::npos || sql.find(kWithCounts) == std::string_view::npos) return;
    char* const bound = sqlite3_expanded_sql(statement);
    runs_.push_back(std::stoll(std::string(bound).substr(from + kFramesFrom.size())) / db::kFramesPerRun);
    sqlite3_free(bound);
  }
  static inline ReadLog* current_ = nullptr;
  std::vector<std::int64_t> runs_;
};

using RunsRead = std::vector<std::int64_t>;

// The runs whose frames the verb reads, in their order, each as often as it does.
RunsRead frames_read_by(const TemporaryFolder& folder, std::vector<std::string> words) {
  words.insert(words.begin(), "tactbench");
  words.insert(words.end(), {"--db", folder.path("runs.db")});
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  ReadLog log;
  const int code = bench::run_command_line(static_cast<int>(arguments.size()), arguments.data());
  CAPTURE(words, code);
  REQUIRE((code == 0 || code == 1 || code == 6));  // by the verdicts
  return log.sorted();
}

}  // namespace

TEST_CASE("frame reading: a verb reads the frames of each run only once") {
  const TemporaryFolder folder;
  init_small_array(folder);
  REQUIRE(call(folder, {"sensors", "add", "S-1", "--type", "sensor.toml"}).code == 0);
  write_file(
      folder.path("loops.toml"),
      "schema = 1\nname = \"loops\"\nunit = \"psi\"\nturning_points = [0, 60, 20, 60, 0]\nstep = 4\nrepeats = 2\n"
      "dwell_s = 1.0\n[conditioning]\ncycles = 1\npeak = 60\n");
  run_recipe(folder, "loops.toml", {"--seed", "1"});
  run_recipe(folder, "loops.toml", {"--seed", "2"});
  run_recipe(folder, "loops.toml", {"--seed", "3", "--set", "simulation.mount_seed=1"});
  run_recipe(folder, "ring", {"--set", "recipe.repeats=1"});
  run_recipe(folder, "rate-ramp", {});
  REQUIRE(call(folder, {"fit", "2"}).code == 0);
  const std::string page = folder.path("r.html"), limits = folder.path("limits.toml");

  // Fitted, evaluated, judged with U, and the report of that.
  CHECK(frames_read_by(folder, {"fit", "1"}) == RunsRead{1});
  CHECK(frames_read_by(folder, {"judge", "1", "2", "--limits", limits}) == RunsRead{1, 2});
  CHECK(frames_read_by(folder, {"report", "1", "--held-out", "2", "-o", page}) == RunsRead{1, 2});
  CHECK(frames_read_by(folder, {"report", "1", "--held-out", "2", "3", "-o", page}) == RunsRead{1, 2, 3});
  // The held-out run is the one that the fit was judged on; then by other limits, for which nothing is stored.
  CHECK(frames_read_by(folder, {"report", "1", "-o", page}) == RunsRead{1, 2});
  write_file(limits, read_file(limits) + "# another file\n");
  CHECK(frames_read_by(folder, {"report", "1", "--limits", limits, "-o", page}) == RunsRead{1, 2});

  // All results of further runs: creep and temperature, a mount, an object, paces; and earlier models.
  CHECK(frames_read_by(folder, {"report", "1", "2", "--held-out", "2", "--previous", "2", "--studies", "3:mount", "4",
                                "5", "-o", page}) == RunsRead{1, 2, 3, 4, 5});
  CHECK(frames_read_by(folder, {"report", "--compare", "1", "2", "-o", folder.path("c.html")}) == RunsRead{1, 2});
  CHECK(frames_read_by(folder, {"model", "show", "1"}).empty());
  CHECK(frames_read_by(folder, {"model", "check", "2", "1"}) == RunsRead{1});
  // Once for the hash of what is stored, once for what follows from it.
  CHECK(frames_read_by(folder, {"verify", "2"}) == RunsRead{1, 1, 2, 2});
}

// One vocabulary: what a verb says of a run, its figures and verdicts, an export and a report say in the same words.

namespace {

// Two runs of one sensor.
void measure_twice(const TemporaryFolder& folder) {
  begin_bench(folder);
  for (const char* seed : {"1", "2"}) measure_small(folder, seed);
}

json answer_of(const TemporaryFolder& folder, std::vector<std::string> words) {
  words.emplace_back("--json");
  return json::parse(well(call(folder, words)).out);
}

json document_of(const TemporaryFolder& folder, std::vector<std::string> words) {
  words.insert(words.end(), {"--format", "json", "-o", "document.json", "--replace"});
  well(call(folder, words));
  return json::parse(read_file(folder.path("document.json")));
}

// Each member of `part` is one of `whole`, with the same value; figures may differ in their last digit.
void check_within(const json& part, const json& whole, const std::string& at = {}) {
  for (const auto& [key, value] : part.items()) {
    const std::string place = at + "/" + key;
    INFO(place);
    const json::json_pointer own("/" + key);
    REQUIRE(whole.contains(own));
    if (value.is_structured()) {
      CHECK(value.size() <= whole.at(own).size());
      check_within(value, whole.at(own), place);
    } else if (value.is_number_float()) {
      CHECK(whole.at(own).get<double>() == Approx(value.get<double>()).epsilon(1e-12));
    } else {
      CHECK(whole.at(own) == value);
    }
  }
}

json without(json document, const std::vector<std::string>& keys) {
  for (const std::string& key : keys) document.erase(key);
  return document;
}

}  // namespace

TEST_CASE("JSON vocabulary: show, list, export, run, tag and report use the same keys and values for a run") {
  const TemporaryFolder folder;
  measure_twice(folder);
  json tagged = answer_of(folder, {"runs", "tag", "1", "night"});
  for (const char* own : {"schema", "version"}) tagged.erase(own);
  CHECK(tagged.size() == 36);
  CHECK(tagged["sensor"] == "S-1");
  CHECK(tagged["tags"] == json::array({"night"}));
  CHECK(tagged["recipes"][0]["sha256"].get<std::string>().size() == 64);
  CHECK(tagged["sensor_type_sha256"].get<std::string>().size() == 64);
  check_within(tagged, answer_of(folder, {"runs", "show", "1"}));
  check_within(tagged, answer_of(folder, {"runs", "list"})["runs"][0]);
  const json exported = document_of(folder, {"runs", "export", "1"});
  CHECK(exported["schema"] == "tactbench.run");
  CHECK(exported["version"] == 2);
  check_within(tagged, exported);

  REQUIRE(call(folder, {"fit", "1"}).code == 0);
  const json report = document_of(folder, {"report", "1"});
  CHECK(report["version"] == 3);
  const json& reported = report["identification"]["run"];
  check_within(without(tagged, {"tags", "notes"}), reported);
  CHECK_FALSE(reported.contains("tags"));
  CHECK(reported["devices"][0]["calibration"] == exported["devices"][0]["calibration"]);
  check_within(report["identification"]["sensor"], answer_of(folder, {"sensors", "show", "S-1"}));

  // An earlier report is still valid, and so is its signature.
  write_file(folder.path("old.json"),
             R"({"schema":"tactbench.report","version":1,"document":"Test report","number":"1-0123abcd",)"
             R"("identification":{"run":{"sensor_serial":"S-1"},"approvals":[{"number":"1-0123abcd"}]}})");
  const Finished refused = call(folder, {"report", "1", "--format", "json", "-o", "old.json"});
  CHECK(refused.code == 2);
  CHECK_THAT(refused.err, Catch::Contains("[TB-REPORT-SIGNED]") && Catch::Contains("1-0123abcd"));
}

TEST_CASE("JSON vocabulary: fit and report use the same keys and values for evaluations and verdicts") {
  const TemporaryFolder folder;
  measure_twice(folder);
  well(call(folder, {"fit", "1"}));
  const json fitted = answer_of(folder, {"judge", "1", "2", "--limits", "wide.toml"});
  const json results = document_of(folder, {"report", "1"})["results"];
  const std::vector<std::string> numbers = {"title", "run", "model_run", "shown"};
  REQUIRE(fitted["evaluations"].size() == 2);
  CHECK(fitted["evaluations"][1]["run"] == 2);
  CHECK(fitted["evaluations"][1]["model_run"] == 1);
  check_within(without(fitted["evaluations"][0], numbers), results["evaluation"]);
  check_within(without(fitted["evaluations"][1], numbers), results["held_out"][0]["evaluation"]);
  REQUIRE(fitted["verdicts"].size() == 4);
  REQUIRE(results["verdicts"].size() == 4);
  for (std::size_t i = 0; i < 4; ++i) {
    check_within(without(fitted["verdicts"][i], numbers), results["verdicts"][i]);
    CHECK(fitted["verdicts"][i]["shown"] == "simulated pass");
  }
  CHECK(results["judgement"]["overall"] == fitted["judgement"]["overall"]);
  const json shown = answer_of(folder, {"runs", "show", "2"});
  check_within(fitted["verdicts"], shown["verdicts"]);
}
