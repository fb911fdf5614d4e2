// What the page says of a live run: its readings as JSON, and the safe state.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "bench/page/run_on_show.h"

using namespace tactbench;
using namespace tactbench::bench;

namespace {

LiveRun loaded_run() {
  LiveRun live;
  live.status.run = 7;
  live.status.state = RunState::kRunning;
  live.status.readings = RunReadings{1.5, 20.0, 20.25, 20.5, true, std::nullopt};
  return live;
}

}  // namespace

TEST_CASE("page: a live run's readings, with force and target where it presses") {
  LiveRun live = loaded_run();
  live.status.phase = "moving";
  live.status.step = 3;
  live.status.steps = 9;
  live.status.frames = 2;
  live.status.left_s = 10.0;
  live.status.left_low_s = 8.0;
  live.status.left_high_s = 12.0;
  live.status.age_s = 0.5;
  CHECK(readings_json(live) ==
        nlohmann::json::parse("{\"run\":7,\"phase\":\"moving\",\"step\":3,\"steps\":9,\"frames\":2,\"left_s\":10.0,"
                              "\"left_low_s\":8.0,\"left_high_s\":12.0,\"age_s\":0.5,\"time_s\":1.5,"
                              "\"setpoint_psi\":20.0,\"feedback_psi\":20.25,\"reference_psi\":20.5,\"settled\":true}"));
  live.status.target_n = 5.0;
  live.status.readings->force_n = 4.5;
  CHECK(readings_json(live)["target_n"] == 5.0);
  CHECK(readings_json(live)["force_n"] == 4.5);
  live.status.readings.reset();
  for (const char* none : {"time_s", "setpoint_psi", "settled", "force_n"})
    CHECK_FALSE(readings_json(live).contains(none));
}

TEST_CASE("page: the safe state of a live run loaded, resting and proved") {
  LiveRun live = loaded_run();
  const db::EventRecord proved{1, "safe", "verified", "two witnesses"};
  CHECK(safe_words(&live, nullptr, proved).state == "loaded");
  for (const RunState rests : {RunState::kPaused, RunState::kSuspended}) {
    live.status.state = rests;
    CHECK(safe_words(&live, nullptr, proved).state == "proved");
    CHECK(safe_words(&live, nullptr, std::nullopt).state == "unknown");
  }
  live.status.readings->force_n = 1.256;
  CHECK(safe_words(&live, nullptr, std::nullopt).state == "unknown");
  live.status.readings.reset();
  live.status.state = RunState::kRunning;
  CHECK(safe_words(&live, nullptr, proved).state == "loaded");
}

TEST_CASE("page: the safe state of a run that has ended, by its last event or its reason") {
  CHECK(safe_words(nullptr, nullptr, std::nullopt).state == "unknown");
  StoredRun stored;
  stored.record.reason = "all steps done";
  for (const db::Outcome broken : {db::Outcome::kIncomplete, db::Outcome::kInterrupted}) {
    stored.record.outcome = broken;
    stored.record.safe_state = db::SafeState::kVerified;
    CHECK(safe_words(nullptr, &stored, std::nullopt).state == "unknown");
  }
  const db::EventRecord event{1, "safe", "verified", "by the gauge"};
  stored.record.outcome = db::Outcome::kFailed;
  CHECK(safe_words(nullptr, &stored, event).state == "proved");
  CHECK(safe_words(nullptr, &stored, std::nullopt).state == "proved");
  stored.record.safe_state = db::SafeState::kFailed;
  CHECK(safe_words(nullptr, &stored, event).state == "unknown");
}
