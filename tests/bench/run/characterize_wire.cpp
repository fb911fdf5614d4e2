#include <fmt/format.h>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <cmath>
#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

#include "bench/rig/rig.h"
#include "bench/simulation/plant.h"
#include "tests/bench/run/finished_run.h"
#include "tests/bench/run/quick_store.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"
#include "tests/support/refusal.h"
#include "tests/support/small_run.h"

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

TEST_CASE("run: an instrument or the chamber that fails ends it, vented if the module answers, with frames kept") {
  struct Row {
    std::vector<sequences::Override> overrides;
    std::string id;  // or its beginning
    ExitCode code;
    db::SafeState safe;
    std::int64_t low, high;  // of frames
    double peak_psi = 0.0;
  };
  const auto wire = [](const std::string& fault, const std::string& after) {
    return std::vector<sequences::Override>{{"simulation.wire_faults." + fault, after},
                                            {"scanner.frame_timeout_ms", "300"},
                                            {"module.response_timeout_ms", "300"}};
  };
  const auto kVerified = db::SafeState::kVerified, kUnverified = db::SafeState::kUnverified;
  const Row row = GENERATE_COPY(values<Row>(
      {// 2 scans a frame and 2 for the baseline: the fault strikes in frame 6 (counted from 0).
       {wire("scanner_silent_after_scans", "14"), "TB-SCANNER-TIMEOUT", ExitCode::kDevice, kVerified, 6, 6},
       {wire("scanner_unplug_after_scans", "14"), "TB-SCANNER-LOST", ExitCode::kDevice, kVerified, 6, 6},
       {wire("module_silent_after_requests", "150"), "TB-MODBUS-", ExitCode::kUnsafe, kUnverified, 1, 29},
       {wire("module_dead_after_requests", "150"), "TB-MODBUS-", ExitCode::kUnsafe, kUnverified, 1, 29},
       // A transducer that reads a third too much stands for an overshoot: 50 psi seem to be 66.7. One that is
       // read as one of twice its span disagrees.
       {{{"limits.disagreement_psi", "50"}, {"reference.span_psi", "[0, 133.4]"}},
        "TB-CHAMBER-TRIP",
        ExitCode::kStopped,
        kVerified,
        5,
        5,
        60.0},
       {{{"reference.span_psi", "[0, 200]"}}, "TB-CHAMBER-DISAGREE", ExitCode::kStopped, kVerified, 0, 29}}));
  bench::RunRequest request = small_request(row.overrides);
  if (row.peak_psi > 0.0)
    request.recipes = {recipe_of("unit = \"psi\"\nturning_points = [0, 60, 0]\nstep = 10\ndwell_s = 0.5\n")};
  const FinishedRun run(request);
  const bench::RunResult& result = run.result;
  REQUIRE(result.error);
  INFO(result.error->what() << " / " << result.error->rig_state());
  CHECK_THAT(result.error->id(), Catch::StartsWith(row.id));
  CHECK(result.error->code() == row.code);
  CHECK_FALSE(result.error->remedy().empty());
  CHECK(result.outcome == (row.code == ExitCode::kStopped ? db::Outcome::kAborted : db::Outcome::kFailed));
  CHECK(result.safe == row.safe);
  CHECK(result.frames >= row.low);
  CHECK(result.frames <= row.high);
}

TEST_CASE("run: a Modbus server that never answers ends it before the first frame, with the unsafe exit code") {
  const FinishedRun run(small_request(
      {{"simulation.wire_faults.module_silent_after_requests", "0"}, {"module.response_timeout_ms", "300"}}));
  REQUIRE(run.result.error);
  CHECK(run.result.error->code() == ExitCode::kUnsafe);
  CHECK(run.result.outcome == db::Outcome::kFailed);
  CHECK(run.result.frames == 0);
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
  QuickStore store;
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

// Recipes whose first level is not the pressure at which the conditioning ends, or the repeat before.

namespace {

struct Row {
  const char* turning_points;
  std::vector<double> levels;  // of a repeat's frames, psi
};

}  // namespace

TEST_CASE("run: a repeat may begin at any level and fall, rise or stay") {
  const Row row = GENERATE(values<Row>({{"[20, 10, 20, 0]", {20, 10, 20, 10, 0}},
                                        {"[20, 10]", {20, 10}},
                                        {"[10, 20]", {10, 20}},
                                        {"[20]\nframes_per_level = 3\nframe_interval_s = 1", {20, 20, 20}}}));
  INFO(row.turning_points);
  bench::RunRequest request = small_request();
  request.recipes = {recipe_of(fmt::format(
      "unit = \"psi\"\nturning_points = {}\nstep = 10\nrepeats = 2\n[conditioning]\ncycles = 1\npeak = 20\n",
      row.turning_points))};
  const FinishedRun run(request);
  const bench::RunResult& result = run.result;
  INFO((result.error ? result.error->what() : ""));
  REQUIRE(result.outcome == db::Outcome::kCompleted);
  std::vector<double> expected = row.levels, read;
  expected.insert(expected.end(), row.levels.begin(), row.levels.end());
  for (const db::BranchRecord& branch : run.store.branches(1)) CHECK_FALSE(branch.is_void);
  for (const db::FrameRecord& frame : run.store.frames(1)) {
    read.push_back(frame.setpoint_psi);
    CHECK(frame.reference_psi == Approx(frame.setpoint_psi).margin(0.5));
    CHECK(frame.flags.empty());
  }
  CHECK(read == expected);
}

// A recipe's [limits]: a run that cannot be of use ends at the first frame of the highest level, and not later.

namespace {

struct Ended {
  bench::RunResult result;
  std::vector<double> levels;    // of its frames, psi
  std::vector<double> mean_v{};  // of all taxels, of each frame
};

double mean_counts(const db::FrameRecord& frame) {
  double sum = 0.0;
  for (const std::uint16_t counts : frame.counts) sum += counts;
  return sum / static_cast<double>(frame.counts.size());
}

Ended run_with(const std::string& limits, const std::string& defects) {
  QuickStore store;
  const std::vector<sequences::Override> defective = {{"simulation.defect", defects}};
  bench::RunRequest request = small_request(defects.empty() ? std::vector<sequences::Override>() : defective);
  request.overrides.clear();
  request.recipes = {
      recipe_of("unit = \"psi\"\nturning_points = [0, 60, 0]\nstep = 20\nrepeats = 2\n[limits]\n" + limits)};
  double volts_per_count = 0.0;
  request.on_rig = [&](bench::Rig& rig, bench::RigMoment) {
    if (rig.has_array()) volts_per_count = rig.array().volts_per_count().value();
  };
  Ended ended{run_small(request, store), {}};
  for (const db::FrameRecord& frame : store.frames(1)) {
    ended.levels.push_back(frame.setpoint_psi);
    ended.mean_v.push_back(mean_counts(frame) * volts_per_count);
  }
  return ended;
}

const std::string kSound;
const std::string kTwoDead = "[{kind=\"dead\",row=0,column=0},{kind=\"dead\",row=15,column=15}]";

void check_ends_at_the_peak(const Ended& ended, int dead) {
  REQUIRE(ended.result.error);
  CHECK(ended.result.error->id() == "TB-RUN-HOPELESS");
  CHECK(ended.result.error->code() == bench::ExitCode::kCriterionFailed);
  CHECK_THAT(ended.result.error->what(), Catch::Contains("60 psi") && Catch::Contains(fmt::format(" {} taxels", dead)));
  CHECK(ended.result.outcome == db::Outcome::kFailed);
  CHECK(ended.result.safe == db::SafeState::kVerified);
  CHECK(ended.levels == std::vector<double>{0, 20, 40, 60});
}

void check_goes_on(const Ended& ended) {
  INFO((ended.result.error ? ended.result.error->what() : ""));
  CHECK(ended.result.outcome == db::Outcome::kCompleted);
  CHECK(ended.levels.size() == 14);
}

}  // namespace

TEST_CASE("run: with more dead taxels than the recipe allows it ends at the first peak") {
  check_ends_at_the_peak(run_with("most_dead_taxels = 0\n", kTwoDead), 2);
  check_ends_at_the_peak(run_with("most_dead_taxels = 1\n", kTwoDead), 2);
  check_goes_on(run_with("most_dead_taxels = 2\n", kTwoDead));
  check_goes_on(run_with("most_dead_taxels = 0\n", kSound));
  check_goes_on(run_with("most_dead_taxels = -1\n", kTwoDead));
}

TEST_CASE("run: with an array response below the minimum of the recipe it ends at the first peak") {
  const Ended weak = run_with("least_response_v = 4.5\n", kSound);
  check_ends_at_the_peak(weak, 0);
  REQUIRE(weak.mean_v.size() == 4);
  CHECK(weak.mean_v[0] > 0.015);  // which the response does not hold
  const double response = weak.mean_v[3] - weak.mean_v[0];
  CHECK(response > 0.3);
  check_goes_on(run_with(fmt::format("least_response_v = {}\n", response - 0.03), kSound));
  check_ends_at_the_peak(run_with(fmt::format("least_response_v = {}\n", response + 0.03), kSound), 0);
}

TEST_CASE("run: the array is judged at the first peak only, not later") {
  // At 60 psi a row that was read at 0 psi from then on is dead.
  bench::RunRequest request = small_request();
  request.recipes = {recipe_of(
      "unit = \"psi\"\nturning_points = [0, 60, 0]\nstep = 20\nrepeats = 2\n[limits]\nmost_dead_taxels = 3\n")};
  int steps = 0;
  double begins_s = 0.0;
  bench::Rig* rig = nullptr;
  request.on_rig = [&](bench::Rig& made, bench::RigMoment) { rig = &made; };
  request.on_step = [&](const sequences::Step& step) {
    ++steps;
    if (step.repeat != 1 || step.branch != 0 || begins_s > 0.0) return;
    begins_s = devices::in_seconds(rig->clock().now());
    rig->plant()->inject(bench::FaultKind::kRowStuck, 2.0);
  };
  const FinishedRun run(request);
  const bench::RunResult& result = run.result;
  INFO((result.error ? result.error->what() : ""));
  CHECK(begins_s > 0.0);
  CHECK(run.store.events(1).front().time_ns == 0);
  CHECK(result.outcome == db::Outcome::kCompleted);
  int flagged = 0;
  for (const db::FrameRecord& frame : run.store.frames(1))
    flagged += frame.flags.find("row-stuck") != std::string::npos ? 1 : 0;
  CHECK(flagged >= 3);
}

// The warm-up of a run on the simulated rig: unloaded frames a quarter of a minute apart, until they are calm or the
// time is up.

namespace {

struct WarmedUp {
  std::vector<db::CheckRecord> checks;
  std::int64_t first_frame_ns = 0;
};

WarmedUp warmed_up(const std::string& rule) {
  QuickStore store;
  bench::RunRequest request = small_request();
  request.recipes = {small_recipe(rule)};
  const bench::RunResult result = run_small(request, store);
  REQUIRE(!result.error);
  WarmedUp found;
  found.first_frame_ns = store.frames(result.run).at(0).time_ns;
  for (db::CheckRecord& check : store.checks(result.run))
    if (check.kind == "warm-up") found.checks.push_back(std::move(check));
  return found;
}

nlohmann::json detail_of(const WarmedUp& found) {
  REQUIRE(found.checks.size() == 1);
  return nlohmann::json::parse(found.checks.front().detail_json);
}

// The time that the unloaded frames themselves take is far below a second.
bool about(double seconds, double expected) { return seconds >= expected && seconds < expected + 1.0; }

}  // namespace

TEST_CASE("warm-up: ends after the first 15 s in which the array drifts less than the limit") {
  const WarmedUp found = warmed_up("[warm_up]\ndrift_percent_per_min = 100.0\nat_most_s = 600\n");
  const nlohmann::json detail = detail_of(found);
  CHECK(found.checks.front().verdict == "pass");
  REQUIRE(found.checks.front().data.size() == 1);
  CHECK(found.checks.front().data[0] == detail.at("last_drift_percent_per_min").get<double>());
  CHECK(about(detail.at("took_s").get<double>(), 15.0));
  CHECK(detail.at("limit_percent_per_min") == 100.0);
  CHECK(detail.at("at_most_s") == 600.0);
  CHECK(found.first_frame_ns > 15'000'000'000);
  CHECK(found.first_frame_ns < 45'000'000'000);
}

TEST_CASE(
    "warm-up: an array that keeps drifting is waited for until the timeout, and the run continues with a warning") {
  // A mean of 256 counts stays the same to a millionth of a percent a minute in no two frames.
  const WarmedUp found = warmed_up("[warm_up]\ndrift_percent_per_min = 1e-6\nat_most_s = 50\n");
  const nlohmann::json detail = detail_of(found);
  CHECK(found.checks.front().verdict == "warning");
  CHECK(found.checks.front().data.size() == 4);  // after 15, 30, 45 and 60 s
  CHECK(about(detail.at("took_s").get<double>(), 60.0));
  for (const double drift : found.checks.front().data) {
    CHECK(drift > 0.0);
    CHECK(drift < 1.0);  // % of the converter's range a minute
  }
  CHECK(detail.at("last_drift_percent_per_min").get<double>() == found.checks.front().data.back());
  CHECK(found.first_frame_ns > 60'000'000'000);
}

// Errors that end a run that cannot continue, or that needs something its bench does not have.

namespace {

struct Refused {
  TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
  bench::RunRequest request = small_request();
  void check(const std::string& id, bench::ExitCode code) {
    const bench::RunResult result = run_small(request, store);
    REQUIRE(result.error);
    CHECK(result.error->id() == id);
    CHECK(result.error->code() == code);
    CHECK(result.safe == db::SafeState::kVerified);
    CHECK(result.outcome == db::Outcome::kFailed);
  }
};

}  // namespace

TEST_CASE("run: a file that is not a film state is rejected, a file written by a run is accepted") {
  Refused run;
  run.request.specimen_state_file = run.folder.path("film");
  std::ofstream(run.request.specimen_state_file) << "name = \"film\"\n";
  run.check("TB-SPECIMEN-STATE", bench::ExitCode::kUsage);
  std::filesystem::remove(run.request.specimen_state_file);
  CHECK(run_small(run.request, run.store).outcome == db::Outcome::kCompleted);
  CHECK(run_small(run.request, run.store).outcome == db::Outcome::kCompleted);
}

TEST_CASE("run: a recipe that its bench cannot execute is rejected before a row exists") {
  const auto [what, id] = GENERATE(table<std::string, std::string>(
      {{"stage", "TB-RECIPE-DEVICES"}, {"force", "TB-RECIPE-DEVICES"}, {"command", "TB-RECIPE-LIMIT"}}));
  Refused run;
  run.request.assume_yes = true;
  if (what != "command") run.request.recipes = {recipe_of(press_text(1))};
  if (what == "stage") run.request.bench.stage.reset();
  if (what == "force") run.request.bench.force.reset();
  if (what == "command") run.request.bench.limits.command_psi = 6.0;
  const auto refused = refusal_by([&] { (void)run_small(run.request, run.store); });
  REQUIRE(refused);
  CHECK(refused->id() == id);
  CHECK(run.store.runs().empty());
}

TEST_CASE("run: forces beyond the calibration range of the force sensor are rejected before the stage moves") {
  Refused run;
  run.request = small_request({{"force.overload_share", "0.5"}});
  run.request.recipes = {recipe_of(press_text(1))};
  run.request.assume_yes = true;
  const bench::RunResult result = run_small(run.request, run.store);
  REQUIRE(result.error);
  CHECK(result.error->id() == "TB-PRESS-LIMIT");
  CHECK(result.error->code() == bench::ExitCode::kStopped);
  CHECK_THAT(result.error->what(), Catch::Contains("30 N") && Catch::Contains("17.5 N"));
  CHECK(run.store.frames(result.run).empty());
}
