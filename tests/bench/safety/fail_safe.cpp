// The fail-safe layers of a bench as text; the trip's file; and the dead-man's answers to the nanosecond.
#include "bench/safety/fail_safe.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>

#include "bench/common/process_time.h"
#include "bench/config/config.h"
#include "bench/guard/dead_man_process.h"
#include "bench/guard/dead_man_reports.h"
#include "bench/guard/trip.h"
#include "bench/safety/safe_state.h"
#include "tests/support/process.h"
#include "tests/support/variable.h"

using namespace tactbench;
using namespace tactbench::bench;
using tests::TemporaryFolder;
using tests::Variable;

namespace {

using Lines = std::vector<std::string>;

BenchConfig plain_bench() {
  BenchConfig config;
  config.module.profile.model = "MODEL";
  return config;
}

const char* const kNoWatchdog =
    "WARNING: MODEL has no watchdog that tactbench can set or verify: if the program or the wire dies, the last "
    "set-point may remain. Have a relief valve and an emergency stop.";

}  // namespace

TEST_CASE("fail-safe layers: of a bench that simulates, one on hardware, and one without its dead-man") {
  BenchConfig config = plain_bench();
  config.in_process = true;
  config.limits.trip_psi = 64.0;
  const std::string always = "tactbench: every run ends vented, with proof of it; trip above 64 psi";
  CHECK(fail_safe_layers(config) == Lines{always, kNoWatchdog});
  config.in_process = false;
  config.dead_man.timeout_s = 0.35;
  config.dead_man.progress_s = 1.25;
  const std::string dead_man =
      "dead-man in a process of its own: fires when the program ends, is stopped for 350 ms or makes no progress "
      "for 1250 ms; vents over its own connection";
  CHECK(fail_safe_layers(config) ==
        Lines{always, dead_man + "; if it can no longer reach the module the run ends", kNoWatchdog});
  config.dead_man.blind_ends = false;
  config.stage.emplace();
  config.dead_man.back_off_mm = 4.5;
  CHECK(fail_safe_layers(config)[1] == dead_man +
                                           ", stops the stage and backs z off by 4.5 mm; if it can no longer reach the "
                                           "module the run is warned");
  config.module.endpoint.serial_port = "/dev/ttyS0";
  CHECK(fail_safe_layers(config)[1] == dead_man + ", stops the stage and backs z off by 4.5 mm");
  config.dead_man.enabled = false;
  CHECK(fail_safe_layers(config)[1] ==
        "WARNING: [dead_man] enabled = false: only the module vents when the program dies");
  config.in_process = true;
  CHECK(fail_safe_layers(config).size() == 2);
}

TEST_CASE("fail-safe layers: dump valve, the module's own layers, and its watchdog with how often it is fed") {
  BenchConfig config = plain_bench();
  config.in_process = true;
  config.module.profile.dump_coil = 0;
  config.module.profile.fail_safe.layers = {"first", "second"};
  config.watchdog_s = 1.5;
  config.regulator.feed_interval = std::chrono::milliseconds(350);
  const Lines lines = fail_safe_layers(config);
  REQUIRE(lines.size() == 5);
  CHECK(lines[1] == "dump valve on coil 0: opens with every vent and without power");
  CHECK(lines[2] == "MODEL: first");
  CHECK(lines[3] == "MODEL: second");
  CHECK(lines[4] == "watchdog time 1500 ms, fed every 350 ms");
  config.module.profile.dump_coil = -1;
  config.watchdog_s = 0.0;
  CHECK(fail_safe_layers(config).back() == kNoWatchdog);
  CHECK(fail_safe_layers(config).size() == 4);
}

TEST_CASE("shared lines: neither side keeps a line to itself, and the dead-man takes no lock") {
  BenchConfig config = plain_bench();
  config.input_module.emplace();
  config.reference_gauge.emplace();
  config.environment.resize(2);
  const auto endpoints = [&] {
    return std::vector<devices::ModbusEndpoint*>{&config.module.endpoint, &config.input_module->endpoint,
                                                 &config.reference_gauge->endpoint, &config.environment[0].endpoint,
                                                 &config.environment[1].endpoint};
  };
  for (devices::ModbusEndpoint* endpoint : endpoints()) endpoint->exclusive = endpoint->lock = true;
  share_lines(config, false);
  for (const devices::ModbusEndpoint* endpoint : endpoints()) CHECK((!endpoint->exclusive && endpoint->lock));
  share_lines(config, true);
  for (const devices::ModbusEndpoint* endpoint : endpoints()) CHECK((!endpoint->exclusive && !endpoint->lock));
}

TEST_CASE("trip file: contents, state after a reset, and no partial file remains") {
  const TemporaryFolder folder;
  const Variable state("XDG_STATE_HOME", folder.path());
  const TripFile file("b1");
  CHECK(file.path() == folder.path("tactbench/b1.trip"));
  CHECK(file.log_path() == folder.path("tactbench/b1.log"));
  CHECK(file.dead_man_path() == folder.path("tactbench/b1.dead-man.json"));
  REQUIRE(file.store({"TB-X", "said", 12, "ignored"}));
  const auto json = nlohmann::json::parse(tests::read_file(file.path()));
  CHECK((json["id"] == "TB-X" && json["what"] == "said" && json["run"] == 12 && json["utc"] != "ignored"));
  const auto trip = file.read();
  REQUIRE(trip);
  CHECK((trip->id == "TB-X" && trip->what == "said" && trip->run == 12 && trip->utc == json["utc"].get<std::string>()));
  file.reset(*trip, "P");
  CHECK_FALSE(std::filesystem::exists(file.path()));
  REQUIRE(file.store({"TB-Y", "again", 0, {}}));
  file.reset(*file.read(), "Q");
  const std::string log = tests::read_file(file.log_path());
  CHECK_THAT(log, Catch::Contains(" reset by P: TB-X of ") && Catch::Contains(", run 12: said\n") &&
                      Catch::Contains(" reset by Q: TB-Y of "));
  CHECK(std::count(log.begin(), log.end(), '\n') == 2);
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path("tactbench")))
    files += entry.exists() ? 1 : 0;
  CHECK(files == 1);
  tests::write_file(file.path(), R"({"id":"TB-Z"})");
  CHECK((file.read()->id == "TB-Z" && file.read()->utc == "unknown" && file.read()->run == 0));
  CHECK_THROWS_AS(write_durably(folder.path("no/such/folder"), "x"), std::system_error);
  write_durably(folder.path("text"), "one");
  write_durably(folder.path("text"), "two");
  CHECK(tests::read_file(folder.path("text")) == "two");
}

TEST_CASE("state folder: that of XDG_STATE_HOME, else one in the home folder") {
  const TemporaryFolder folder;
  {
    const Variable given("XDG_STATE_HOME", folder.path("given"));
    CHECK(state_folder("/no/machine") == folder.path("given/tactbench"));
    CHECK(std::filesystem::is_directory(folder.path("given/tactbench")));
  }
  const Variable none("XDG_STATE_HOME", "");
  const Variable home("HOME", folder.path());
  CHECK(state_folder("/no/machine") == folder.path(".local/state/tactbench"));
}

TEST_CASE("dead-man's answers: a nanosecond late is late, and how it is reported") {
  DeadManReports reports(seconds(0.4), true);
  reports.asked(seconds(10.0));
  reports.judge(seconds(10.4));
  CHECK_FALSE(reports.lost());
  reports.judge(seconds(10.4) + devices::Nanoseconds(1));
  REQUIRE(reports.lost());
  CHECK(reports.lost()->what == "the dead-man does not answer: no message from it for 0.40 s, 0.4 s are allowed");
  DeadManReports blind(seconds(0.4), true);
  blind.heard("sees");
  CHECK(blind.take_news().empty());  // it saw before
  blind.heard("blind: a");
  CHECK_FALSE(blind.lost());
  blind.heard("blind: b");
  REQUIRE(blind.lost());
  CHECK(blind.lost()->what == "the dead-man cannot reach the module: b, 2 times in a row");
  blind.ended();
  CHECK(blind.lost()->id == kDeadManBlind);  // the first cause stays
  blind.heard("something else");
  CHECK_FALSE(blind.fired());
}

TEST_CASE("unloaded frame: the mean of all scans of each taxel") {
  devices::ScanSet scans;
  scans.rows = 1;
  scans.columns = 3;
  scans.scans = 2;
  scans.counts = {10, 20, 30, 14, 21, 65535};
  CHECK(baseline_of(scans) == Baseline{12.0, 20.5, 32782.5});
}
