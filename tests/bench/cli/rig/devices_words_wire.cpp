// devices check and reset: dates of calibration on their very day, values that nobody filled in, and who resets.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/common/utc.h"
#include "tests/bench/cli/check_refusal.h"
#include "tests/support/process.h"

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
