// sensors add, list and show, of a sensor with all its words and of one without.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/bench/cli/store_here.h"
#include "tests/support/paths.h"

using namespace tactbench;
using namespace tactbench::tests;
using Told = nlohmann::ordered_json;

namespace {

struct StoreOfSensors : StoreHere {
  StoreOfSensors() {
    db::RunStore store = open();
    store.add_sensor({"S-0", "a-very-long-name-of-a-type-of-32c", "rows = 2\n", "h0", "", "", kUtc});
    store_example(store);  // S-1
    db::RunRecord other = example_run();
    other.sensor_serial = "S-0";
    store_example(store, other);
    store_example(store);
  }
  Finished sensors(std::vector<std::string> words) const {
    words.insert(words.begin(), "sensors");
    return say(bench::add_sensors, words);
  }
};

}  // namespace

TEST_CASE("sensors list and show: as JSON") {
  const StoreOfSensors store;
  const Told told = Told::parse(store.sensors({"list", "--json"}).out);
  CHECK(told.at("schema") == "tactbench.sensors.list");
  REQUIRE(told.at("sensors").size() == 2);
  CHECK(told.at("sensors").at(0).at("serial") == "S-0");
  CHECK(told.at("sensors").at(1).at("scanner") == "SC-7");
  const Told one = Told::parse(store.sensors({"show", "S-1", "--json"}).out);
  CHECK(one.at("schema") == "tactbench.sensors.show");
  CHECK(one.at("serial") == "S-1");
  CHECK(one.at("runs") == Told::array({1, 3}));
  CHECK(one.at("type_toml") == "rows = 3\n");
}

TEST_CASE("sensors show: a sensor that is not registered") {
  check_refusal(StoreOfSensors().sensors({"show", "S-2"}), 2, "TB-SENSOR-UNKNOWN");
}

TEST_CASE("sensors add: the sensor is stored with its type file and when it came") {
  const StoreOfSensors store;
  const std::string type = source_path("bench/config/sensor.toml");
  CHECK(store.sensors({"add", "S-9", "--type", type, "--scanner", "SC-9", "--note", "from lot A7"}).code == 0);
  const db::RunStore open = db::RunStore::open_read_only(store.path);
  const auto sensor = open.sensor("S-9");
  REQUIRE(sensor);
  CHECK(sensor->type_toml == read_file(type));
  CHECK(sensor->type_sha256 == db::sha256_hex(read_file(type)));
  CHECK(sensor->scanner_serial == "SC-9");
  CHECK(sensor->note == "from lot A7");
  CHECK(sensor->added_utc > "2026");
  const Told told = Told::parse(store.sensors({"add", "S-8", "--type", type, "--json"}).out);
  check_members(told, R"({"schema": "tactbench.sensors.add", "serial": "S-8", "scanner": ""})");
  CHECK(store.sensors({"add", "S-7", "--type", store.folder.path("none.toml")}).code == 2);
}
