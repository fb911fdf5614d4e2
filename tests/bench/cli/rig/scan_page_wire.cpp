// What devices scan says of this machine, whatever it finds.
#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;

TEST_CASE("devices scan: two lines for each device, the same as JSON, and a word on hosts that nobody named") {
  const TemporaryFolder folder;
  const Finished found = call(folder, {"devices", "scan"});
  CHECK(found.code == 0);
  CHECK_THAT(found.out, Catch::EndsWith("Modbus hosts are queried only when given: --modbus HOST[:PORT]\n"));
  const auto told = nlohmann::json::parse(call(folder, {"devices", "scan", "--json"}).out);
  CHECK(told.at("schema") == "tactbench.devices.scan");
  CHECK(told.at("devices").is_array());
  // Nothing listens on this port, and the answer says so.
  const Finished host = call(folder, {"devices", "scan", "--modbus", "127.0.0.1:1"});
  CHECK_THAT(host.out, Catch::Contains("Modbus TCP   127.0.0.1:1\n               connecting to ") &&
                           !Catch::Contains("queried only when given"));
  const auto one = nlohmann::json::parse(call(folder, {"devices", "scan", "--modbus", "127.0.0.1:1", "--json"}).out);
  CHECK(std::ranges::any_of(one.at("devices"), [](const nlohmann::json& device) {
    return device.at("kind") == "Modbus TCP" && device.at("where") == "127.0.0.1:1" &&
           device.at("what").get<std::string>().starts_with("connecting to ");
  }));
}
