// The page's data about the displayed run: its state with each member, the last one of a bench, a store that is not
// there; the safe state; and the lists of runs and sensors. On runs that are stored by hand.
#include "bench/page/displayed_run.h"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "bench/common/error_table.h"
#include "bench/page/lists.h"
#include "tests/bench/monitor/status_example.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;

namespace {

struct ShownRun {
  std::string bench_id = "bench-a", sensor = "S-1", origin = "simulated";
  db::Outcome outcome = db::Outcome::kCompleted;  // incomplete: it does not end
  int frames = 1;
};

class ShownStore {
 public:
  ShownStore() {
    for (const char* serial : {"S-1", "S-2"})
      store.add_sensor({serial, "array", "rows = 3\n", db::sha256_hex("rows = 3\n"), "", "", kUtc});
  }
  std::int64_t add(const ShownRun& made = {}) {
    db::RunRecord run = example_run();
    run.bench_id = made.bench_id;
    run.sensor_serial = made.sensor;
    run.origin = made.origin;
    run.seed = ++seed_;
    const std::int64_t number = store.begin_run(run);
    branch_ = store.begin_branch(number, example_branch());
    for (int i = 0; i < made.frames; ++i) add_frame(number);
    if (made.outcome != db::Outcome::kIncomplete)
      store.end_run(number, made.outcome, "all steps done", db::SafeState::kVerified, "2026-01-01T01:00:00Z");
    return number;
  }
  void add_frame(std::int64_t run) { store.append_frame(run, example_frame(branch_, frames_++)); }
  [[nodiscard]] nlohmann::json shown(const std::string& bench = {}) const {
    DisplayedRun show(path, bench);
    show.look(nullptr);
    return show.state(nullptr, 1.5);
  }

 private:
  TemporaryFolder folder_;
  std::int64_t seed_ = 100, branch_ = 0;
  int frames_ = 0;

 public:
  std::string path = folder_.path("runs.db");
  db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
};

LiveRun live_of(std::int64_t run, std::int64_t frames) {
  LiveRun live = example_live();
  live.status.run = run;
  live.status.state = RunState::kRunning;
  live.status.frames = frames;
  return live;
}

LiveRun loaded_run() {
  LiveRun live;
  live.status.run = 7;
  live.status.state = RunState::kRunning;
  live.status.readings = RunReadings{1.5, 20.0, 20.25, 20.5, true, std::nullopt};
  return live;
}

}  // namespace

TEST_CASE("shown run: an empty store gives a state with all members, a missing store states the reason") {
  const ShownStore made;
  const nlohmann::json empty = made.shown();
  CHECK((empty["live"] == false && empty["silent_s"] == 1.5 && empty["store"] == made.path));
  CHECK((empty["unread"] == "" && empty["safe"]["state"] == "none" && empty["events"].empty()));
  DisplayedRun none(made.path + ".none", "");
  std::string why;
  CHECK(none.store(&why) == nullptr);
  CHECK_THAT(why, Catch::Contains(made.path + ".none"));
  none.look(nullptr);
  CHECK(none.state(nullptr, 0.0)["unread"] == why);
  CHECK(none.run() == 0);
  CHECK(none.picture().is_null());
  CHECK_FALSE(none.consume_new_picture());
  // One that comes is opened.
  const db::RunStore later = db::RunStore::open(made.path + ".none", db::Durability::kNormal);
  CHECK(none.store(&why) != nullptr);
  CHECK(why.empty());
}

TEST_CASE("shown run: the last run of the store or bench, with the next command and its safe state") {
  ShownStore made;
  (void)made.add();
  (void)made.add({.bench_id = "bench-b", .outcome = db::Outcome::kFailed});
  (void)made.add();
  const nlohmann::json last = made.shown();
  CHECK(last["view"]["run"] == 3);
  CHECK(last["next"] == "tactbench fit 3 --db " + made.path);
  CHECK(last["origin"] == "simulated");
  CHECK(last["safe"]["state"] == "proved");
  CHECK(last["before"] == 1);
  CHECK_FALSE(last["view"].contains("lives"));
  const nlohmann::json other = made.shown("bench-b");
  CHECK(other["view"]["run"] == 2);
  CHECK(other["next"] == "tactbench resume 2 --db " + made.path);
  CHECK(made.shown("bench-a")["view"]["run"] == 3);
  CHECK_FALSE(made.shown("bench-c").contains("view"));
}

TEST_CASE("shown run: the run before it is the last completed valid run of the same sensor and origin") {
  ShownStore made;
  (void)made.add();                                    // 1
  (void)made.add();                                    // 2
  (void)made.add();                                    // 3, void
  (void)made.add({.outcome = db::Outcome::kStopped});  // 4
  (void)made.add({.sensor = "S-2"});                   // 5
  (void)made.add({.origin = "hardware"});              // 6
  (void)made.add({.bench_id = "bench-b"});             // 7
  (void)made.add({.bench_id = "bench-c"});             // 8, later than the one shown
  made.store.void_run(3, "by hand", "me", kUtc);
  CHECK(made.shown("bench-b")["before"] == 2);
}

TEST_CASE("shown run: lists the twelve newest events about progress, newest first, with remedies") {
  ShownStore made;
  const std::int64_t run = made.add({.outcome = db::Outcome::kIncomplete});
  const auto tell = [&](const char* kind, const char* id, const std::string& detail) {
    made.store.append_event(run, {1'500'000'000, kind, id, detail});
  };
  tell("safe", "verified", "by two witnesses");
  for (int i = 0; i < 12; ++i) tell("note", "", fmt::format("number {}", i));
  for (const char* quiet : {"command", "stage", "environment", "fail-safe", "relays", "time"}) tell(quiet, "", "quiet");
  tell("fault", "TB-CHAMBER-TIMEOUT", "late\nagain");
  const nlohmann::json state = made.shown();
  REQUIRE(state["events"].size() == 12);
  const nlohmann::json& newest = state["events"][0];
  CHECK((newest["time_s"] == 1.5 && newest["kind"] == "fault" && newest["id"] == "TB-CHAMBER-TIMEOUT"));
  CHECK(newest["detail"].get<std::string>().find('\n') == std::string::npos);
  CHECK(newest["try"] == error_row("TB-CHAMBER-TIMEOUT")->remedy);
  for (std::size_t i = 1; i < 12; ++i) CHECK(state["events"][i]["detail"] == fmt::format("number {}", 12 - i));
  CHECK(state["safe"]["state"] == "unknown");
  made.store.end_run(run, db::Outcome::kCompleted, "done", db::SafeState::kVerified, kUtc);
  CHECK(made.shown()["safe"]["state"] == "proved");  // its event is older than the dozen
}

TEST_CASE("shown run: the status of a live run is combined with its stored data") {
  ShownStore made;
  (void)made.add();
  const std::int64_t run = made.add({.outcome = db::Outcome::kIncomplete, .frames = 2});
  made.store.append_event(run, {1, "safe", "verified", "by two witnesses"});
  DisplayedRun show(made.path, "bench-of-none");
  LiveRun live = live_of(run, 2);
  show.look(&live);
  CHECK(show.run() == run);
  CHECK(show.consume_new_picture());
  CHECK_FALSE(show.consume_new_picture());
  CHECK(show.picture()["position"] == 2);
  live.status.question_id = 4;
  live.status.state = RunState::kPaused;
  live.status.answer = GivenAnswer{3, "yes", "bob"};
  const nlohmann::json state = show.state(&live, 0.25);
  CHECK(state["live"] == true);
  CHECK(state["silent_s"] == 0.25);
  CHECK_FALSE(state.contains("next"));
  CHECK(state["view"]["run"] == run);
  CHECK(state["view"]["sensor"] == "S-1");  // of the store
  CHECK(state["view"]["question_id"] == 4);
  CHECK(state["view"]["answer"] == nlohmann::json({{"question", 3}, {"text", "yes"}, {"who", "bob"}}));
  CHECK(state["safe"]["state"] == "proved");
  CHECK(state["before"] == 1);
  CHECK(state["events"].size() == 1);
  live.status.answer.reset();
  CHECK_FALSE(show.state(&live, 0.0)["view"].contains("answer"));
  // Another run is live than the one that was read.
  live.status.run = run + 1;
  const nlohmann::json other = show.state(&live, 0.0);
  CHECK_FALSE(other["view"].contains("sensor"));
  CHECK(other["safe"]["state"] == "unknown");
  CHECK(other["before"] == 0);
  CHECK(other["events"].empty());
  CHECK(other["origin"] == "simulated");
}

TEST_CASE("shown run: new frames of a live run appear at once, its end appears when it is stored") {
  ShownStore made;
  const std::int64_t run = made.add({.outcome = db::Outcome::kIncomplete});
  DisplayedRun show(made.path, "");
  LiveRun live = live_of(run, 1);
  const auto begun = std::chrono::steady_clock::now();
  show.look(&live);
  CHECK(show.consume_new_picture());
  made.add_frame(run);
  show.look(&live);  // it reports nothing new: the store is read again three seconds later
  const bool early = std::chrono::steady_clock::now() - begun < std::chrono::seconds(3);
  CHECK(show.consume_new_picture() == !early);
  live.status.frames = 2;
  show.look(&live);
  CHECK(show.consume_new_picture());
  CHECK(show.picture()["position"] == 2);
  made.store.end_run(run, db::Outcome::kStopped, "asked", db::SafeState::kVerified, kUtc);
  show.look(nullptr);
  CHECK(show.state(nullptr, 0.0)["view"]["outcome"] == "stopped");
  // The next one: read at once, too, with its own frames and what was before it.
  const std::int64_t next = made.add({.outcome = db::Outcome::kIncomplete, .frames = 3});
  live = live_of(next, 3);
  show.look(&live);
  CHECK(show.run() == next);
  CHECK(show.picture()["run"] == next);
  CHECK(show.picture()["position"] == 3);
}

TEST_CASE("shown run: a replaced store is opened again") {
  ShownStore made, other;
  (void)made.add();
  DisplayedRun show(made.path, "");
  show.look(nullptr);
  CHECK(show.run() == 1);
  const db::RunStore* const before = show.store();
  CHECK(show.store() == before);
  CHECK(show.run() == 1);
  (void)other.add();
  (void)other.add();
  other.store.snapshot(made.path + ".new");
  for (const char* more : {"-wal", "-shm"}) std::filesystem::remove(made.path + more);
  std::filesystem::rename(made.path + ".new", made.path);
  REQUIRE(show.store() != nullptr);
  CHECK(show.run() == 0);
  CHECK(show.store()->runs().size() == 2);
}

TEST_CASE("page lists: runs newest first with verdict and report, sensors with calibration, nights") {
  ShownStore made;
  CHECK(runs_list(made.store)["runs"].empty());
  CHECK(stored_nights(made.store) == 0);
  (void)made.add();
  (void)made.add({.frames = 3});
  (void)made.add({.sensor = "S-2", .outcome = db::Outcome::kIncomplete});
  db::FitRecord fit;
  fit.run = 1;
  fit.model = "elam";
  fit.stands = true;
  const std::int64_t number = made.store.add_fit(fit);
  db::VerdictRecord close, far;
  close.verdict = far.verdict = "fail";
  close.value = 2.0;
  far.value = 3.0;
  far.criterion = "worst_taxel_error";
  close.limit = far.limit = 1.0;
  made.store.replace_verdicts(2, number, {close, far});
  const nlohmann::ordered_json runs = runs_list(made.store);
  CHECK(runs["left_out"] == 0);
  REQUIRE(runs["runs"].size() == 3);
  const auto& all = runs["runs"];
  CHECK((all[0]["run"] == 3 && all[0]["verdict"].is_null() && all[0]["report"] == 0 && all[0]["lives"] == false));
  CHECK((all[1]["frames"] == 3 && all[1]["report"] == 1));  // held out: its models' report
  CHECK_FALSE(all[1].contains("lives"));
  CHECK((all[2]["report"] == 1 && all[2]["sensor"] == "S-1"));
  for (const int row : {1, 2}) {
    CHECK((all[row]["verdict"]["word"] == "fail" && all[row]["verdict"]["models_of"] == 1));
    CHECK_THAT(all[row]["verdict"]["decided"].get<std::string>(), Catch::Contains("3 psi"));
  }
  CHECK(made.shown("bench-a")["verdict"].is_null());  // of a run that has not ended
  made.store.end_run(3, db::Outcome::kStopped, "asked", db::SafeState::kVerified, kUtc);
  (void)made.add({.bench_id = "bench-b"});
  made.store.replace_verdicts(4, number, {close});
  const nlohmann::json last = made.shown("bench-b");
  CHECK(last["next"] == "tactbench report 1 --db " + made.path);
  CHECK((last["verdict"]["word"] == "fail" && last["verdict"]["models_of"] == 1));
  CHECK_THAT(last["verdict"]["decided"].get<std::string>(),
             Catch::Contains("3 psi"));  // of run 2, with the same models
  made.store.replace_figures(2, "sensor/S-2/up", {{"a_psi", 1.0}});
  made.store.replace_figures(2, "nightly/x", {{"a_psi", 1.0}});
  analysis::Laboratory laboratory;
  laboratory.recalibrate_after_months = 1;
  const std::string day = made.store.run(4).started_utc.substr(0, 10);
  const nlohmann::ordered_json sensors = sensors_list(made.store, laboratory, day)["sensors"];
  REQUIRE(sensors.size() == 2);
  CHECK(sensors[0]["serial"] == "S-1");
  CHECK(sensors[0]["runs"] == nlohmann::ordered_json({4, 2, 1}));
  CHECK(sensors[0]["verdict"]["models_of"] == 1);
  CHECK((sensors[0]["calibrated"] == day && sensors[0]["due"] > day && sensors[0]["overdue"] == false));
  CHECK(sensors_list(made.store, laboratory, "2999-01-01")["sensors"][0]["overdue"] == true);
  CHECK(sensors_list(made.store, {}, "2999-01-01")["sensors"][0]["due"] == "");
  CHECK(sensors[0]["figures"] == false);
  CHECK((sensors[1]["verdict"].is_null() && !sensors[1].contains("calibrated")));
  CHECK(sensors[1]["runs"] == nlohmann::ordered_json::array({3}));
  CHECK(sensors[1]["figures"] == true);
  CHECK(stored_nights(made.store) == 1);
}

TEST_CASE("page lists: at most the newest five hundred runs, and the number of those left out") {
  ShownStore made;
  for (int i = 0; i < 502; ++i) (void)made.add({.frames = 0});
  const nlohmann::ordered_json some = runs_list(made.store);
  REQUIRE(some["runs"].size() == 500);
  CHECK(some["left_out"] == 2);
  CHECK(some["runs"][0]["run"] == 502);
  CHECK(some["runs"][499]["run"] == 3);
}

TEST_CASE("page: the readings of a live run, with force and target if it presses") {
  LiveRun live = loaded_run();
  live.status.phase = "moving";
  live.status.step = 3;
  live.status.steps = 9;
  live.status.frames = 2;
  live.status.left_s = 10.0;
  live.status.left_low_s = 8.0;
  live.status.left_high_s = 12.0;
  CHECK(readings_json(live) ==
        nlohmann::json::parse("{\"run\":7,\"phase\":\"moving\",\"step\":3,\"steps\":9,\"frames\":2,\"left_s\":10.0,"
                              "\"left_low_s\":8.0,\"left_high_s\":12.0,\"time_s\":1.5,"
                              "\"setpoint_psi\":20.0,\"feedback_psi\":20.25,\"reference_psi\":20.5,\"settled\":true}"));
  live.status.target_n = 5.0;
  live.status.readings->force_n = 4.5;
  CHECK(readings_json(live)["target_n"] == 5.0);
  CHECK(readings_json(live)["force_n"] == 4.5);
  live.status.readings.reset();
  for (const char* none : {"time_s", "setpoint_psi", "settled", "force_n"})
    CHECK_FALSE(readings_json(live).contains(none));
}

TEST_CASE("page: safe state of a live run: loaded, paused or proved") {
  LiveRun live = loaded_run();
  const db::EventRecord proved{1, "safe", "verified", "two witnesses"};
  CHECK(safe_state_text(&live, nullptr, proved).state == "loaded");
  for (const RunState rests : {RunState::kPaused, RunState::kSuspended}) {
    live.status.state = rests;
    CHECK(safe_state_text(&live, nullptr, proved).state == "proved");
    CHECK(safe_state_text(&live, nullptr, std::nullopt).state == "unknown");
  }
  live.status.readings->force_n = 1.256;
  CHECK(safe_state_text(&live, nullptr, std::nullopt).state == "unknown");
  live.status.readings.reset();
  live.status.state = RunState::kRunning;
  CHECK(safe_state_text(&live, nullptr, proved).state == "loaded");
}

TEST_CASE("page: the safe state of an ended run follows from its last event or its reason") {
  CHECK(safe_state_text(nullptr, nullptr, std::nullopt).state == "none");
  StoredRun stored;
  stored.record.reason = "all steps done";
  for (const db::Outcome broken : {db::Outcome::kIncomplete, db::Outcome::kInterrupted}) {
    stored.record.outcome = broken;
    stored.record.safe_state = db::SafeState::kVerified;
    CHECK(safe_state_text(nullptr, &stored, std::nullopt).state == "unknown");
  }
  const db::EventRecord event{1, "safe", "verified", "by the gauge"};
  stored.record.outcome = db::Outcome::kFailed;
  CHECK(safe_state_text(nullptr, &stored, event).state == "proved");
  CHECK(safe_state_text(nullptr, &stored, std::nullopt).state == "proved");
  stored.record.safe_state = db::SafeState::kFailed;
  CHECK(safe_state_text(nullptr, &stored, event).state == "unknown");
}
