// Which instruments a run stores, and what it reports of their calibration before and after: on the simulated rig.
#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <ctime>
#include <nlohmann/json.hpp>

#include "analysis/statistics/uncertainty/instruments.h"
#include "bench/rig/rig.h"
#include "bench/run/run_record.h"
#include "devices/device.h"
#include "tests/bench/run/finished_run.h"
#include "tests/bench/run/quick_store.h"

using namespace tactbench;
using namespace tactbench::tests;
using bench::ExitCode;

namespace {

bench::RunRequest ring_request(const std::vector<sequences::Override>& overrides = {}) {
  bench::RunRequest request = small_request(overrides);
  request.recipes = {sequences::read_recipe(bench::find_recipe("ring"), {{"repeats", "1"}})};
  request.assume_yes = true;
  return request;
}

const db::DeviceRecord& device_of(const db::RunRecord& run, const std::string& role) {
  const auto found = std::ranges::find(run.devices, role, &db::DeviceRecord::role);
  if (found == run.devices.end()) throw std::runtime_error("no " + role + " in the run");
  return *found;
}

std::vector<std::string> warnings_of(const db::RunStore& store, std::int64_t run) {
  std::vector<std::string> lines;
  for (const db::EventRecord& event : store.events(run))
    if (event.kind == "warning" && event.id == "TB-CALIBRATION") lines.push_back(event.detail);
  return lines;
}

std::string day_from_now(int days) {
  const std::time_t then = std::time(nullptr) + days * 86400;
  std::tm utc{};
  gmtime_r(&then, &utc);
  char text[16] = {};
  std::strftime(text, sizeof text, "%Y-%m-%d", &utc);
  return text;
}

}  // namespace

TEST_CASE("traceability: a press run stores force sensor and stage with serial, range, certificate, due date and U") {
  const FinishedRun pressed(
      ring_request({{"force.certificate", "F-1"}, {"force.calibrated", "2025-01-31"}, {"force.due", "2199-01-31"}}));
  if (pressed.result.error) FAIL(pressed.result.error->what());
  const db::RunRecord run = pressed.store.run(1);
  const db::DeviceRecord& force = device_of(run, "force sensor");
  CHECK(force.serial == "SIM-FT-1");  // reported by the simulated sensor; the bench file states none
  CHECK(force.model == "ATI Nano17");
  CHECK(force.firmware == "sim-1");
  CHECK(force.origin == "simulated");
  const auto calibration = nlohmann::json::parse(force.calibration_json);
  CHECK(calibration["calibration"] == "SIM-FT-1");
  CHECK(calibration["range_n"] == nlohmann::json::array({25.0, 25.0, 35.0}));
  CHECK(calibration["range_nmm"] == nlohmann::json::array({250.0, 250.0, 250.0}));
  CHECK(calibration["certificate"] == "F-1");
  CHECK(calibration["calibrated"] == "2025-01-31");
  CHECK(calibration["due"] == "2199-01-31");
  CHECK(calibration["expanded_uncertainty_n"] == 0.05);
  for (const auto& [role, serial, model] :
       {std::tuple("stage x", "SIM-STAGE-X", "Zaber T-LA60A"), std::tuple("stage y", "SIM-STAGE-Y", "Zaber T-LA60A"),
        std::tuple("stage z", "SIM-STAGE-Z", "Zaber T-NA08A50")}) {
    const db::DeviceRecord& axis = device_of(run, role);
    CHECK(axis.serial == serial);
    CHECK(axis.model == model);
    CHECK(axis.firmware == "5.23");
    CHECK(nlohmann::json::parse(axis.calibration_json)["expanded_uncertainty_mm"] == 0.01);
    CHECK(nlohmann::json::parse(axis.calibration_json)["high_mm"].get<double>() > 50.0);
  }
  CHECK(run.devices.size() == 8);
  CHECK(pressed.store.check_content(1).holds());
  CHECK(warnings_of(pressed.store, 1).empty());
}

TEST_CASE("traceability: the stored force sensor is the one that answers, Digital F/T has another serial") {
  bench::RunRequest request = ring_request({{"force.kind", "digital"}});
  request.bench.force->digital.reply_timeout = std::chrono::seconds(5);  // a busy machine reads the port late
  const FinishedRun run(request);
  const bench::RunResult& result = run.result;
  if (result.error) FAIL(result.error->what());
  CHECK(device_of(run.store.run(result.run), "force sensor").serial == "SIMFT2");
}

TEST_CASE("traceability: an instrument with a too long serial number ends the run and is not stored") {
  bench::RunRequest request = small_request({{"scanner.kind", "frame-source"}});
  request.bench.simulation->scanner_serial = std::string(db::kMaxNameLength + 1, '7');
  const FinishedRun run(request);
  const bench::RunResult& result = run.result;
  REQUIRE(result.error);
  CHECK(result.error->id() == "TB-DEVICE-NAME");
  CHECK(result.error->code() == ExitCode::kDevice);
  CHECK_THAT(result.error->what(), Catch::Contains("201"));
  CHECK(result.safe == db::SafeState::kVerified);
  CHECK(run.store.run(result.run).devices.empty());
}

TEST_CASE("traceability: a chamber run does not store instruments that it does not use") {
  const FinishedRun run(small_request({{"force.due", "\"2020-01-31\""}}));
  const bench::RunResult& result = run.result;
  REQUIRE_FALSE(result.error);
  for (const db::DeviceRecord& device : run.store.run(result.run).devices) {
    CHECK(device.role != "force sensor");
    CHECK_FALSE(device.role.starts_with("stage"));
  }
  CHECK(warnings_of(run.store, result.run).empty());  // overdue, and not used
}

TEST_CASE("traceability: an instrument overdue at the start is an event of the run") {
  const FinishedRun run(ring_request({{"force.due", "\"2020-01-31\""}, {"reference.due", "\"2021-01-31\""}}));
  const bench::RunResult& result = run.result;
  if (result.error) FAIL(result.error->what());
  const std::vector<std::string> lines = warnings_of(run.store, result.run);
  REQUIRE(lines.size() == 2);
  CHECK_THAT(lines[0], Catch::Contains("SIM-REF-1") && Catch::Contains("2021-01-31"));
  CHECK_THAT(lines[1], Catch::Contains("SIM-FT-1") && Catch::Contains("2020-01-31"));
}

TEST_CASE("traceability: placeholders in the bench file give a warning if simulated, an error on hardware") {
  QuickStore store;
  bench::RunRequest request = small_request({{"reference.certificate", "FILL-IN"}});
  const bench::RunResult result = run_small(request, store);
  REQUIRE_FALSE(result.error);
  REQUIRE(warnings_of(store, result.run).size() == 1);
  CHECK_THAT(warnings_of(store, result.run)[0], Catch::Contains("reference.certificate"));
  request.bench.origin = devices::Origin::kHardware;
  CHECK_THROWS_AS(run_small(request, store), bench::Error);
  CHECK(store.runs().size() == 1);
  CHECK_THROWS_AS(bench::Rig(request.bench), bench::Error);
}

TEST_CASE("traceability: a resumed press run continues only with its original force sensor") {
  const FinishedRun run(ring_request());
  const bench::RunResult& result = run.result;
  if (result.error) FAIL(result.error->what());
  const db::RunRecord begun = run.store.run(result.run);
  bench::Rig other(ring_request({{"force.serial", "\"FT-7\""}}).bench);
  other.open_array();
  other.name_press_instruments();
  CHECK(other.force() == nullptr);  // as it was
  CHECK_THROWS_AS(bench::check_same_devices(begun, other.devices()), devices::Fault);
  bench::Rig same(ring_request().bench);
  same.open_array();
  same.name_press_instruments();
  CHECK_NOTHROW(bench::check_same_devices(begun, same.devices()));
  // A run of before knew neither.
  db::RunRecord older = begun;
  std::erase_if(older.devices, [](const db::DeviceRecord& device) {
    return device.role == "force sensor" || device.role.starts_with("stage");
  });
  CHECK_NOTHROW(bench::check_same_devices(older, same.devices()));
}

TEST_CASE("calibration warnings: none on the due date, one on the day after") {
  const auto warned_of = [](const std::string& due) {
    QuickStore store;
    bench::RunRequest request = small_request({{"reference.due", "\"" + due + "\""}});
    request.recipes = {recipe_of("unit = \"psi\"\nturning_points = [0, 2]\nstep = 2\n")};
    REQUIRE(run_small(request, store).outcome == db::Outcome::kCompleted);
    return warnings_of(store, 1);
  };
  for (int tries = 0; tries < 2; ++tries) {
    const std::string today = day_from_now(0), yesterday = day_from_now(-1);
    const std::vector<std::string> due = warned_of(today), overdue = warned_of(yesterday);
    if (day_from_now(0) != today) continue;  // midnight has passed
    CHECK(due.empty());
    REQUIRE(overdue.size() == 1);
    CHECK_THAT(overdue[0], Catch::Contains("SIM-REF-1") && Catch::Contains(yesterday));
    return;
  }
}
