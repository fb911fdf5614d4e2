// A run as JSON: live, ended, dead, and with a store that cannot be read.
#include "bench/monitor/run_view.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/bench/monitor/status_example.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;

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
