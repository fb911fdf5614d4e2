// devices check, watch, reset and scan: dates of calibration on their very day, values that nobody filled in, what an
// instrument reads, and who resets.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/common/utc.h"
#include "tests/bench/cli/check_refusal.h"

using namespace tactbench;
using namespace tactbench::tests;

TEST_CASE("devices check: a calibration is good on the day when it is due, and overdue on the next") {
  const TemporaryFolder folder;
  const auto page_of = [&](const std::string& due) {
    return call(folder, {"devices", "check", "--bench", "simulated.toml", "--set", "reference.due=" + due}).out;
  };
  const auto today = [] { return bench::utc_now().substr(0, 10); };
  const auto overdue = [&](const std::string& due) { return page_of(due).find("OVERDUE") != std::string::npos; };
  std::string day;
  bool late = false;
  do {  // a day of UTC may turn meanwhile
    day = today();
    late = overdue(day);
  } while (day != today());
  CHECK_FALSE(late);
  CHECK(overdue(bench::utc_days_ago(1).substr(0, 10)));
}

TEST_CASE("devices check: what was not filled in is warned of, and an instrument that is wrong told") {
  const TemporaryFolder folder;
  const Finished checked =
      call(folder, {"devices", "check", "--bench", "simulated.toml", "--set", "reference.certificate=\"FILL-IN\""});
  CHECK_THAT(checked.err, Catch::Contains("reference.certificate"));
  const auto document =
      nlohmann::ordered_json::parse(well(call(folder, {"devices", "check", "--bench", "simulated.toml", "--json",
                                                       "--set", "reference.span_psi=[5, 105]"}),
                                         3)
                                        .out);
  CHECK(document.at("schema") == "tactbench.devices.check");
  const auto& reference = document.at("devices").at(2);
  CHECK(reference.at("role") == "pressure reference");
  CHECK(reference.at("state") == "wrong");
  CHECK_FALSE(reference.at("reading").get<std::string>().empty());
  CHECK_FALSE(reference.at("notes").empty());
}

TEST_CASE("devices reset: a person is named") {
  const TemporaryFolder folder;
  check_refusal(call(folder, {"devices", "reset", "--bench", "simulated.toml", "--operator", " "}), 2, "TB-USAGE",
                "--operator");
}

TEST_CASE("live prints the pressures, places, forces and the array once a look") {
  const TemporaryFolder folder;
  const Finished seen = call(folder, {"live", "--bench", "simulated.toml", "--frames", "2", "--interval", "0.05"});
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
