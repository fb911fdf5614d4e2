// What verbs print for work and runs small enough to check line by line.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "db/run_store.h"
#include "sequences/recipe.h"
#include "tests/bench/run/stored_past.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;
using nlohmann::json;

namespace {

void check_lines(const Finished& finished, const std::vector<std::string>& lines) {
  INFO(finished.out << finished.err);
  for (const std::string& line : lines) {
    INFO(line);
    CHECK((finished.out.starts_with(line + "\n") || finished.out.find("\n" + line + "\n") != std::string::npos));
  }
}

db::RunRecord known_run() {
  db::RunRecord run;
  run.uuid = db::new_uuid();
  run.origin = "hardware";
  run.state = "prepared";
  run.sensor_serial = "S-1";
  run.scanner_serial = "SC-1";
  run.operator_name = "ann";
  run.bench_id = "b-1";
  run.bench_sha256 = std::string(64, '1');
  run.program_version = "1.2";
  run.git_commit = "abc";
  run.git_dirty = true;
  run.seed = 7;
  run.started_utc = "2026-01-02T03:04:05Z";
  run.sequences = {{0, "levels", "", std::string(64, '2'), 2, 3}, {1, "once", "", std::string(64, '3'), 1, 1}};
  run.devices = {
      {"pressure reference", "M", "", "", "hardware",
       R"({"certificate":"C-1","calibrated":"2025-01-01","due":"2025-12-31","expanded_uncertainty_psi":0.1})"},
      {"tactile scanner", "T", "SC-1", "", "hardware", "{}"}};
  return run;
}

db::FrameRecord known_frame(std::int64_t branch, int ordinal) {
  db::FrameRecord frame;
  frame.branch = branch;
  frame.ordinal = ordinal;
  frame.setpoint_psi = frame.feedback_psi = frame.reference_psi = 1.5 * ordinal;
  frame.time_ns = 1'000'000'000LL * ordinal;
  frame.rows = frame.columns = frame.scans = 2;
  frame.counts = {1, 2, 3, 4, 5, 6, 7, 8};
  return frame;
}

// A run of three frames, the second as `change` leaves it.
void store_known(db::RunStore& store, const db::RunRecord& record,
                 const std::function<void(db::FrameRecord&)>& change) {
  const std::int64_t run = store.begin_run(record);
  store.append_check(run,
                     {run, 1'500'000'000, "seating", "warning", R"({"findings":[{"text":"far"},{"text":"off"}]})", {}});
  store.append_check(run, {run, 1'750'000'000, "mount", "pass", R"({"cells":3,"turn":0.123456})", {}});
  const std::int64_t branch = store.begin_branch(run, {});
  for (int i = 0; i < 3; ++i) {
    db::FrameRecord frame = known_frame(branch, i);
    if (i == 1) change(frame);
    store.append_frame(run, frame);
  }
  store.append_event(run, {2'250'000'000, "fault", "TB-X", "it broke"});
  store.end_run(run, db::Outcome::kAborted, "TB-X: it broke", db::SafeState::kUnverified, "2026-01-02T04:00:00Z");
}

}  // namespace

TEST_CASE("plan prints a small recipe's counts, times, margins, bytes, instruments and steps") {
  const TemporaryFolder folder;
  write_file(folder.path("two.toml"),
             "schema = 1\nname = \"two\"\nunit = \"psi\"\nturning_points = [0, 10, 0]\nstep = 5\nrepeats = 2\n"
             "dwell_s = 3\n[conditioning]\ncycles = 1\npeak = 20\n");
  // 12 steps of 3 s and 0.65 s of settling (0.7 to 2 times that), 80 psi of way at 20 psi/s.
  const Finished text = call(folder, {"plan", "two.toml", "--steps"});
  check_lines(text, {"recipe               steps  frames     highest      time           10 to 90 %",
                     "two                     12      10    20.0 psi   0:00:48    0:00:45 - 0:00:56",
                     "time in h:mm:ss of process time, by the model: no completed run of this recipe on this bench in "
                     "the store",
                     "pressure      0.00 to 20.00 psi, limit 60.00 psi, margin 40.00 psi", "about 0.0 MB in the store",
                     "devices needed: pressure source, pressure reference, tactile array",
                     "  - pressure reference, serial SIM-REF-1: certificate SIM-CERT-1 (invented for the simulation), "
                     "no due date stated, U 0.05 psi (k = 2)",
                     "conditioning sequence 0 repeat 0 branch -1 step 0: 0 psi (20 to 0 psi), dwell 3 s",
                     "measure sequence 0 repeat 1 branch 1 step 4: 0 psi (10 to 0 psi), dwell 3 s"});
  CHECK(text.out.find("force up to") == std::string::npos);
  CHECK(text.out.find("\nall ") == std::string::npos);
  const json plan = json::parse(call(folder, {"plan", "two.toml", "--steps", "--json"}).out);
  CHECK(plan["steps"] == 12);
  CHECK(plan["frames"] == 10);
  CHECK(plan["process_seconds"].get<double>() == Approx(47.8));
  CHECK(plan["time"]["p10_s"].get<double>() == Approx(45.46));
  CHECK(plan["time"]["p90_s"].get<double>() == Approx(55.6));
  CHECK(plan["store_bytes"] == 10.0 * (2.0 * 16 * 16 * 2 + 220));
  CHECK(plan["lowest_psi"] == 0.0);
  CHECK(plan["highest_psi"] == 20.0);
  CHECK(plan["margin_psi"] == 40.0);
  CHECK(plan["command_limit_psi"] == 60.0);
  CHECK(plan["step_list"].size() == 12);
  CHECK(plan["step_list"][0]["frame"] == false);
  CHECK(plan["step_list"][3]["frame"] == true);
  CHECK(plan["step_list"][3]["setpoint_psi"] == 5.0);
  CHECK(plan["instruments"][0]["overdue"] == false);
  CHECK(!plan.contains("limits"));
  const Finished overdue = call(folder, {"plan", "two.toml", "--json", "--set", "reference.due=2001-01-31"});
  CHECK(json::parse(overdue.out)["instruments"][0]["overdue"] == true);
  CHECK_THAT(overdue.err, Catch::Contains("warning: pressure reference (simulated transducer, 100 psi, serial "
                                          "SIM-REF-1) is OVERDUE for calibration since 2001-01-31"));
  check_lines(call(folder, {"plan", "two.toml", "descending"}),
              {"two                     12      10    20.0 psi   0:00:48    0:00:45 - 0:00:56",
               "all                   1079    1065    60.0 psi   0:50:16    0:46:16 - 1:01:50"});
}

TEST_CASE("plan prints the number of runs behind its time estimate and the number of prompts") {
  const TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
  store.add_sensor({"S-1", "type", "", "", "", "", ""});
  const sequences::Recipe recipe = recipe_named("a");
  write_file(folder.path("a.toml"), recipe.text);
  const std::vector<std::string> words = {"plan", "a.toml", "--set", "bench.id=b"};
  store_run(store, {recipe}, {});
  check_lines(call(folder, words), {"time in h:mm:ss of process time, learned from 1 completed run"});
  store_run(store, {recipe}, {});
  check_lines(call(folder, words), {"time in h:mm:ss of process time, learned from 2 completed runs"});
  CHECK(json::parse(call(folder, {"plan", "a.toml", "--set", "bench.id=b", "--json"}).out)["time"]["runs"] == 2);
  const std::string model =
      "time in h:mm:ss of process time, by the model: no completed run of this recipe on this bench in the store; "
      "plus ";
  check_lines(call(folder, {"plan", "ring"}), {model + "1 prompt and the operator's time to answer"});
  check_lines(call(folder, {"plan", "ring", "register"}), {model + "2 prompts and the operator's time to answer"});
}

TEST_CASE("runs show and list print what was stored, field by field") {
  const TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
  store.add_sensor({"S-1", "type", "", "", "SC-1", "", ""});
  store_known(store, known_run(), [](db::FrameRecord&) {});
  store.set_tags(1, {"a", "b"}, {});
  const std::string content = store.run(1).content_sha256;
  check_lines(call(folder, {"runs", "show", "1"}),
              {"  origin        hardware",
               "  outcome       aborted: TB-X: it broke",
               "  safe state    unverified",
               "  sensor        S-1, scanner SC-1",
               "  operator      ann",
               "  purpose       not stated",
               "  bench         b-1 (sha256 111111111111)",
               "  started       2026-01-02T03:04:05Z",
               "  ended         2026-01-02T04:00:00Z",
               "  program       1.2 (abc, modified)",
               "  content       " + content,
               "  tags          a b",
               "  recipe        levels: 2 x 3 frames (sha256 222222222222)",
               "  recipe        once: 1 x 1 frame (sha256 333333333333)",
               "  device        pressure reference: M, serial not stated, hardware",
               "                certificate C-1, calibrated 2025-01-01, OVERDUE since 2025-12-31, U 0.1 psi (k = 2)",
               "  device        tactile scanner: T, serial SC-1, hardware",
               "  frames        3",
               "  check             1.500 s  seating warning: far; off",
               "  check             1.750 s  mount pass: cells 3, turn 0.1235",
               "  event             2.250 s  fault TB-X it broke"});
  const json shown = json::parse(call(folder, {"runs", "show", "1", "--json"}).out);
  CHECK(shown["frames"] == 3);
  const auto told = [](const json& event) { return event["time_s"] == 2.25 && event["id"] == "TB-X"; };
  CHECK(std::any_of(shown["events"].begin(), shown["events"].end(), told));
  CHECK(shown["checks"][0]["time_s"] == 1.5);
  CHECK(shown["checks"][1]["detail"]["cells"] == 3);
  CHECK(shown["verdict"] == "-");
  CHECK(shown["devices"][0]["overdue"] == true);
  check_lines(call(folder, {"runs", "list"}),
              {"  run  started (UTC)        sensor      outcome       frames  verdict                     origin     "
               "recipe; purpose [tags]",
               "    1  2026-01-02T03:04:05Z S-1         aborted            3  -                           hardware   "
               "levels, once [a b]"});
  check_lines(call(folder, {"runs", "list", "--tag", "c"}), {"no stored run has all that was asked for"});
  db::RunRecord many = known_run();
  many.purpose = "to see";
  for (const char* name : {"c", "d"}) many.sequences.push_back({2 + (*name == 'd'), name, "", "", 1, 0});
  store_known(store, many, [](db::FrameRecord&) {});
  CHECK_THAT(call(folder, {"runs", "list"}).out, Catch::Contains("hardware   levels, once, c and 1 more; to see"));
  db::RunStore::open(folder.path("empty.db"), db::Durability::kNormal);
  CHECK_THAT(call(folder, {"runs", "list", "--db", "empty.db"}).out,
             Catch::EndsWith("no runs are stored: tactbench run stores one\n"));
}

TEST_CASE("runs diff names the first frame that differs, and in what") {
  const TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
  store.add_sensor({"S-1", "type", "", "", "SC-1", "", ""});
  using Frame = db::FrameRecord;
  const std::vector<std::pair<std::function<void(Frame&)>, std::string>> changes = {
      {[](Frame& frame) { frame.ordinal = 5; }, "step 1 and 5"},
      {[](Frame& frame) { frame.setpoint_psi = 2.0; }, "setpoint_psi 1.5 and 2"},
      {[](Frame& frame) { frame.reference_psi = 2.5; }, "reference_psi 1.5 and 2.5"},
      {[](Frame& frame) { frame.feedback_psi = 0.5; }, "feedback_psi 1.5 and 0.5"},
      {[](Frame& frame) { frame.time_ns = 5; }, "time_ns 1000000000 and 5"},
      {[](Frame& frame) { frame.flags = "dwell"; }, "flags '' and 'dwell'"},
      {[](Frame& frame) { frame.counts.resize(4), frame.scans = 1; }, "8 and 4 counts"},
      {[](Frame& frame) { frame.counts[5] = 9; }, "scan 1, taxel 1: 6 and 9 counts"}};
  store_known(store, known_run(), [](Frame&) {});
  for (const auto& [change, said] : changes) store_known(store, known_run(), change);
  for (std::size_t i = 0; i < changes.size(); ++i) {
    const Finished differ = call(folder, {"runs", "diff", "1", std::to_string(i + 2)});
    CHECK(differ.code == 1);
    check_lines(differ, {"frames: 3 of run 1 and 3 of run " + std::to_string(i + 2) + ", 2 equal in place",
                         "first frame that differs: 2: " + changes[i].second, "content: not the same"});
  }
  db::RunRecord other = known_run();
  other.seed = 8;
  other.sequences.pop_back();
  other.devices[1].model = "U";
  store_known(store, other, [](Frame&) {});
  const Finished differ = call(folder, {"runs", "diff", "1", "10"});
  check_lines(differ,
              {"seed                                     7 | 8", "devices[1].model                         T | U",
               "frames: 3 of run 1 and 3 of run 10, 3 equal in place"});
  CHECK(differ.out.find("first frame") == std::string::npos);
  CHECK_THAT(differ.out, Catch::Contains("\nrecipes   "));
  const json told = json::parse(call(folder, {"runs", "diff", "1", "6", "--json"}).out);
  CHECK(told["frames_equal"] == 2);
  CHECK(told["first_frame"] == 2);
  CHECK(told["first_frame_difference"] == "time_ns 1000000000 and 5");
  CHECK(told["same_content"] == false);
  const Finished same = call(folder, {"runs", "diff", "1", "1"});
  CHECK(same.code == 0);
  check_lines(same, {"frames: 3 of run 1 and 3 of run 1, 3 equal in place", "content: the same, by its hash"});
}
