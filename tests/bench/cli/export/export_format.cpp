// runs export by the letter: signs and digits of times, numbers that are none, typed texts; and what it does to a file
// that is there.
#include <catch2/catch.hpp>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "db/sqlite.h"
#include "tests/bench/cli/verb_here.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

struct StoreToExport : OpenStoreHere {
  Finished exported(const std::string& run, const std::string& format = "csv") const {
    return say(bench::add_runs, {"runs", "export", run, "--format", format, "-o", folder.path("out"), "--replace"});
  }
  [[nodiscard]] std::string text() const { return read_file(folder.path("out")); }
};

db::FrameRecord plain_frame(std::int64_t branch) {
  db::FrameRecord frame;
  frame.branch = branch;
  frame.rows = frame.columns = frame.scans = 1;
  frame.counts = {7};
  return frame;
}

// Run 1 has frames and no series, run 2 a series, run 3 neither, run 4 one frame.
struct StoreOfKinds : OpenStoreHere {
  StoreOfKinds() {
    for (int kind = 1; kind <= 4; ++kind) {
      const Begun begun = begin_example(store);
      for (int i = 0; i < (kind == 1 ? 2 : kind == 4 ? 1 : 0); ++i)
        store.append_frame(begun.run, example_frame(begun.branch, i));
      if (kind == 2) store.append_series(begun.run, {{0, 3, {0.5}, {2.5}}});
      store.end_run(begun.run, db::Outcome::kCompleted, "", db::SafeState::kVerified, kUtc);
    }
  }
  Finished exported(const std::string& run, const std::string& format, const std::string& file) const {
    return say(bench::add_runs, {"runs", "export", run, "--format", format, "-o", folder.path(file)});
  }
};

struct KindOfExport {
  std::string run, format;
};

}  // namespace

TEST_CASE("export CSV: times are in seconds with all digits, NaN is an empty cell") {
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

TEST_CASE("export CSV: fields with commas or quotes are quoted, also in a void run with tags") {
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

TEST_CASE("export CSV: a name that a spreadsheet would run as a formula is exported as text") {
  StoreToExport store;
  db::RunRecord run = example_run();
  run.sequences[1].name = "=cmd|'/C calc'!A0";
  const Begun begun = begin_example(store.store, run);
  store.store.append_frame(begun.run, plain_frame(begun.branch));
  store.store.end_run(begun.run, db::Outcome::kCompleted, "", db::SafeState::kVerified, kUtc);
  REQUIRE(store.exported("1").code == 0);
  CHECK_THAT(store.text(), Catch::Contains("\n1,1,'=cmd|"));
}

TEST_CASE("export: a frame without its branch is reported as a damaged store") {
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

TEST_CASE("export JSON: contains configuration, recipes, devices, events, checks, series, verdicts, frames of a run") {
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
  const auto json =
      store.printed<nlohmann::json>(bench::add_runs, {"runs", "export", "1", "-o", store.folder.path("new")});
  CHECK(json.at("format") == "csv");
  CHECK(json.at("bytes") == store.text().size());
}

TEST_CASE("runs copy: adds a run to an existing store") {
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
  CHECK(store.say(bench::add_runs, {"runs", "copy", "2", "1", "2", "--to", to}).code == 0);
  const auto printed = store.printed<nlohmann::json>(bench::add_runs, {"runs", "copy", "3", "--to", to});
  CHECK(printed.at("runs") == nlohmann::json::parse(R"([{"run": 3, "copy": 3}])"));
  CHECK(printed.at("verdicts_left_behind").empty());
  check_refusal(store.say(bench::add_runs, {"runs", "copy", "x", "--to", to}), 2, "TB-USAGE", "command line");
}

TEST_CASE("export: overwrites a file of the same kind, leaves a file of another kind unchanged") {
  const StoreOfKinds of;
  const std::map<std::string, KindOfExport> kinds = {
      {"frames", {"1", "csv"}}, {"series", {"2", "csv"}}, {"json", {"1", "json"}}};
  for (const auto& [there, first] : kinds)
    for (const auto& [then, second] : kinds) {
      INFO(then << " over " << there);
      const std::string file = there + "-" + then;
      REQUIRE(of.exported(first.run, first.format, file).code == 0);
      const std::string before = read_file(of.folder.path(file));
      const Finished again = of.exported(second.run, second.format, file);
      CHECK(again.code == (there == then ? 0 : 2));
      if (there == then) continue;
      CHECK_THAT(again.err, Catch::Contains("--replace"));
      CHECK(read_file(of.folder.path(file)) == before);
    }
}

TEST_CASE("export CSV: the column names appear once, also for one frame or no frame") {
  const StoreOfKinds of;
  const auto table = [&](const std::string& run) {
    REQUIRE(of.exported(run, "csv", "run-" + run).code == 0);
    const std::string text = read_file(of.folder.path("run-" + run));
    return text.substr(text.find("\nframe,") + 1);
  };
  CHECK_THAT(table("3"), Catch::StartsWith("frame,sequence,recipe,") && Catch::EndsWith(",flags,scan\n"));
  CHECK(table("3").find('\n') == table("3").size() - 1);
  for (const std::string run : {"1", "4"}) {
    const std::string text = table(run);
    CHECK(text.find("frame,sequence,recipe,", 1) == std::string::npos);
    CHECK_THAT(text, Catch::Contains(",flags,scan,counts_r0_c0,counts_r0_c1,counts_r1_c0,") &&
                         Catch::Contains("\n1,1,down,0,0,0,0,0,0,0.1,"));
  }
}

TEST_CASE("export CSV: a frame under force has one row per scan, with wrench, position and the volts of each count") {
  const StoreOfKinds of;
  REQUIRE(of.exported("4", "csv", "one").code == 0);
  const std::string text = read_file(of.folder.path("one")),
                    frame =
                        "1,1,down,0,0,0,0,0,0,0.1,0.3333333333333333,6.1,0.1,0.2,-6.2,1.5,2.5,3.5,20.1,30.2,40.3,2000,"
                        "2.000000001,1.500000002,5000000000003,4,dwell,";
  CHECK(text.substr(text.find("volts_r2_c1\n") + 12) ==
        frame + "0,65535,65278,65021,64764,64507,64250,6553.5,6527.8,6502.1,6476.4,6450.7,6425\n" + frame +
            "1,63993,63736,63479,63222,62965,62708,6399.3,6373.6,6347.9,6322.2,6296.5,6270.8\n");
}
