// The array's newest picture: of the last frame, of the seating check before it, and which taxels are dead.

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <string>
#include <utility>
#include <vector>

#include "bench/common/terminal.h"
#include "bench/monitor/heat_map.h"
#include "bench/monitor/run_view.h"
#include "tests/bench/monitor/status_example.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"
#include "tests/support/variable.h"

using namespace tactbench::bench;
using namespace tactbench::tests;
using namespace tactbench;

namespace {

// An array of 3 x 2, 0.1 V a count: one taxel answers the seating check by 0.04 V.
struct Example {
  Example() : store(db::RunStore::open(folder.path("runs.db"))), begun(begin_example(store)) {}
  void check_seating() {
    store.append_check(begun.run, {begun.run,
                                   1,
                                   "seating",
                                   "pass",
                                   R"({"pressure_psi":8.01,"rows":3,"columns":2,"volts_per_count":0.1})",
                                   {1, 2, 3, 4, 5, 6, 11, 12, 13, 14, 15.6, 6.4}});
  }
  void take_frame(double reference_psi, std::vector<std::uint16_t> counts) {
    db::FrameRecord frame = example_frame(begun.branch, 0);
    frame.wrench.reset();
    frame.reference_psi = reference_psi;
    frame.counts = std::move(counts);
    store.append_frame(begun.run, frame);
  }
  [[nodiscard]] std::optional<ArrayView> view() const { return newest_array(store, store.run(begun.run)); }
  TemporaryFolder folder;
  db::RunStore store;
  Begun begun;
};

}  // namespace

TEST_CASE("array view: is empty before the first frame, then shows the seating check, then the last frame") {
  Example example;
  CHECK_FALSE(example.view());
  example.check_seating();
  const auto seating = example.view();
  REQUIRE(seating);
  CHECK(seating->title == "seating check at 8.0 psi");
  CHECK((seating->rows == 3 && seating->columns == 2));
  CHECK(seating->volts.at(4) == Approx(1.56));
  CHECK(seating->full_scale_v == Approx(6553.5));
  CHECK(seating->dead_are_known);
  CHECK(seating->dead == std::vector<int>{5});
  example.take_frame(8.0, {10, 20, 30, 40, 50, 6, 12, 22, 32, 42, 52, 6});
  const auto frame = example.view();
  REQUIRE(frame);
  CHECK(frame->title == "frame 1 at 8.0 psi");
  CHECK(frame->volts.at(0) == Approx(1.1));  // the mean of both scans
  CHECK(frame->dead == std::vector<int>{5});
}

TEST_CASE("array view: dead taxels are unknown at low pressure, without a seating check, and under an indenter") {
  Example example;
  const std::vector<std::uint16_t> counts = {10, 20, 30, 40, 50, 6, 12, 22, 32, 42, 52, 6};
  example.take_frame(8.0, counts);
  CHECK_FALSE(example.view()->dead_are_known);
  example.check_seating();
  example.take_frame(4.9, counts);
  CHECK_FALSE(example.view()->dead_are_known);
  CHECK(example.view()->dead.empty());
  example.store.append_frame(example.begun.run, example_frame(example.begun.branch, 0));
  CHECK(example.view()->title == "frame 3 at 6.20 N");
  CHECK_FALSE(example.view()->dead_are_known);
}

TEST_CASE("array view: is empty for a scanner without a scale") {
  const TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"));
  db::RunRecord run = example_run();
  run.devices.pop_back();
  const Begun begun = begin_example(store, run);
  store.append_frame(begun.run, example_frame(begun.branch, 0));
  CHECK_FALSE(newest_array(store, store.run(begun.run)));
}

// The array's picture: its scale, what a frame's counts become, and which taxels are judged dead.

namespace {

ArrayView equal_taxels(int rows, int columns) {
  ArrayView view;
  view.title = "T";
  view.rows = rows;
  view.columns = columns;
  view.full_scale_v = 5.0;
  view.volts.assign(static_cast<std::size_t>(rows * columns), 1.0);
  return view;
}

}  // namespace

TEST_CASE("array picture: the scale ends at a tenth of the converter range or higher, and never at zero") {
  ArrayView view = equal_taxels(1, 1);
  view.volts = {0.5};
  CHECK(scale_top_v(view) == 0.5);
  view.volts = {0.49};
  CHECK(scale_top_v(view) == 0.5);
  view.full_scale_v = 0.0;
  CHECK(scale_top_v(view) == 0.49);
  view.volts.clear();
  CHECK(scale_top_v(view) == 1e-9);
}

TEST_CASE(
    "array picture: mean outputs of a frame, saturated taxels, and the pressure above which taxels count as dead") {
  const ArrayBasis basis{0.001, {0.1, 0.1, 0.1, 0.1, 0.1, 0.1}};
  db::StoredFrame frame;
  frame.position = 19;
  frame.rows = 3;
  frame.columns = 2;
  frame.scans = 2;
  frame.reference_psi = 5.0;
  frame.counts = {100, 65535, 151, 149, 65534, 65535, 102, 65535, 151, 149, 65535, 200};
  ArrayView view = view_of_frame(basis, frame);
  CHECK((view.rows == 3 && view.columns == 2));
  CHECK(view.full_scale_v == Approx(65.535));
  CHECK(view.volts[0] == Approx(0.101));
  CHECK(view.volts[2] == Approx(0.151));
  CHECK(view.saturated == std::vector<int>{1, 4, 5});
  CHECK(view.dead_are_known);
  CHECK(view.dead == std::vector<int>{0, 3});  // those that rose by less than 50 mV
  frame.reference_psi = 4.99;
  CHECK_FALSE(view_of_frame(basis, frame).dead_are_known);
  frame.reference_psi = 6.0;
  CHECK_FALSE(view_of_frame({0.001, {0.1}}, frame).dead_are_known);
  CHECK_FALSE(view_of_frame({0.001, {}}, frame).dead_are_known);
  CHECK(view_of_frame(basis, frame).dead_are_known);
}

TEST_CASE("array picture: a seating check of another shape, or without values, is ignored") {
  const TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"));
  const Begun begun = begin_example(store);
  std::int64_t time_ns = 0;
  const auto basis_after = [&](const char* kind, const std::string& detail, std::vector<double> data) {
    store.append_check(begun.run, {begun.run, ++time_ns, kind, "pass", detail, std::move(data)});
    return array_basis(store, store.run(begun.run)).value().unloaded_v;
  };
  const std::string well = R"({"pressure_psi":8.0,"rows":1,"columns":2,"volts_per_count":0.5})";
  CHECK(basis_after("tare", well, {1, 2, 3, 4}).empty());
  CHECK(basis_after("seating", well, {1, 2, 3, 4}) == std::vector<double>{0.5, 1.0});
  CHECK(basis_after("tare", well, {5, 6, 7, 8}) == std::vector<double>{0.5, 1.0});  // the newest of seating
  CHECK(basis_after("seating", well, {3, 4, 5, 6}) == std::vector<double>{1.5, 2.0});
  CHECK(basis_after("seating", well, {3, 4}).empty());
  CHECK(basis_after("seating", R"({"rows":0,"columns":2,"volts_per_count":0.5})", {}).empty());
  CHECK(basis_after("seating", R"({"rows":-1,"columns":-2,"volts_per_count":0.5})", {1, 2, 3, 4}).empty());
  CHECK(basis_after("seating", R"({"rows":2,"columns":1,"volts_per_count":0.5})", {1, 2, 3, 4}).size() == 2);
  CHECK(basis_after("seating", "[]", {1, 2, 3, 4}).empty());
  CHECK_FALSE(newest_array(store, store.run(begun.run)));
}

TEST_CASE("array picture: which events show progress") {
  db::EventRecord event;
  for (const char* quiet : {"command", "stage", "environment", "fail-safe", "relays", "time", "prompt"}) {
    event.kind = quiet;
    CHECK_FALSE(shows_progress(event));
  }
  for (const char* loud : {"state", "warning", "attempt", "safe", "branch-broken", "", "commands"}) {
    event.kind = loud;
    CHECK(shows_progress(event));
  }
}

TEST_CASE("array picture: ten shades from 0 V to the highest output") {
  for (const auto& [volts, shade] : {std::pair{-0.1, 0},
                                     {0.0, 0},
                                     {0.1999, 0},
                                     {0.2001, 1},
                                     {1.79, 8},
                                     {1.8, 9},
                                     {2.0, 9},
                                     {1e9, 9},
                                     {std::nan(""), 0}})
    CHECK(shade_of(volts, 2.0) == static_cast<std::size_t>(shade));
}

TEST_CASE("array picture: never has more rows than the window") {
  for (const std::size_t columns : {5U, 17U, 20U, 35U, 40U, 80U, 200U})
    for (const std::size_t rows : {2U, 3U, 8U, 9U, 17U, 60U}) {
      INFO(columns << " x " << rows);
      const auto lines = heat_map(equal_taxels(24, 10), Shades::kCharacters, columns, rows);
      CHECK((lines.size() >= 2 && lines.size() <= rows));
    }
  CHECK(heat_map(equal_taxels(16, 16), Shades::kCharacters, 80, 1).empty());
  CHECK(heat_map(ArrayView{}, Shades::kCharacters, 80, 20).empty());
}

TEST_CASE("array picture: uses characters with NO_COLOR or on a terminal with few colours") {
  const Variable colour("NO_COLOR", ""), depth("COLORTERM", "");
  {
    const Variable terminal("TERM", "xterm-256color");
    CHECK(shades_of_terminal() == Shades::kColours);
    const Variable none("NO_COLOR", "1");
    CHECK(shades_of_terminal() == Shades::kCharacters);
  }
  const Variable terminal("TERM", "linux");
  CHECK(shades_of_terminal() == Shades::kCharacters);
  const Variable deep("COLORTERM", "truecolor");
  CHECK(shades_of_terminal() == Shades::kColours);
}

TEST_CASE("watch: cursor control characters in the content are not sent to the terminal") {
  const std::string text = painted({{{"\x1b[2Jcursor\n"}}}, 80, 0);
  CHECK(text.find("\x1b[2J") == std::string::npos);
  CHECK(painted({{{"a"}}}, 80, 3).starts_with("\x1b[3F"));
}

// A run as JSON: live, ended, dead, and with a store that cannot be read.

namespace {

struct StoredExample {
  StoredExample() : store(db::RunStore::open(folder.path("runs.db"))), begun(begin_example(store)) {
    const auto tell = [&](std::int64_t time_s, const char* kind, const char* id, const char* detail) {
      store.append_event(begun.run, {time_s * 1'000'000'000, kind, id, detail});
    };
    tell(1, "warning", "TB-OLD", "too long ago");
    tell(2, "state", "", "prepared -> running: x");
    tell(3, "attempt", "TB-SCANNER-TIMEOUT", "frame, 1 of 2: \x1b[2J silent");
    tell(4, "command", "pressure", "quiet");
    tell(3725, "branch-broken", "TB-BRANCH-BROKEN", "branch 1 of repeat 2");
    tell(3726, "environment", "temperature_c", "21.5");
  }
  [[nodiscard]] LiveRun live() const {
    LiveRun run = example_live();
    run.status.run = begun.run;
    run.status.store = store.path();
    run.status.frames_void = 3;
    return run;
  }
  TemporaryFolder folder;
  db::RunStore store;
  Begun begun;
};

}  // namespace

TEST_CASE("run view: if the store cannot be read, the data of the live run remain") {
  LiveRun live = example_live();
  live.status.store = "/nowhere/runs.db";
  const RunView view = view_of(live);
  CHECK_FALSE(view.stored);
  const nlohmann::ordered_json json = view_json(view);
  CHECK_THAT(json["store_unread"].get<std::string>(), Catch::Contains("/nowhere/runs.db"));
  CHECK_FALSE(json.contains("events"));
}

TEST_CASE("run view: the JSON document uses the same keys as other verbs") {
  const StoredExample example;
  const nlohmann::ordered_json json = view_json(view_of(example.live()));
  CHECK(json["run"] == 1);
  CHECK(json["bench"] == "rig-1");
  CHECK(json["process"] == 812);
  CHECK(json["state"] == "pausing");
  CHECK(json["phase"] == example_status().phase);
  CHECK(json["question"] == "Point indenter mounted?");
  CHECK(json["readings"]["reference_psi"] == 40.01);
  CHECK(json["readings"]["settled"] == true);
  CHECK(json["target_n"].is_null());
  CHECK(json["left_low_s"] == 630.0);
  CHECK((json["frames"] == 12 && json["frames_void"] == 3 && json["frames_planned"] == 211));
  CHECK(json["sensor"] == "S-1");
  CHECK(json["recipes"][1]["name"] == "down");
  REQUIRE(json["events"].size() == 3);
  CHECK(json["events"][1]["id"] == "TB-SCANNER-TIMEOUT");
  CHECK(json["events"][2]["time_s"].get<double>() == Approx(3725.0));
}

TEST_CASE("run view: a run without a process shows how it ended, and the next command") {
  StoredExample example;
  StoredRun run = stored_run(example.store, example.begun.run);
  CHECK(next_command(run, "runs.db") == "tactbench resume 1");
  example.store.end_run(run.record.run, db::Outcome::kCompleted, "all steps done", db::SafeState::kVerified, kUtc);
  run = stored_run(example.store, example.begun.run);
  CHECK(next_command(run, "other.db") == "tactbench fit 1 --db other.db");
  run.report = 7;  // judged by the models of run 7
  CHECK(next_command(run, "runs.db") == "tactbench report 7");
  CHECK_FALSE(stored_json(run, std::nullopt).contains("lives"));
  CHECK(stored_json(run, false)["lives"] == false);
  CHECK_THROWS_AS(stored_run(example.store, 9), db::StoreError);
}

TEST_CASE("run view: outcome, reason and safe state of a stored run give its exit code") {
  db::RunRecord run;
  const auto code = [&](db::Outcome outcome, const char* reason, db::SafeState safe = db::SafeState::kVerified) {
    run.outcome = outcome;
    run.reason = reason;
    run.safe_state = safe;
    return exit_code_of(run);
  };
  using db::Outcome;
  CHECK(code(Outcome::kCompleted, "all steps done") == ExitCode::kPass);
  CHECK(code(Outcome::kStopped, "TB-RUN-STOPPED: by t") == ExitCode::kStopped);
  CHECK(code(Outcome::kAborted, "TB-CHAMBER-TRIP: 67 psi") == ExitCode::kStopped);
  CHECK(code(Outcome::kFailed, "TB-MODBUS-TIMEOUT: no reply") == ExitCode::kDevice);
  CHECK(code(Outcome::kFailed, "TB-SEATING: row 3 is dead") == ExitCode::kCriterionFailed);
  CHECK(code(Outcome::kFailed, "TB-RUN-HOPELESS: dead") == ExitCode::kCriterionFailed);
  CHECK(code(Outcome::kFailed, "TB-STORE-FULL: no space") == ExitCode::kStore);
  CHECK(code(Outcome::kCompleted, "", db::SafeState::kUnverified) == ExitCode::kUnsafe);
  CHECK(code(Outcome::kStopped, "", db::SafeState::kFailed) == ExitCode::kUnsafe);
  CHECK(code(Outcome::kInterrupted, "", db::SafeState::kUnknown) == ExitCode::kDevice);
  CHECK(code(Outcome::kIncomplete, "", db::SafeState::kUnknown) == ExitCode::kDevice);
}
