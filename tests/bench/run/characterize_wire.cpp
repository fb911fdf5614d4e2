#include <catch2/catch.hpp>
#include <cmath>

#include "tests/bench/run/finished_run.h"
#include "tests/bench/run/quick_store.h"
#include "tests/support/paths.h"

using namespace tactbench;
using namespace tactbench::tests;
using bench::ExitCode;

TEST_CASE("run: from recipe to store, ends with a closed row and a verified safe state") {
  bench::RunRequest request = small_request();
  request.bench.scanner_cable = "W-17";
  const FinishedRun run(request);
  const bench::RunResult& result = run.result;
  REQUIRE(!result.error);
  CHECK(result.outcome == db::Outcome::kCompleted);
  CHECK(result.safe == db::SafeState::kVerified);
  CHECK(result.frames == 2 * 15);
  CHECK(result.most_exchanges_a_step <= 20);
  const db::RunRecord row = run.store.run(result.run);
  CHECK(row.origin == "simulated");
  CHECK(row.state == "ended");
  REQUIRE(row.devices.size() == 4);
  CHECK_THAT(row.devices.back().calibration_json, Catch::Contains("\"cable\":\"W-17\""));
  CHECK(row.content_sha256 == result.content_sha256);
  CHECK(row.content_sha256.size() == 64);
  REQUIRE(run.frames.size() == 30);
  for (const db::FrameRecord& frame : run.frames) {
    CHECK(frame.in_band_ns >= 2'000'000'000);
    CHECK(frame.in_band_ns < 2'100'000'000);
    CHECK(frame.since_command_ns > frame.in_band_ns);
    CHECK(std::abs(frame.feedback_psi - frame.setpoint_psi) < 0.5);
    CHECK(std::abs(frame.reference_psi - frame.setpoint_psi) < 1.0);
    CHECK(frame.counts.size() == 2U * 256U);
    CHECK(frame.exchanges > 0);
  }
  CHECK(run.branches.size() == 8);
}

TEST_CASE("run: equal seeds give equal content, another noise or sensor seed gives different content") {
  QuickStore one, two;
  const std::string first = run_small(small_request({}, {5, 7}), one).content_sha256;
  CHECK(run_small(small_request({}, {5, 7}), two).content_sha256 == first);
  CHECK(run_small(small_request({}, {6, 7}), two).content_sha256 != first);
  CHECK(run_small(small_request({}, {5, 8}), two).content_sha256 != first);
}

TEST_CASE("run: equal seeds give equal content after an instrument fault, although its address differs") {
  QuickStore one, two;
  const auto [key, count, name] = GENERATE(table<std::string, std::string, std::string>({
      {"scanner_silent_after_scans", "14", "packet socket SOCKET:"},
      {"module_silent_after_requests", "150", "127.0.0.1:PORT"},
  }));
  const auto failed = [&, fault = "simulation.wire_faults." + key, after = count](db::RunStore& store) {
    return run_small(
        small_request({{fault, after}, {"scanner.frame_timeout_ms", "300"}, {"module.response_timeout_ms", "300"}}),
        store);
  };
  const bench::RunResult first = failed(one), second = failed(two);
  REQUIRE(first.error);
  REQUIRE(second.error);
  CHECK(std::string(first.error->what()) != second.error->what());  // a person is shown the address
  INFO(one.run(first.run).reason);
  CHECK_THAT(one.run(first.run).reason, Catch::Contains(name));
  CHECK(one.run(first.run).reason == two.run(second.run).reason);
  CHECK(first.content_sha256 == second.content_sha256);
}

TEST_CASE("run: a scanner that stops during a run ends it, vented, with frames kept and exit code 3") {
  const auto [key, id] = GENERATE(table<std::string, std::string>({
      {"scanner_silent_after_scans", "TB-SCANNER-TIMEOUT"},
      {"scanner_unplug_after_scans", "TB-SCANNER-LOST"},
  }));
  // 2 scans a frame and 2 for the baseline: the fault strikes in frame 6 (counted from 0).
  const FinishedRun run(small_request({{"simulation.wire_faults." + key, "14"}, {"scanner.frame_timeout_ms", "300"}}));
  const bench::RunResult& result = run.result;
  REQUIRE(result.error);
  INFO(key << ": " << result.error->what());
  CHECK(result.error->id() == id);
  CHECK(result.error->code() == ExitCode::kDevice);
  CHECK(result.safe == db::SafeState::kVerified);
  CHECK(result.outcome == db::Outcome::kFailed);
  CHECK(result.frames == 6);
  CHECK(!result.error->remedy().empty());
}

TEST_CASE("run: a bad frame is read again, and the attempt and the flag are stored") {
  const std::string key = GENERATE("scanner_corrupt_scan", "scanner_drop_report_scan");
  bench::RunRequest request =
      small_request({{"simulation.wire_faults." + key, "14"}, {"scanner.frame_timeout_ms", "300"}});
  const std::string rule = GENERATE("worst", "any");
  request.recipes = {small_recipe("[retry]\nverdict = \"" + rule + "\"\n")};
  const FinishedRun run(request);
  const bench::RunResult& result = run.result;
  INFO(key << " " << rule);
  CHECK(result.outcome == db::Outcome::kCompleted);
  REQUIRE(run.frames.size() == 30);
  CHECK(run.frames[6].flags == (rule == "worst" ? "retried" : ""));
  int attempts = 0;
  for (const db::EventRecord& event : run.store.events(result.run)) {
    if (event.kind != "attempt") continue;
    ++attempts;
    CHECK(event.id == "TB-SCANNER-CORRUPT");
  }
  CHECK(attempts == 1);
}

TEST_CASE("run: a Modbus server that is silent, dies or never answers ends it, with the safe state unverified") {
  const auto [key, requests] = GENERATE(table<std::string, std::string>({{"module_silent_after_requests", "150"},
                                                                         {"module_dead_after_requests", "150"},
                                                                         {"module_silent_after_requests", "0"}}));
  const FinishedRun run(
      small_request({{"simulation.wire_faults." + key, requests}, {"module.response_timeout_ms", "300"}}));
  const bench::RunResult& result = run.result;
  REQUIRE(result.error);
  INFO(key << " " << requests << ": " << result.error->what() << " / " << result.error->rig_state());
  CHECK(result.error->code() == ExitCode::kUnsafe);
  CHECK(result.outcome == db::Outcome::kFailed);
  CHECK((result.frames > 0) == (requests != "0"));
  if (requests == "0") return;
  CHECK_THAT(result.error->id(), Catch::StartsWith("TB-MODBUS-"));
  CHECK(result.safe == db::SafeState::kUnverified);
}

TEST_CASE("run: pressure above the trip, or a reference that disagrees with the feedback, aborts it and vents") {
  struct Row {
    std::string id;
    std::vector<sequences::Override> overrides;
  };
  // A transducer that reads a third too much stands for an overshoot: 50 psi seem to be 66.7. One that is taken for one
  // of twice its span disagrees.
  const Row row = GENERATE(
      values<Row>({{"TB-CHAMBER-TRIP", {{"limits.disagreement_psi", "50"}, {"reference.span_psi", "[0, 133.4]"}}},
                   {"TB-CHAMBER-DISAGREE", {{"reference.span_psi", "[0, 200]"}}}}));
  bench::RunRequest request = small_request(row.overrides);
  if (row.id == "TB-CHAMBER-TRIP")
    request.recipes = {recipe_of("unit = \"psi\"\nturning_points = [0, 60, 0]\nstep = 10\ndwell_s = 0.5\n")};
  const FinishedRun run(request);
  const bench::RunResult& result = run.result;
  REQUIRE(result.error);
  INFO(result.error->what());
  CHECK(result.error->id() == row.id);
  CHECK(result.error->code() == ExitCode::kStopped);
  CHECK(result.outcome == db::Outcome::kAborted);
  CHECK(result.safe == db::SafeState::kVerified);
  if (row.id == "TB-CHAMBER-TRIP") CHECK(result.frames == 5);
}

TEST_CASE("run: a sensor registered with another scanner is rejected before any pressure") {
  bench::RunRequest request = small_request();
  request.sensor.scanner_serial = "ANOTHER";
  const FinishedRun run(request);
  REQUIRE(run.result.error);
  CHECK(run.result.error->id() == "TB-SCANNER-SERIAL");
  CHECK(run.result.frames == 0);
}

TEST_CASE("run: the memory of the film can be passed from one run to the next") {
  const TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
  bench::RunRequest request = small_request();
  const std::string virgin = run_small(request, store).content_sha256;
  request.specimen_state_file = folder.path("film.json");
  CHECK(run_small(request, store).content_sha256 == virgin);  // no such file yet: virgin film
  CHECK(run_small(request, store).content_sha256 != virgin);  // the second time the film remembers
}

TEST_CASE("run: executes the same steps that plan lists") {
  const TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
  bench::RunRequest request = small_request();
  std::vector<sequences::Step> carried_out;
  request.on_step = [&](const sequences::Step& step) { carried_out.push_back(step); };
  REQUIRE(run_small(request, store).outcome == db::Outcome::kCompleted);
  const std::vector<sequences::Step> planned = sequences::compile(request.recipes);
  CHECK(carried_out == planned);
  write_file(folder.path("small.toml"), request.recipes.front().text);
  const std::string listed =
      run_program(program_path(), {"plan", "small.toml", "--bench", "simulated.toml", "--steps"}, folder.path()).out;
  std::string lines;
  for (const sequences::Step& step : carried_out) lines += sequences::step_line(step) + "\n";
  CHECK_THAT(listed, Catch::EndsWith(lines));
}

TEST_CASE("run: the trace stored with frames holds every pressure reading, in order and without gaps") {
  const FinishedRun run(small_request({{"settling.trace_s", "0.1"}}));
  double last_s = 0.0;
  for (const db::FrameRecord& frame : run.frames) {
    REQUIRE(!frame.trace.empty());
    const double frame_s = static_cast<double>(frame.time_ns) * 1e-9;
    for (const db::TracePoint& point : frame.trace) {
      const double time_s = frame_s - static_cast<double>(point.before_frame_s);
      CHECK(time_s > last_s);
      if (frame.ordinal > 0) CHECK(time_s - last_s < 0.25);
      last_s = time_s;
    }
    const db::TracePoint& at_frame = frame.trace.back();
    CHECK(at_frame.reference_psi == Approx(frame.reference_psi).margin(1e-4));
    CHECK(at_frame.setpoint_psi == Approx(frame.setpoint_psi).margin(1e-4));
    CHECK(frame.flags.empty());
    CHECK(static_cast<double>(frame.in_band_ns) * 1e-9 == Approx(2.0).margin(0.01));
  }
}
