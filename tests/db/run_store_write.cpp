// Writing a run: what is refused before it reaches the file, and what two programs at one store leave of it.
#include <catch2/catch.hpp>
#include <filesystem>

#include "db/sqlite.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::RunStore;
using db::sqlite::Access;
using db::sqlite::Connection;

TEST_CASE("a branch that is void takes no frame, the next attempt does") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  const Begun begun = begin_example(store);
  REQUIRE(begun.run == 1);
  store.append_frame(begun.run, example_frame(begun.branch, 0));
  store.void_branch(begun.branch, "scanner lost");
  CHECK(store_error([&] { store.append_frame(begun.run, example_frame(begun.branch, 1)); }) == "TB-STORE-CONFLICT");
  CHECK(store.frame_count(begun.run) == 1);
  const std::int64_t other_run = store.begin_run(example_run());
  CHECK(store_error([&] { store.append_frame(other_run, example_frame(begun.branch, 1)); }) == "TB-STORE-CONFLICT");
}

TEST_CASE("names of a run and of a sensor each have a maximum length") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  const std::string longest(db::kLongestName, 'n'), longer = longest + 'n';
  for (std::string db::SensorRecord::*member :
       {&db::SensorRecord::serial, &db::SensorRecord::type, &db::SensorRecord::scanner_serial}) {
    db::SensorRecord sensor = example_sensor();
    sensor.serial = "S-" + std::to_string(store.sensors().size());
    sensor.*member = longer;
    CHECK(store_error([&] { store.add_sensor(sensor); }) == "TB-STORE-TOO-LONG");
    sensor.*member = longest;
    CHECK(store_error([&] { store.add_sensor(sensor); }).empty());
  }
  CHECK(store.sensors().size() == 3);
  store.add_sensor(example_sensor());
  for (std::string db::RunRecord::*member :
       {&db::RunRecord::operator_name, &db::RunRecord::scanner_serial, &db::RunRecord::bench_id}) {
    db::RunRecord run = example_run();
    run.*member = longer;
    CHECK(store_error([&] { store.begin_run(run); }) == "TB-STORE-TOO-LONG");
    run.*member = longest;
    CHECK(store_error([&] { store.begin_run(run); }).empty());
  }
  CHECK(store.runs().size() == 3);
}

TEST_CASE("a sensor is registered once, and again only as another") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  store.add_sensor(example_sensor());
  store.add_sensor(example_sensor());
  db::SensorRecord second = example_sensor();
  second.serial = "A-2";
  second.scanner_serial = "SC-9";
  second.note = "other";
  store.add_sensor(second);
  const auto sensors = store.sensors();
  REQUIRE(sensors.size() == 2);
  CHECK((sensors[0].serial == "A-2" && sensors[0].scanner_serial == "SC-9" && sensors[0].note == "other"));
  CHECK((sensors[1].type == "array-3x2" && sensors[1].type_toml == "rows = 3\n" && sensors[1].added_utc != ""));
  CHECK(sensors[1].type_sha256 == example_sensor().type_sha256);
  CHECK_FALSE(store.sensor("none"));
  db::SensorRecord other_type = example_sensor();
  other_type.type_sha256 = "other";
  CHECK(store_error([&] { store.add_sensor(other_type); }) == "TB-STORE-CONFLICT");
}

TEST_CASE("devices are replaced as a whole until the first frame") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  const Begun begun = begin_example(store);
  store.set_devices(begun.run, {{"stage", "Z-1", "7", "6.0", "simulated", "{}"}});
  store.set_devices(begun.run, {{"b", "", "", "", "", ""}, {"a", "", "", "", "", ""}});
  const auto devices = store.run(begun.run).devices;
  REQUIRE(devices.size() == 2);
  CHECK((devices[0].role == "b" && devices[1].role == "a"));
  store.append_frame(begun.run, example_frame(begun.branch, 0));
  CHECK(store_error([&] { store.set_devices(begun.run, {}); }) == "TB-STORE-CONFLICT");
  CHECK(store.run(begun.run).devices.size() == 2);
  store.end_run(begun.run, db::Outcome::kCompleted, "", db::SafeState::kVerified, kUtc);
  CHECK(store.check_content(begun.run).holds());
}

TEST_CASE("devices of a run that another program ended are not replaced") {
  const TemporaryFolder folder;
  RunStore own = RunStore::open(folder.path("runs.db")), other = RunStore::open(folder.path("runs.db"));
  own.add_sensor(example_sensor());
  const std::int64_t run = own.begin_run(example_run());
  own.set_seen(run, kUtc);  // it is known here as open
  REQUIRE(other.mark_interrupted(kUtc) == 1);
  CHECK(store_error([&] { own.set_devices(run, {}); }) == "TB-STORE-CONFLICT");
  CHECK(other.run(run).devices.size() == 2);
  CHECK(other.check_content(run).holds());
}

TEST_CASE("a run that two programs wrote in turn is closed as it stands in the file") {
  const TemporaryFolder folder;
  RunStore one = RunStore::open(folder.path("runs.db")), two = RunStore::open(folder.path("runs.db"));
  const Begun begun = begin_example(one);
  one.append_frame(begun.run, example_frame(begun.branch, 0));  // it knows of one frame
  two.append_frame(begun.run, example_frame(begun.branch, 1));
  REQUIRE(one.mark_interrupted(kUtc) == 1);
  CHECK(one.check_content(begun.run).holds());
  CHECK(one.check_content(begun.run).frames == 2);
  // The other goes on with it, and then the first again.
  two.reopen_run(begun.run, {9, "state", "", "resumed"});
  two.append_frame(begun.run, example_frame(begun.branch, 2));
  one.append_frame(begun.run, example_frame(begun.branch, 3));
  one.end_run(begun.run, db::Outcome::kStopped, "", db::SafeState::kVerified, kUtc);
  CHECK(one.check_content(begun.run).holds());
  CHECK(one.frame_count(begun.run) == 4);
}

TEST_CASE("a resumed run continues after its last frame, whichever process wrote it") {
  const TemporaryFolder folder;
  RunStore one = RunStore::open(folder.path("runs.db")), two = RunStore::open(folder.path("runs.db"));
  const Begun begun = begin_example(one);
  one.append_frame(begun.run, example_frame(begun.branch, 0));
  two.append_frame(begun.run, example_frame(begun.branch, 1));
  REQUIRE(two.mark_interrupted(kUtc) == 1);
  one.reopen_run(begun.run, {9, "state", "", "resumed"});
  one.append_frame(begun.run, example_frame(begun.branch, 2));
  one.end_run(begun.run, db::Outcome::kCompleted, "", db::SafeState::kVerified, kUtc);
  CHECK(one.check_content(begun.run).holds());
  CHECK(one.frame_count(begun.run) == 3);
}

TEST_CASE("a log of exactly a thousand pages is long enough, and one that is a byte shorter is not") {
  // A write-ahead log is a header of 32 bytes, then 24 bytes and a page for each page that it holds.
  for (const std::uintmax_t length : {1000 * (4096 + 24) + 32 - 1, 1000 * (4096 + 24) + 32}) {
    const TemporaryFolder folder;
    const std::string log = folder.path("runs.db-wal");
    RunStore store = RunStore::open(folder.path("runs.db"), db::Durability::kFull);
    store.add_sensor(example_sensor());
    std::filesystem::resize_file(log, length);
    store.begin_run(example_run());
    CHECK((std::filesystem::file_size(log) == length) == (length == 1000 * (4096 + 24) + 32));
  }
}
