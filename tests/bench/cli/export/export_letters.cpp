// runs export as CSV by the letter: signs and digits of times, numbers that are none, typed texts, remarks of a run.
#include <catch2/catch.hpp>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "db/sqlite.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/db/store_example.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

struct StoreToExport {
  Finished exported(const std::string& run, const std::string& format = "csv") const {
    return verb_here(bench::add_runs,
                     {"runs", "export", run, "--db", path, "--format", format, "-o", folder.path("out"), "--replace"});
  }
  [[nodiscard]] std::string text() const { return read_file(folder.path("out")); }
  TemporaryFolder folder;
  std::string path = folder.path("runs.db");
  db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
};

db::FrameRecord plain_frame(std::int64_t branch) {
  db::FrameRecord frame;
  frame.branch = branch;
  frame.rows = frame.columns = frame.scans = 1;
  frame.counts = {7};
  return frame;
}

}  // namespace

TEST_CASE("export CSV: times in seconds with all their digits, and nothing for a number that is none") {
  StoreToExport store;
  db::RunRecord run = example_run();
  run.devices.clear();  // volts of a count are not known
  const Begun begun = begin_example(store.store, run);
  const std::vector<std::int64_t> times = {0, 1, 1'000'000'000, 71'850'000'000, -1'500'000'000, -1};
  for (std::size_t i = 0; i < times.size(); ++i) {
    db::FrameRecord frame = plain_frame(begun.branch);
    frame.ordinal = static_cast<int>(i);
    frame.time_ns = times[i];
    frame.reference_psi = std::numeric_limits<double>::quiet_NaN();
    frame.feedback_psi = 1.0 / 3.0;
    store.store.append_frame(begun.run, frame);
  }
  store.store.end_run(begun.run, db::Outcome::kCompleted, "", db::SafeState::kVerified, kUtc);
  CHECK(store.exported("1").code == 0);
  const std::string table = store.text();
  std::string rows;
  for (const auto& [position, seconds] : std::vector<std::pair<int, std::string>>{
           {1, "0"}, {2, "0.000000001"}, {3, "1"}, {4, "71.85"}, {5, "-1.5"}, {6, "-0.000000001"}})
    rows += std::to_string(position) + ",1,down,0,0,0,0," + std::to_string(position - 1) +
            ",0,0.3333333333333333,,,,,,,,,,,," + seconds + ",0,0,0,0,,0,7\n";
  CHECK(table.substr(table.find("counts_r0_c0\n") + 13) == rows);
}

TEST_CASE("export CSV: the lines before the table, of a run with remarks, and fields that hold commas and quotes") {
  StoreToExport store;
  db::RunRecord run = example_run();
  run.operator_name = "A\nB";
  run.bench_id = "";
  run.sequences[1].name = "a,b";
  const Begun begun = begin_example(store.store, run);
  for (const char* flags : {"x\"y", "x,y", "plain"}) {
    db::FrameRecord frame = plain_frame(begun.branch);
    frame.flags = flags;
    frame.ordinal = flags[1] == '"' ? 0 : flags[1] == ',' ? 1 : 2;
    store.store.append_frame(begun.run, frame);
  }
  store.store.end_run(begun.run, db::Outcome::kAborted, "", db::SafeState::kVerified, kUtc);
  store.store.set_tags(1, {"lot=A7", "film=B12", "night"}, {});
  store.store.void_run(1, "door, open", "K. Lee", kUtc);
  REQUIRE(store.exported("1").code == 0);
  const std::string table = store.text();
  const db::RunRecord stored = store.store.run(1);
  CHECK_THAT(table, Catch::Contains("\n1,1,\"a,b\",0,") && Catch::Contains(",\"x\"\"y\",0,7,0.7\n") &&
                        Catch::Contains(",\"x,y\",0,7,0.7\n") && Catch::Contains(",plain,0,7,0.7\n"));
}

TEST_CASE("export: a frame of a branch that the run lacks is damage, and said so") {
  StoreToExport store;
  const Begun begun = begin_example(store.store);
  store.store.append_frame(begun.run, plain_frame(begun.branch));
  store.store.end_run(begun.run, db::Outcome::kCompleted, "", db::SafeState::kVerified, kUtc);
  db::sqlite::Connection raw(store.path, db::sqlite::Access::kReadWrite);
  raw.execute("PRAGMA foreign_keys = OFF; DELETE FROM branches WHERE branch = (SELECT max(branch) FROM branches)");
  for (const char* format : {"csv", "json"}) {
    INFO(format);
    check_refusal(store.exported("1", format), 5, "TB-STORE-SQL", "runs export");
  }
}

TEST_CASE("export JSON: every list of a run, item by item") {
  StoreToExport store;
  (void)store_example(store.store);
  db::VerdictRecord verdict{1, 0, "unfit_taxels", "array", 1.0, 1.5, "taxels", "simple", "pass", "limits", "sha"};
  store.store.replace_verdicts(1, 0, {verdict});
  CHECK(store.exported("1", "json").code == 0);
  const auto document = nlohmann::json::parse(store.text());
  CHECK(document.at("schema") == "tactbench.run");
  CHECK(document.at("bench_toml") == "id = \"bench-a\"\n");
  CHECK(document.at("sensor_toml") == "rows = 3\n");
  CHECK(document.at("recipes").at(1).at("toml") == "recipe b");
  CHECK(document.at("devices").at(0).at("calibration") == nlohmann::json{{"span", 1}});
  CHECK(document.at("events") == nlohmann::json::parse(R"([
    {"time_ns": 5, "kind": "state", "id": "", "detail": "prepared -> running"},
    {"time_ns": 6, "kind": "fault", "id": "TB-SCANNER-SILENT", "detail": "no report"}])"));
  CHECK(document.at("checks") ==
        nlohmann::json::parse(R"([{"time_ns": 4, "kind": "seating", "verdict": "pass", "detail": {"rows": 3}}])"));
  CHECK(document.at("series") ==
        nlohmann::json::parse(R"([{"sequence": 0, "taxel": 3, "input": [0.5, 1.5], "output": [2.5, 3.5]}])"));
  REQUIRE(document.at("verdicts").size() == 1);
  CHECK(document.at("verdicts").at(0).at("shown") == "simulated pass");
  REQUIRE(document.at("frames").size() == 3);
  const nlohmann::json& frame = document.at("frames").at(2);
  const db::FrameRecord known = example_frame(0, 1);
  CHECK((frame.at("sequence") == 1 && frame.at("attempt") == 1 && frame.at("void") == false && frame.at("step") == 1));
  CHECK(document.at("frames").at(0).at("void") == true);
  CHECK((frame.at("setpoint_psi") == known.setpoint_psi && frame.at("feedback_psi") == known.feedback_psi &&
         frame.at("reference_psi") == known.reference_psi));
  CHECK((frame.at("setpoint_counts") == 101 && frame.at("feedback_counts") == -201 &&
         frame.at("reference_counts") == 301));
  CHECK((frame.at("time_ns") == known.time_ns && frame.at("since_command_ns") == known.since_command_ns &&
         frame.at("in_band_ns") == known.in_band_ns && frame.at("device_time_us") == known.device_time_us));
  CHECK((frame.at("status") == 4 && frame.at("flags") == "dwell" && frame.at("rows") == 3 && frame.at("columns") == 2 &&
         frame.at("scans") == 2));
  CHECK(frame.at("counts") == nlohmann::json(known.counts));
  CHECK(frame.at("target_n") == 6.1);
  CHECK(frame.at("wrench_n_nmm") == nlohmann::json({0.1, 0.2, -6.2, 1.5, 2.5, 3.5}));
  CHECK(frame.at("wrench_raw") == nlohmann::json({11.0, 12.0, 13.0, 14.0, 15.0, 16.5}));
  CHECK(frame.at("place_mm") == nlohmann::json({20.1, 30.2, 41.3}));
  // A series comes first as a table.
  REQUIRE(store.exported("1").code == 0);
  CHECK(store.text() == "sequence,name,taxel,position,input,output\n0,up,3,0,0.5,2.5\n0,up,3,1,1.5,3.5\n");
  const auto json = nlohmann::json::parse(
      verb_here(bench::add_runs, {"runs", "export", "1", "--db", store.path, "-o", store.folder.path("new"), "--json"})
          .out);
  CHECK(json.at("format") == "csv");
  CHECK(json.at("bytes") == store.text().size());
}

TEST_CASE("runs copy: a run more into a store that is there") {
  StoreToExport store;
  for (int i = 0; i < 3; ++i) (void)store_example(store.store);
  db::FitRecord fit;
  fit.run = 1;
  fit.model = "elam";
  db::VerdictRecord verdict;
  verdict.verdict = "pass";
  verdict.limits_sha256 = "l";
  const std::int64_t own = store.store.add_fit(fit);
  for (const std::int64_t judged : {2, 3}) store.store.replace_verdicts(judged, own, {verdict});
  const std::string to = store.folder.path("to.db");
  CHECK(verb_here(bench::add_runs, {"runs", "copy", "2", "1", "2", "--db", store.path, "--to", to}).code == 0);
  const auto told = nlohmann::json::parse(
      verb_here(bench::add_runs, {"runs", "copy", "3", "--db", store.path, "--to", to, "--json"}).out);
  CHECK(told.at("runs") == nlohmann::json::parse(R"([{"run": 3, "copy": 3}])"));
  CHECK(told.at("verdicts_left_behind").empty());
  CHECK_THAT(verb_here(bench::add_runs, {"runs", "copy", "x", "--db", store.path, "--to", to}).err,
             Catch::Contains("[TB-USAGE]") && Catch::Contains("\n  at: command line\n"));
}
