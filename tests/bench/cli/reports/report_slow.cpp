// The report verb as a person uses it: formats, signatures, comparison, batch; figures recomputed from the store.
#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "analysis/report/gather.h"
#include "db/run_store.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/support/in_terminal.h"
#include "tests/support/paths.h"
#include "tests/support/run_recipe.h"
#include "tests/support/text.h"

using namespace tactbench;
using namespace tactbench::tests;
using nlohmann::json;

namespace {

// One folder for all: two sensors, the first measured twice, models of each run.
const TemporaryFolder& reported() {
  static const TemporaryFolder folder;
  static const bool made = [&] {
    begin_bench(folder, small_loop_text(10, 2));
    well(call(folder, {"sensors", "add", "S-2", "--type", "sensor.toml"}));
    for (const auto& [sensor, seed] : {std::pair("S-1", "1"), {"S-1", "1"}, {"S-2", "2"}})
      well(call(folder, {"run", "small.toml", "--bench", "bench.toml", "--sensor", sensor, "--operator",
                         "</script><img onerror=x>", "-q", "--sensor-seed", seed, "--seed", seed}));
    for (const char* run : {"1", "2", "3"}) well(call(folder, {"fit", run}));
    return true;
  }();
  (void)made;
  return folder;
}

json data_of_run(const TemporaryFolder& folder, const std::vector<std::string>& words) {
  well(call(folder, joined({"report", "--format", "json", "-o", "report.json", "--replace"}, words)));
  return json::parse(read_file(folder.path("report.json")));
}

}  // namespace

TEST_CASE("report: health and raw behaviour values equal those recomputed from the stored counts") {
  const TemporaryFolder& folder = reported();
  const json data = data_of_run(folder, {"1"});
  CHECK(data["schema"] == "tactbench.report");
  const json &health = data["sections"]["health"], &raw = data["sections"]["raw"];
  const db::RunStore store = db::RunStore::open_read_only(folder.path("runs.db"));
  double volts_per_count = 0.0;
  for (const db::DeviceRecord& device : store.run(1).devices)
    if (device.role == "tactile scanner")
      volts_per_count = json::parse(device.calibration_json)["volts_per_count"].get<double>();
  REQUIRE(volts_per_count > 0.0);
  // Mean of the scans of each frame, by repeat and step.
  std::map<std::int64_t, db::BranchRecord> branches;
  for (const db::BranchRecord& branch : store.branches(1)) branches.emplace(branch.branch, branch);
  std::map<int, std::map<int, std::vector<double>>> volts;
  std::vector<double> low(256, 1e9), high(256, -1e9), squares(256, 0.0);
  int degrees = 0, scans_a_frame = 0;
  for (const db::FrameRecord& frame : store.frames(1)) {
    REQUIRE(frame.columns * frame.rows == 256);
    std::vector<double> mean(256, 0.0);
    for (std::size_t i = 0; i < frame.counts.size(); ++i)
      mean[i % 256] += volts_per_count * frame.counts[i] / frame.scans;
    for (std::size_t i = 0; i < frame.counts.size(); ++i)
      squares[i % 256] += std::pow(volts_per_count * frame.counts[i] - mean[i % 256], 2);
    degrees += frame.scans - 1;
    scans_a_frame = frame.scans;
    for (std::size_t t = 0; t < 256; ++t) {
      low[t] = std::min(low[t], mean[t]);
      high[t] = std::max(high[t], mean[t]);
    }
    volts[branches.at(frame.branch).repeat][frame.ordinal] = mean;
  }
  REQUIRE(volts.size() == 2);
  double zero = 0.0;
  for (const auto& [repeat, steps] : volts)
    for (std::size_t t = 0; t < 256; ++t) zero += (steps.rbegin()->second[t] - steps.at(0)[t]) / 512.0;
  CHECK(raw["zero_return"][0]["mean_v"].get<double>() == Approx(zero).margin(1e-12));
  for (const std::size_t t : {std::size_t{0}, std::size_t{100}, std::size_t{255}}) {
    CHECK(health["low_v"][t].get<double>() == Approx(low[t]));
    CHECK(health["high_v"][t].get<double>() == Approx(high[t]));
    CHECK(health["noise_v"][t].get<double>() == Approx(std::sqrt(squares[t] / degrees / scans_a_frame)));
  }
  // The trace of the mean taxel, step by step.
  const json& trace = raw["traces"][0]["output_v"];
  REQUIRE(trace.size() == volts[0].size());
  for (std::size_t i = 0; i < trace.size(); ++i) {
    double mean = 0.0;
    for (const auto& [repeat, steps] : volts)
      for (const double v : steps.at(static_cast<int>(i))) mean += v / 512.0;
    CHECK(trace[i].get<double>() == Approx(mean));
  }
  // What is moved to set-points follows from the dataset (run_values.cpp checks how).
  std::vector<int> all(256);
  for (int t = 0; t < 256; ++t) all[static_cast<std::size_t>(t)] = t;
  const analysis::Behaviour own = analysis::behaviour_of(analysis::load_dataset(store, 1), all);
  CHECK(raw["loops"][0]["hysteresis_max_fs"] == own.loops[0].hysteresis_max);
  CHECK(raw["loops"][3]["taxel"] == own.loops[3].taxel);
  CHECK(raw["gain"][17].get<double>() == Approx(own.gain[17]).epsilon(1e-6));
  CHECK(raw["repeatability"][3]["taxel_down_v"] == own.repeatability[3].taxel_down_v);
  const json& evaluation = data["results"]["evaluation"];
  CHECK(raw["loops"][0]["hysteresis_max_fs"].get<double>() ==
        Approx(evaluation["hysteresis_max_fs"].get<double>()).epsilon(1e-9));
  REQUIRE(call(folder, {"report", "1", "-o", "one.html"}).code == 0);
  const std::string page = read_file(folder.path("one.html"));
  CHECK_THAT(page, Catch::Contains("&lt;/script&gt;&lt;img onerror=x&gt;") && !Catch::Contains("<img"));
}

// What else becomes of signed reports: report_slow.cpp.
TEST_CASE("report: the same run gives the same bytes, and signing keeps the report number") {
  const TemporaryFolder& folder = reported();
  for (const char* name : {"a.html", "b.html"}) REQUIRE(call(folder, {"report", "2", "-o", name}).code == 0);
  CHECK(read_file(folder.path("a.html")) == read_file(folder.path("b.html")));
  const json first = json::parse(call(folder, {"report", "2", "--json"}).out);
  const std::vector<std::string> sign = {"report", "sign", "2", "--json", "--without-verdict", "--by", "C. Chief"};
  CHECK(json::parse(call(folder, sign).out)["number"] == first["number"]);
}

TEST_CASE("report: is written into a pipe, a full device is an error") {
  const TemporaryFolder& folder = reported();
  const auto piped = [&](const std::string& words) {
    return run_program("/bin/sh", {"-c", "timeout 60 '" + program_path() + "' " + words}, folder.path());
  };
  const Finished whole = piped("report 1 -q --format json -o /dev/stdout | cat");
  CHECK(whole.code == 0);
  CHECK(whole.out.find("\"schema\":\"tactbench.report\"") != std::string::npos);
  REQUIRE(mkfifo(folder.path("pipe").c_str(), 0600) == 0);
  const Finished fifo = run_program(
      "/bin/sh",
      {"-c", "timeout 60 '" + program_path() + "' report 1 -q --format json -o pipe & timeout 60 cat pipe; wait $!"},
      folder.path());
  CHECK(fifo.code == whole.code);
  CHECK(fifo.out.find("\"schema\":\"tactbench.report\"") != std::string::npos);
  CHECK(piped("report 1 -q -o /dev/full").code == 2);
}

TEST_CASE("report: a batch has the values of the newest run of each sensor") {
  const TemporaryFolder& folder = reported();
  const json batch = data_of_run(folder, {"--batch", "1", "2", "3"});
  CHECK(batch["runs"] == json::array({2, 3}));  // one per sensor, the newest
  CHECK(batch["content"][0]["figures"]["mean_error_psi"] ==
        data_of_run(folder, {"2"})["results"]["evaluation"]["mean_error_psi"]);
}

TEST_CASE("report: a PDF is made by an installed program and has no foreign date, without a program it is an error") {
  const TemporaryFolder& folder = reported();
  const auto with_path = [&](const std::string& path, const std::string& name) {
    return run_program("/usr/bin/env", {"PATH=" + path, program_path(), "report", "1", "--format", "pdf", "-o", name},
                       folder.path());
  };
  check_refusal(with_path("/nowhere", "none.pdf"), 2, "TB-REPORT-PDF");
  write_file(
      folder.path("printed"),
      "%PDF-1.4\n1 0 obj <</Type/Catalog/Pages 2 0 R>> endobj\n2 0 obj <</Type/Pages/Kids[]/Count 0>> endobj\n"
      "3 0 obj <</CreationDate (D:20990909090909+00)>> endobj\ntrailer <</Size 4/Root 1 0 R/Info 3 0 R>>\n%%EOF\n");
  write_file(folder.path("chromium"),
             "#!/bin/sh\nfor word; do case $word in --print-to-pdf=*) out=${word#--print-to-pdf=};; esac; done\n"
             "cp '" +
                 folder.path("printed") + "' \"$out\"\n");
  REQUIRE(::chmod(folder.path("chromium").c_str(), 0700) == 0);
  well(with_path(folder.path() + ":/usr/bin:/bin", "made.pdf"));
  CHECK_THAT(read_file(folder.path("made.pdf")), Catch::StartsWith("%PDF") && !Catch::Contains("D:2099") &&
                                                     Catch::Contains("(D:20") && Catch::Contains("(report.json)"));
}

// report: its JSON and files for runs with models and without, of several runs, in each format, and signed; and
// what it refuses of models and further runs. The runs are small, so that each call takes no longer than its process.

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
  Told printed(std::vector<std::string> words) const {
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

TEST_CASE("report: states verdicts, judgement and file of a judged run, also with models of another run") {
  const RunsToReport of;
  CHECK(of.report({"1"}).code == 6);
  const std::string number = of.printed({"1"}).at("number");
  CHECK(number.starts_with("1-"));
  CHECK(of.report({"3", "--paper", "letter", "--units", "bar"}).code == 0);
  // The judgement of one run, and its models by another run's.
  const Told one = of.printed({"1"});
  CHECK(one.at("schema") == "tactbench.report");
  CHECK(one.at("run") == 1);
  CHECK(one.at("runs") == Told::array({1}));
  CHECK(one.at("number") == number);
  check_members(one, R"({"path": "reports/run-1.html", "written": true, "origin": "simulated"})");
  CHECK(one.at("verdicts").size() == 10);
  CHECK(one.at("judgement").at("overall") == "inconclusive");
  CHECK_FALSE(one.contains("judgements"));
  const Told by_other = of.printed({"2", "--model", "1"});
  CHECK(by_other.at("verdicts").size() == 10);
  CHECK(by_other.at("verdicts").at(0).at("run") == 2);
  CHECK(by_other.at("verdicts").at(0).at("model_run") == 1);
  CHECK(of.printed({"2", "--model", "1:1"}).at("number") == by_other.at("number"));
  const Told held_out = of.printed({"1", "--held-out", "3", "--limits", "limits.toml"});
  CHECK(held_out.at("judgement").at("runs").size() == 1);
  CHECK(held_out.at("judgement").at("runs").at(0).at("run") == 3);
  const Told both = of.printed({"2", "--model", "1", "--held-out", "3", "--limits", "limits.toml"});
  CHECK(both.at("judgement").at("runs").size() == 2);
}

TEST_CASE("report: a comparison of two runs and a batch each state one judgement per run") {
  const RunsToReport of;
  CHECK(of.report({"--compare", "1", "2"}).code == 6);
  const std::string number = of.printed({"--compare", "1", "2"}).at("number");
  CHECK(number.starts_with("1-2-"));
  CHECK(of.report({"--compare", "1", "4"}).code == 6);  // of another sensor
  const Told printed = of.printed({"--compare", "1", "2"});
  CHECK(printed.at("runs") == Told::array({1, 2}));
  CHECK(printed.at("judgements").size() == 2);
  CHECK(printed.at("judgements").at(0).at("overall") == "inconclusive");
  CHECK_FALSE(printed.contains("judgement"));
  const Told other_way = of.printed({"--compare", "2", "1"});
  CHECK(other_way.at("path") == "reports/compare-2-1.html");
  const Told batch = of.printed({"--batch", "1", "3", "4"});
  CHECK(batch.at("judgements").size() == 2);  // a row for each sensor
  CHECK(batch.at("path") == "reports/batch-" + batch.at("number").get<std::string>() + ".html");
  CHECK(of.report({"--batch", "3", "4"}).code == 0);
  CHECK(of.printed({"--compare", "1", "2", "--format", "json", "-o", "c.json"}).at("path") == "c.json");
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

TEST_CASE("report: a signed report keeps its number and file, and a later one states which report it replaces") {
  const RunsToReport of;
  of.refused({"sign", "3", "--by", "K. Lee"}, "[TB-REPORT-NO-VERDICT]");  // nobody is asked: no terminal
  // A file of somebody else ends it before anything is signed.
  of.refused({"sign", "3", "--by", "K. Lee", "--without-verdict", "-o", "small.toml"}, "small.toml");
  CHECK(Told::parse(call(of.folder, {"report", "list", "--json"}).out).at("reports").empty());
  REQUIRE(of.report({"sign", "3", "--by", "K. Lee", "--without-verdict"}).code == 0);
  const std::string number = of.printed({"3"}).at("number"), path = "reports/run-" + number + ".html";
  CHECK_FALSE(of.exists("reports/run-3.html"));
  const std::string page = read_file(of.folder.path(path));
  CHECK(call(of.folder, {"report", "verify", number}).code == 0);
  const Finished again = of.report({"3"});
  CHECK(of.printed({"3"}).at("written") == false);
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

TEST_CASE("report: if a run has no verdict, signing asks the operator at the terminal") {
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

TEST_CASE("report: rejects unusable models and further runs") {
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

// demo: what its five runs are made with, and a file of another kind that it leaves alone.

namespace {

struct DemoRunStored {
  std::int64_t seed = 0;
  std::vector<std::string> recipes;
  std::string settings;  // as key=value, with blanks between
  int frames = 0;
};

const std::vector<DemoRunStored>& runs_of_seed_three() {
  static const std::vector<std::string> table = {"descending", "ascending"};
  static const std::vector<DemoRunStored> runs = {
      {3, table, "", 3310},
      {4, table, "recipe.repeats=1 ", 662},
      {7, {"random-reversal"}, "", 463},
      {5, table, "recipe.repeats=1 simulation.mount_seed=1 simulation.effects.remount_variation=0.03 ", 662},
      {6, table,
       "recipe.repeats=1 simulation.temperature_c=28 simulation.age_months=1 "
       "simulation.effects.gain_drift_per_month=0.01 simulation.effects.zero_drift_v_per_month=0.01 ",
       662},
      {8,
       {"reversals", "held-presses", "small-reversals", "reversals", "held-presses", "small-reversals", "reversals",
        "held-presses", "small-reversals", "reversals", "held-presses"},
       "recipe.dwell_s=2 ",
       571}};
  return runs;
}

}  // namespace

TEST_CASE("demo: stores six runs with their seeds, recipes, settings and number of frames") {
  const TemporaryFolder folder;
  write_file(folder.path("mine.txt"), "a letter\n");
  const Finished refused = call(folder, {"demo", "-o", "mine.txt"});
  CHECK(refused.code == 2);
  CHECK(refused.out.empty());
  CHECK_FALSE(std::filesystem::exists(folder.path("runs.db")));
  well(call(folder,
            {"demo", "-q", "--timing", "--model", "elam", "--seed", "3", "--sensor-seed", "2", "-o", "demo.html"}));
  const std::vector<DemoRunStored>& runs = runs_of_seed_three();
  const db::RunStore store = db::RunStore::open_read_only(folder.path("runs.db"));
  for (std::size_t i = 0; i < runs.size(); ++i) {
    INFO(i);
    const db::RunRecord run = store.run(static_cast<std::int64_t>(i + 1));
    CHECK(run.seed == runs[i].seed);
    CHECK(run.sensor_seed == 2);
    CHECK(run.operator_name == "demo");
    CHECK(store.frame_count(run.run) == runs[i].frames);
    CHECK(run.sensor_serial == "SIM-0002");
    std::vector<std::string> recipes;
    for (const db::SequenceRecord& sequence : run.sequences) recipes.push_back(sequence.name);
    CHECK(recipes == runs[i].recipes);
    std::string settings;
    for (const auto& one : nlohmann::json::parse(run.overrides_json))
      settings += one.at("key").get<std::string>() + "=" + one.at("value").get<std::string>() + " ";
    CHECK(settings == runs[i].settings);
  }
  const auto sensor = store.sensor("SIM-0002");
  REQUIRE(sensor);
  CHECK(store.verdicts(5).size() == 10);
  CHECK(store.subjects() == std::vector<std::string>{"sensor/SIM-0002/descending+ascending"});
  // What its report prints is recomputed from its data by a script that knows none of the program.
  (void)call(folder, {"report", "1", "-o", "page.html"});
  (void)call(folder, {"report", "1", "--format", "json", "-o", "page.json"});
  const Finished recomputed = run_program(
      "/usr/bin/python3",
      {source_path("tests/analysis/pages/recompute.py"), folder.path("page.html"), folder.path("page.json")},
      folder.path());
  INFO(recomputed.out << recomputed.err);
  CHECK(recomputed.code == 0);
}
