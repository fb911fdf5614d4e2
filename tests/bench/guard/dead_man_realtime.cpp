// The dead-man's process against a simulated rig in real time. What is asserted has wide margins; the times that were
// measured are printed as FIGURE lines: of the shipped bench with TACTBENCH_SHIPPED_TIMES=1 (generous_timeouts.h).
#include <fmt/format.h>

#include <sys/wait.h>
#include <unistd.h>
#include <catch2/catch.hpp>
#include <csignal>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "bench/guard/trip.h"
#include "bench/rig/rig.h"
#include "bench/safety/ramp.h"
#include "bench/safety/safe_state.h"
#include "devices/device.h"
#include "tests/devices/fault_of.h"
#include "tests/support/child_process.h"
#include "tests/support/hosted_rig.h"
#include "tests/support/paths.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;
using devices::Axis;
using devices::Millimetres;
using devices::MillimetresPerSecond;
using nlohmann::json;

namespace {

using Overrides = std::vector<sequences::Override>;

const double kSafeWithin = 4.0 * roominess();  // seconds; 2 are aimed at with the shipped times

void figure(const std::string& name, double value) { WARN(fmt::format("FIGURE {} {:.2f} s", name, value)); }

// `tactbench run` in a process of its own, dwelling at 60 psi.
std::unique_ptr<ChildProcess> run_to_60_psi(HostedRig& rig) {
  write_file(rig.folder.path("hold.toml"),
             "schema = 1\nname = \"hold\"\nunit = \"psi\"\nturning_points = [50, 60, 50]\nstep = 10\ndwell_s = 4\n");
  const std::string db = rig.folder.path("runs.db");
  REQUIRE(run_program(program_path(), {"sensors", "add", "S-1", "--type", "sensor.toml", "--db", db}, rig.folder.path())
              .code == 0);
  auto child = std::make_unique<ChildProcess>(
      std::vector<std::string>{program_path(), "run", rig.folder.path("hold.toml"), "--no-seating", "--bench",
                               rig.folder.path("bench.toml"), "--sensor", "S-1", "--operator", "t", "-q", "--db", db});
  return child;
}

// 20 N/mm and nothing else, so that a place is a force.
Overrides elastic() {
  Overrides all;
  for (const char* key : {"stiffening_n_per_mm2", "friction_share", "relaxation_share"}) {
    all.push_back({std::string("simulation.contact.") + key, "0"});
  }
  return all;
}

// With 30 N, a fresh reading of which it leaves.
void press(Rig& rig) {
  devices::Stage& stage = *rig.stage_gate();
  stage.arm();
  for (const Axis axis : {Axis::kZ, Axis::kX, Axis::kY}) stage.home(axis);
  devices::ForceSensor& force = rig.open_force();
  (void)force.bias(20);
  (void)force.read(20);
  stage.start_move_to(Axis::kZ, Millimetres(31.5), std::nullopt);
  (void)stage.wait(Axis::kZ);
  (void)force.read(20);
}

// Presses and waits there for good in a process of its own; this one's threads, which simulate the rig, are not in it.
class PressingProcess {
 public:
  explicit PressingProcess(const BenchConfig& config) : child_(fork()) {
    if (child_ != 0) return;
    try {
      Rig rig(config);
      press(rig);
      rig.clock().wait_until(rig.clock().now() + std::chrono::hours(1));
    } catch (const std::exception& error) {
      fmt::print(stderr, "the pressing process: {}\n", error.what());
    }
    _exit(1);
  }
  ~PressingProcess() {
    kill(child_, SIGKILL);
    waitpid(child_, nullptr, 0);
  }
  PressingProcess(const PressingProcess&) = delete;
  PressingProcess& operator=(const PressingProcess&) = delete;
  void signal(int number) const { kill(child_, number); }

 private:
  pid_t child_;
};

json record_of(const BenchConfig& config) {
  const std::string path = TripFile(config.id).dead_man_path();
  (void)HostedRig::seconds_until([&] { return std::filesystem::exists(path); }, kSafeWithin);
  return json::parse(read_file(path));
}

}  // namespace

TEST_CASE("dead-man: after the sequencer is killed or stopped at 60 psi the chamber is vented") {
  const int signal = GENERATE(SIGKILL, SIGSTOP);
  HostedRig rig;
  const BenchConfig config = rig.client();
  const auto run = run_to_60_psi(rig);
  REQUIRE(HostedRig::seconds_until([&] { return rig.psi() > 59.5; }, 40.0) < 40.0);
  run->signal(signal);
  const double safe = HostedRig::seconds_until([&] { return rig.psi() < 1.0; }, kSafeWithin);
  figure(signal == SIGKILL ? "safe_after_kill_at_60_psi" : "safe_after_stop_at_60_psi", safe);
  CHECK(safe < kSafeWithin);
  const json record = record_of(config);
  CHECK(record["ended"] == "safe, verified");
  if (signal == SIGKILL) {
    CHECK(run->wait() == -SIGKILL);
    CHECK_FALSE(TripFile(config.id).read());  // gone, and proved safe: the record is enough
    return;
  }
  REQUIRE(TripFile(config.id).read());
  CHECK(TripFile(config.id).read()->id == "TB-DEADMAN-FIRED");
  run->signal(SIGCONT);  // it wakes up, believes in 60 psi, and must not go back there
  double highest = 0.0;
  (void)HostedRig::seconds_until(
      [&] {
        highest = std::max(highest, rig.psi());
        return false;
      },
      1.5);
  CHECK(highest < 1.0);
  CHECK(run->wait() == 4);
  const Finished again = run_program(program_path(),
                                     {"run", rig.folder.path("hold.toml"), "--bench", rig.folder.path("bench.toml"),
                                      "--sensor", "S-1", "--operator", "t", "-q", "--db", rig.folder.path("runs.db")},
                                     rig.folder.path());
  CHECK(again.code == 4);
  CHECK_THAT(again.err, Catch::Contains("TB-BENCH-TRIPPED"));
}

TEST_CASE("dead-man: after the sequencer is killed or stopped while pressing with 30 N the stage is backed off") {
  const int signal = GENERATE(SIGKILL, SIGSTOP);
  HostedRig hosted(elastic());
  const BenchConfig config = hosted.client();
  const PressingProcess pressing(config);
  REQUIRE(HostedRig::seconds_until([&] { return hosted.force_n() > 29.9; }, 40.0) < 40.0);
  pressing.signal(signal);
  const double safe = HostedRig::seconds_until([&] { return hosted.force_n() < 0.5; }, kSafeWithin);
  figure(signal == SIGKILL ? "safe_after_kill_at_30_N" : "safe_after_stop_at_30_N", safe);
  CHECK(safe < kSafeWithin);
  const json record = record_of(config);
  INFO(record.dump());
  CHECK(record["ended"] == "safe, verified");
  CHECK(TripFile(config.id).read().has_value() == (signal == SIGSTOP));
}

TEST_CASE("dead-man: a pressing stage is halted and backed off when feeding ends") {
  HostedRig hosted(elastic());
  Rig rig(hosted.client());
  press(rig);
  CHECK(hosted.force_n() == Approx(30.0).margin(0.5));
  devices::Stage& stage = *rig.stage_gate();
  stage.start_speed(Axis::kZ, MillimetresPerSecond(0.02));  // still going deeper when the sequencer falls silent
  const double safe = HostedRig::seconds_until([&] { return hosted.force_n() < 0.5; }, kSafeWithin);
  figure("stage_safe_after_feeding_ends_at_30_N", safe);
  CHECK(safe < kSafeWithin);
  const json record = record_of(rig.config());
  INFO(record.dump());
  CHECK(record["ended"] == "safe, verified");
  CHECK(devices::fault_id_of([&] { stage.start_move_to(Axis::kZ, Millimetres(1.0), std::nullopt); }) ==
        "TB-DEADMAN-FIRED");
  CHECK(stage.halt());  // the dead-man has left the line
  CHECK(hosted.force_n() < 0.5);
  CHECK(TripFile(rig.config().id).read());
}

TEST_CASE("dead-man: vents at once when commanded to fire, and no later command passes") {
  HostedRig hosted;
  Rig rig(hosted.client());
  rig.open();
  (void)ramp_to(rig, devices::Psi(20.0));
  const double soon = 0.4 * roominess();  // before the module's watchdog
  REQUIRE(HostedRig::seconds_until([&] { return hosted.psi() > 15.0; }, soon) < soon);
  std::thread([&] { rig.dead_man()->fire(); }).join();
  CHECK(devices::fault_id_of([&] { (void)rig.source().command(devices::Psi(19.0)); }) == "TB-DEADMAN-FIRED");
  CHECK(HostedRig::seconds_until([&] { return hosted.psi() < 1.0; }, kSafeWithin) < kSafeWithin);
  CHECK(record_of(rig.config())["why"] == "commanded");
  CHECK_THROWS(rig.source().arm());
  CHECK(devices::fault_id_of([&] { (void)rig.source().command(devices::Psi(0.0)); }) == "TB-DEADMAN-FIRED");
}

TEST_CASE("dead-man: a rig that says goodbye is left alone, a rig that disconnects without it is made safe") {
  const bool goodbye = GENERATE(true, false);
  HostedRig hosted;
  const BenchConfig config = hosted.client();
  {
    Rig rig(config);
    rig.open();
    (void)ramp_to(rig, devices::Psi(10.0));
    CHECK_FALSE(rig.dead_man()->fired());
    CHECK_FALSE(rig.dead_man()->lost());
    if (goodbye) {
      rig.dismiss_dead_man();
      CHECK(rig.dead_man()->wait_ended(std::chrono::seconds(5)));
      CHECK_FALSE(std::filesystem::exists(TripFile(config.id).dead_man_path()));
      CHECK(hosted.psi() > 5.0);
      return;
    }
  }
  const json record = record_of(config);
  CHECK(record["ended"] == "safe, verified");
  CHECK(record["tripped"] == false);
  CHECK(hosted.psi() < 1.0);
}

TEST_CASE("dead-man: reaches a serial module whose line the sequencer still holds") {
  const TemporaryFolder folder;  // a profile that speaks RTU and has a watchdog, as the bench file sets one
  std::string profile = read_file(share_folder() + "/devices/profiles/beckhoff-ek9000.toml");
  const std::size_t transport = profile.find("\"tcp\"");
  REQUIRE(transport != std::string::npos);
  write_file(folder.path("rtu.toml"), profile.replace(transport, 5, "\"any\""));
  HostedRig hosted(Overrides{{"module.transport", "rtu"}, {"module.profile", '"' + folder.path("rtu.toml") + '"'}},
                   {"host", "port"});
  Rig rig(hosted.client());
  rig.open();
  (void)ramp_to(rig, devices::Psi(10.0));
  rig.dead_man()->fire();
  CHECK(HostedRig::seconds_until([&] { return hosted.psi() < 1.0; }, kSafeWithin) < kSafeWithin);
  CHECK(record_of(rig.config())["ended"] == "safe, verified");
}

TEST_CASE("dead-man: vents a serial pressure controller whose line a killed or stopped sequencer still holds") {
  const int signal = GENERATE(SIGKILL, SIGSTOP);
  HostedRig hosted({}, {}, "simulated-serial.toml");
  const BenchConfig config = hosted.client();
  const auto run = run_to_60_psi(hosted);
  REQUIRE(HostedRig::seconds_until([&] { return hosted.psi() > 59.5; }, 40.0) < 40.0);
  run->signal(signal);
  const double safe = HostedRig::seconds_until([&] { return hosted.psi() < 1.0; }, kSafeWithin);
  figure(signal == SIGKILL ? "serial_safe_after_kill_at_60_psi" : "serial_safe_after_stop_at_60_psi", safe);
  CHECK(safe < kSafeWithin);
  CHECK(record_of(config)["ended"] == "safe, verified");
  run->signal(SIGCONT);
  CHECK(run->wait() == (signal == SIGKILL ? -SIGKILL : 4));
  CHECK(hosted.psi() < 1.0);
}

TEST_CASE("dead-man: a module that does not respond is reported before the dead-man is started") {
  HostedRig hosted;
  BenchConfig config = hosted.client();
  config.module.endpoint.port = 1;
  Rig rig(config);
  devices::check_fault([&] { rig.open(); }, "TB-MODBUS-CONNECT", "", "127.0.0.1:1");
  CHECK(rig.dead_man() == nullptr);
}
