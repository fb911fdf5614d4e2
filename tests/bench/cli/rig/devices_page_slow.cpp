// What `devices check` and `devices watch` print of the simulated rig, whose instruments are known.
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/process.h"

using namespace tactbench::tests;

namespace {

const std::string kIndent(27, ' ');

void check_printed(const Finished& finished, const std::vector<std::string>& lines) {
  INFO(finished.out << finished.err);
  for (const std::string& line : lines) {
    INFO(line);
    CHECK(("\n" + finished.out).find("\n" + line + "\n") != std::string::npos);
  }
}

}  // namespace

TEST_CASE("devices check prints each instrument with its state, readings and notes") {
  const TemporaryFolder folder;
  const Finished well = call(folder, {"devices", "check", "--bench", "simulated.toml"});
  CHECK(well.code == 0);
  CHECK_THAT(well.out, Catch::StartsWith("bench 'simulated-rig' (/"));
  check_printed(
      well, {"ok      analog module      Beckhoff EK9000 + EL4xxx/EL3xxx (simulated)", kIndent + "outputs 0 counts",
             kIndent + "- tactbench: every run ends vented, with proof of it; trip above 66 psi",
             kIndent + "- watchdog time 1000 ms, fed every 450 ms",
             "ok      regulator          Pneumax 171E2N.T.D.0009, serial SIM-REG-1 (simulated)",
             "ok      pressure reference simulated transducer, 100 psi, serial SIM-REF-1 (simulated)",
             kIndent + "- certificate SIM-CERT-1 (invented for the simulation), no due date stated, U 0.05 psi (k = 2)",
             "ok      tactile scanner    tactbench HID scanner, serial SIM-SCANNER-1, firmware sim-1 (simulated)",
             "ok      stage              x: id 60, firmware 5.23; y: id 60, firmware 5.23; z: id 5082, firmware 5.23 "
             "(simulated)",
             kIndent + "x 0 microsteps, 15.0 V; y 0 microsteps, 15.0 V; z 0 microsteps, 15.0 V",
             "ok      force sensor       ATI Nano17, serial SIM-FT-1, firmware sim-1 (simulated), calibration SIM-FT-1",
             kIndent + "- range +-25 25 35 N, +-250 250 250 N mm"});
  CHECK_THAT(well.out, Catch::Contains(kIndent + "16 x 16 taxels, mean 0.02"));  // each taxel's zero is near 20 mV
  const Finished wrong = call(folder, {"devices", "check", "--bench", "simulated.toml", "--set",
                                       "reference.span_psi=[5, 105]", "--set", "reference.due=2001-01-31"});
  CHECK(wrong.code == 3);
  CHECK_THAT(wrong.out, Catch::Contains("\nwrong   pressure reference ") && Catch::Contains("- not at zero: ") &&
                            Catch::Contains("OVERDUE since 2001-01-31") &&
                            Catch::Contains("\n" + kIndent + "to do: vent the chamber; "));
}

TEST_CASE("devices watch prints the pressures, places, forces and the array once a look") {
  const TemporaryFolder folder;
  const Finished seen =
      call(folder, {"devices", "watch", "--bench", "simulated.toml", "--count", "2", "--interval", "0.05"});
  CHECK(seen.code == 0);
  check_printed(seen, {"time       0.00 s", "time       0.05 s", "stage      x 0.0000 mm, y 0.0000 mm, z 0.0000 mm"});
  CHECK_THAT(seen.out, Catch::Contains("\narray      mean 0.02") && Catch::Contains(" V, status 0x00\n"));
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
