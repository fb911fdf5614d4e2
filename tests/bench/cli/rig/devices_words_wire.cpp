// devices check and reset: dates of calibration on their very day, values that nobody filled in, and who resets.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/common/utc.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;

TEST_CASE("devices check: a calibration is good on the day when it is due, and overdue on the next") {
  const TemporaryFolder folder;
  const auto page_of = [&](const std::string& due) {
    return call(folder, {"devices", "check", "--bench", "simulated.toml", "--set", "reference.due=" + due}).out;
  };
  const auto today = [] { return bench::utc_now().substr(0, 10); };
  std::string day, page;
  do {  // a day of UTC may turn meanwhile
    day = today();
    page = page_of(day);
  } while (day != today());
  CHECK_THAT(page, Catch::Contains(", due " + day + ", U 0.05 psi (k = 2)\n") && !Catch::Contains("OVERDUE"));
  CHECK_THAT(page_of(bench::utc_days_ago(1).substr(0, 10)), Catch::Contains("OVERDUE since "));
}

TEST_CASE("devices check: what was not filled in is warned of, and the page begins with the bench") {
  const TemporaryFolder folder;
  const Finished checked = call(folder, {"devices", "check", "--bench", "simulated.toml", "--set",
                                         "reference.certificate=\"FILL-IN\"", "--units", "kPa"});
  CHECK_THAT(checked.err, Catch::StartsWith("warning: not filled in: ") && Catch::Contains("reference.certificate"));
  CHECK_THAT(checked.out, Catch::StartsWith("bench 'simulated-rig' (/") &&
                              Catch::Contains(" U 0.34 kPa (k = 2); certificate: the bench file is not filled in\n") &&
                              Catch::Contains("trip above 455.1 kPa\n"));
  const Finished told =
      call(folder, {"devices", "check", "--bench", "simulated.toml", "--json", "--set", "reference.span_psi=[5, 105]"});
  CHECK(told.code == 3);
  const auto document = nlohmann::ordered_json::parse(told.out);
  CHECK(document.at("schema") == "tactbench.devices.check");
  const auto& reference = document.at("devices").at(2);
  CHECK(reference.at("role") == "pressure reference");
  CHECK(reference.at("state") == "wrong");
  CHECK_THAT(reference.at("found").get<std::string>(), Catch::StartsWith("simulated transducer, 100 psi"));
  CHECK_FALSE(reference.at("reading").get<std::string>().empty());
  CHECK_FALSE(reference.at("notes").empty());
  CHECK_THAT(reference.at("remedy").get<std::string>(), Catch::StartsWith("vent the chamber; "));
}

TEST_CASE("devices reset: a person is named") {
  const TemporaryFolder folder;
  const Finished nobody = call(folder, {"devices", "reset", "--bench", "simulated.toml", "--operator", " "});
  CHECK(nobody.code == 2);
  CHECK(
      nobody.err ==
      "error: --operator is empty [TB-USAGE]\n  at: --operator\n  try: give a name: it is recorded\n  state: no device "
      "was touched\n");
}
