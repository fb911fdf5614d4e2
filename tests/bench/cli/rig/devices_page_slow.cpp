// What `devices check` and `devices watch` print of the simulated rig, whose instruments are known.
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/process.h"

using namespace tactbench::tests;

TEST_CASE("devices watch prints the pressures, places, forces and the array once a look") {
  const TemporaryFolder folder;
  const Finished seen =
      call(folder, {"devices", "watch", "--bench", "simulated.toml", "--count", "2", "--interval", "0.05"});
  CHECK(seen.code == 0);
  for (const char* name : {"\nfeedback  ", "\nreference ", "\nforce     "}) {
    INFO(name << " in " << seen.out);
    const std::size_t first = seen.out.find(name);
    REQUIRE(first != std::string::npos);
    CHECK(seen.out.find(name, first + 1) != std::string::npos);
    // Pressures within 0.2 psi of 0, forces within 0.05 N.
    CHECK(std::abs(std::stod(seen.out.substr(first + 11))) < 0.2);
  }
  const auto told =
      nlohmann::json::parse(call(folder, {"devices", "check", "--bench", "simulated.toml", "--json"}).out);
  CHECK(told["bench"] == "simulated-rig");
  REQUIRE(told["devices"].size() == 6);
  CHECK(told["devices"][1]["role"] == "regulator");
  CHECK(told["devices"][1]["state"] == "ok");
  CHECK(told["devices"][4]["notes"].size() == 1);
}
