// The row of a run: what of the request is stored, which devices a continued run must find again, what can be read back
// of an old one.
#include "bench/run/run_record.h"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "bench/common/build_info.h"
#include "bench/common/error.h"
#include "bench/common/utc.h"
#include "db/run_store.h"
#include "devices/device.h"
#include "tests/bench/run/quick_store.h"
#include "tests/db/store_example.h"
#include "tests/devices/fault_of.h"
#include "tests/support/small_run.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;

namespace {

struct KeptRow {
  QuickStore store;
  KeptRow() { store.add_sensor(example_sensor()); }
};

db::DeviceRecord device(const std::string& role, const std::string& model, const std::string& serial) {
  return {role, model, serial, "1", "simulated", "{}"};
}

std::string kept_fault_id(const std::function<void()>& act) {
  const auto fault = devices::fault_of(act);
  if (!fault) return "";
  CHECK_FALSE(as_error(std::make_exception_ptr(*fault)).remedy().empty());
  return fault->id();
}

}  // namespace

TEST_CASE("run record: every member of the request is stored") {
  RunRequest request = small_request({{"simulation.seed", "7"}}, {11, 12});
  request.overrides.push_back({"recipe.note", "a \"b\""});
  request.recipes.push_back(recipe_of("unit = \"psi\"\nturning_points = [0, 4]\nstep = 4\nrepeats = 3\n"));
  request.purpose = "why";
  request.operator_name = "who";
  const db::RunRecord row = record_of(request);
  CHECK(row.uuid.size() == 36);
  CHECK(row.state == "prepared");
  CHECK(row.origin == "simulated");
  CHECK(row.operator_name == "who");
  CHECK(row.purpose == "why");
  CHECK(row.sensor_serial == "S-1");
  CHECK(row.scanner_serial == "SIM-SCANNER-1");
  CHECK(row.bench_id == "simulated-rig");
  CHECK(row.bench_toml == request.bench.text);
  CHECK(row.bench_sha256 == db::sha256_hex(request.bench.text));
  CHECK(row.sensor_toml == request.sensor_type.text);
  CHECK(row.sensor_sha256 == db::sha256_hex(request.sensor_type.text));
  CHECK(row.overrides_json == R"([{"key":"simulation.seed","value":"7"},{"key":"recipe.note","value":"a \"b\""}])");
  CHECK(row.seed == 11);
  CHECK(row.sensor_seed == 12);
  CHECK(row.program_version == build_info().version);
  CHECK(row.git_commit == build_info().commit);
  CHECK(row.git_dirty == build_info().modified);
  CHECK(row.build_id == build_info().build);
  CHECK_FALSE(row.host.empty());
  CHECK_FALSE(row.time_zone.empty());
  CHECK(row.started_utc.size() == 20);
  REQUIRE(row.sequences.size() == 2);
  CHECK((row.sequences[0].sequence == 0 && row.sequences[1].sequence == 1));
  CHECK((row.sequences[0].repeats == 2 && row.sequences[1].repeats == 3));
  CHECK((row.sequences[0].frames_per_repeat == 15 && row.sequences[1].frames_per_repeat == 2));
  CHECK(row.sequences[1].name == "small");
  CHECK(row.sequences[1].recipe_toml == request.recipes[1].text);
  CHECK(row.sequences[1].recipe_sha256 == db::sha256_hex(request.recipes[1].text));
  request.bench.origin = devices::Origin::kHardware;
  request.bench.simulation.reset();
  CHECK(record_of(request).origin == "hardware");
  CHECK((record_of(request).seed == 0 && record_of(request).sensor_seed == 0));
}

TEST_CASE("run record: stored overrides are read back, invalid text gives none") {
  const auto read = stored_overrides(R"([{"key":"a.b","value":"1"},{"key":"c","value":""}])");
  REQUIRE(read);
  REQUIRE(read->size() == 2);
  CHECK(((*read)[0].key == "a.b" && (*read)[0].value == "1" && (*read)[1].key == "c" && (*read)[1].value.empty()));
  CHECK(stored_overrides("[]").value().empty());
  for (const char* strange : {"", "{}", "7", R"([{"key":"a"}])", R"([{"value":"a"}])", R"([{"key":1,"value":"a"}])",
                              R"([{"key":"a","value":1}])", "[7]"}) {
    INFO(strange);
    CHECK_FALSE(stored_overrides(strange));
  }
}

TEST_CASE("run record: a stored bench is read with its overrides, without those of recipes") {
  RunRequest request = small_request({{"limits.trip_psi", "64"}});
  request.overrides.push_back({"recipe.dwell_s", "9"});
  db::RunRecord row = record_of(request);
  row.run = 5;
  REQUIRE(stored_bench(row));
  CHECK(stored_bench(row)->limits.trip_psi == 64.0);
  CHECK_THAT(stored_bench(row)->file, Catch::EndsWith(" 5"));
  row.overrides_json = "{";
  CHECK_FALSE(stored_bench(row));
  row.overrides_json = R"([{"key":"no.such.key","value":"1"}])";
  CHECK_FALSE(stored_bench(row));
  row.overrides_json = "[]";
  row.bench_toml = "schema = 99\n";
  CHECK_FALSE(stored_bench(row));
}

TEST_CASE("run record: a sensor with another number of taxels than the scanner is rejected") {
  RunRequest request = small_request();
  CHECK_NOTHROW(check_geometry(request));
  const auto refused = [&](int rows, int columns) {
    request.sensor_type.rows = rows;
    request.sensor_type.columns = columns;
    try {
      check_geometry(request);
    } catch (const Error& error) {
      CHECK(error.code() == ExitCode::kUsage);
      CHECK_FALSE(error.remedy().empty());
      CHECK_THAT(error.what(), Catch::Contains(fmt::format("{} x {}", rows, columns)) && Catch::Contains("16 x 16"));
      return error.id();
    }
    return std::string("none");
  };
  CHECK(refused(16, 8) == "TB-SENSOR-GEOMETRY");
  CHECK(refused(8, 16) == "TB-SENSOR-GEOMETRY");
  CHECK(refused(16, 16) == "none");
}

TEST_CASE("run record: devices are stored once, and a continued run must find each of them again") {
  KeptRow row;
  db::RunRecord run = example_run();
  run.devices.clear();
  const std::int64_t number = row.store.begin_run(run);
  const std::vector<db::DeviceRecord> begun = {device("regulator", "R", "1"), device("scanner", "S", "2")};
  keep_devices(row.store, number, begun);
  REQUIRE(row.store.run(number).devices.size() == 2);
  CHECK(row.store.run(number).devices[1].serial == "2");
  CHECK(kept_fault_id([&] {
          keep_devices(row.store, number, {begun[1], begun[0], device("stage", "Z", "3")});
        }).empty());
  CHECK(row.store.run(number).devices.size() == 2);
  const auto missing = [&](const db::DeviceRecord& in_place) {
    return kept_fault_id([&] { keep_devices(row.store, number, {begun[0], in_place}); });
  };
  CHECK(missing(device("scanner", "S", "3")) == "TB-RESUME-DEVICES");
  CHECK(missing(device("scanner", "T", "2")) == "TB-RESUME-DEVICES");
  CHECK(missing(device("array", "S", "2")) == "TB-RESUME-DEVICES");
  CHECK(missing({"scanner", "S", "2", "6", "hardware", "{1}"}).empty());  // firmware and calibration may be others
  CHECK(missing(begun[1]).empty());
}

TEST_CASE("run record: a device that reports an invalid name is rejected") {
  KeptRow row;
  db::RunRecord run = example_run();
  run.devices.clear();
  const std::int64_t number = row.store.begin_run(run);
  const auto kept = [&](const std::string& model) {
    return kept_fault_id([&] { keep_devices(row.store, number, {device("scanner", model, "1")}); });
  };
  CHECK(kept(std::string(100'000, 'x')) == "TB-DEVICE-NAME");
  CHECK(kept("a\xff") == "TB-DEVICE-NAME");
}

TEST_CASE("run record: the rest of a sensor starts at the last sign of activity of its newest earlier run") {
  KeptRow row;
  db::SensorRecord other = example_sensor();
  other.serial = "S-2";
  row.store.add_sensor(other);
  const auto seconds_ago = [](int seconds) {
    const std::time_t then = std::time(nullptr) - seconds;
    std::tm utc{};
    gmtime_r(&then, &utc);
    char text[32] = {};
    std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
    return std::string(text);
  };
  const auto add = [&](const std::string& serial, int started, int seen, int ended) {
    db::RunRecord run = example_run();
    run.uuid.clear();
    run.sensor_serial = serial;
    run.started_utc = seconds_ago(started);
    const std::int64_t number = row.store.begin_run(run);
    if (seen > 0) row.store.set_seen(number, seconds_ago(seen));
    if (ended > 0) row.store.end_run(number, db::Outcome::kCompleted, "", db::SafeState::kVerified, seconds_ago(ended));
    return number;
  };
  const std::int64_t first = add("S-1", 9000, 8000, 7000);
  CHECK_FALSE(rest_of_sensor(row.store, "S-1", first));
  const std::int64_t others = add("S-2", 300, 200, 100);
  CHECK(rest_of_sensor(row.store, "S-1", others + 1).value() == Approx(7000.0).margin(30.0));
  const std::int64_t second = add("S-1", 5000, 4000, 0);
  CHECK(rest_of_sensor(row.store, "S-1", second).value() == Approx(7000.0).margin(30.0));
  CHECK(rest_of_sensor(row.store, "S-1", second + 1).value() == Approx(4000.0).margin(30.0));
  (void)add("S-1", 3000, 0, 0);
  CHECK(rest_of_sensor(row.store, "S-1", second + 9).value() == Approx(3000.0).margin(30.0));
  CHECK_FALSE(rest_of_sensor(row.store, "S-3", second + 9));
}
