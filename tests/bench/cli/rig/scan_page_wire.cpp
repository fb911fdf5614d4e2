// What devices scan says of this machine, whatever it finds.
#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;

TEST_CASE("devices scan: its devices as JSON, and a host that does not answer") {
  const TemporaryFolder folder;
  CHECK(call(folder, {"devices", "scan"}).code == 0);
  const auto told = nlohmann::json::parse(call(folder, {"devices", "scan", "--json"}).out);
  CHECK(told.at("schema") == "tactbench.devices.scan");
  CHECK(told.at("devices").is_array());
  // Nothing listens on this port, and the answer says so.
  const auto one = nlohmann::json::parse(call(folder, {"devices", "scan", "--modbus", "127.0.0.1:1", "--json"}).out);
  CHECK(std::ranges::any_of(one.at("devices"), [](const nlohmann::json& device) {
    return device.at("kind") == "Modbus TCP" && device.at("where") == "127.0.0.1:1";
  }));
}
