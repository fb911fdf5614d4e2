// The dead-man's process against a simulated rig in real time. What is asserted has wide margins; the times that were
// measured are printed as FIGURE lines: of the shipped bench with TACTBENCH_SHIPPED_TIMES=1 (generous_timeouts.h).

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>

#include "bench/guard/trip.h"
#include "bench/rig/rig.h"
#include "bench/run/control/control_socket.h"
#include "bench/safety/ramp.h"
#include "bench/safety/safe_state.h"
#include "db/run_store.h"
#include "devices/device.h"
#include "tests/devices/fault_of.h"
#include "tests/support/child_process.h"
#include "tests/support/hosted_rig.h"
#include "tests/support/module_proxy.h"
#include "tests/support/paths.h"
#include "tests/support/served_rig.h"

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

const std::string kTo60Psi = "[50, 60, 50]\nstep = 10\ndwell_s = 4\n";

void figure(const std::string& name, double value) { WARN(fmt::format("FIGURE {} {:.2f} s", name, value)); }

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
  const auto run = rig.begin_run(kTo60Psi);
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

TEST_CASE("dead-man: reaches a serial module while the sequencer still holds its line") {
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

TEST_CASE("dead-man: vents a serial pressure controller while a killed or stopped sequencer still holds its line") {
  const int signal = GENERATE(SIGKILL, SIGSTOP);
  HostedRig hosted({}, {}, "simulated-serial.toml");
  const BenchConfig config = hosted.client();
  const auto run = hosted.begin_run(kTo60Psi);
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

// The dead-man's own process fails while a run is under pressure: frozen, ended, or cut off from the module. The run's
// program notices, says what it is, and ends vented; nothing fires that should not.

namespace {

constexpr double kWatchedRate = 10.0, kWatchedPatience = 60.0;
const double kTimeout = 0.4 * roominess();  // s, of the dead-man

struct Watched : ServedRig {
  Watched() : ServedRig(kWatchedRate) {
    write_file(folder.path("long.toml"),
               "schema = 1\nname = \"long\"\nunit = \"psi\"\nturning_points = [0, 12, 4]\nstep = 4\nrepeats = 20\n"
               "dwell_s = 40\n[dwell]\ntolerance_s = 5\n[conditioning]\ncycles = 1\npeak = 12\n");
    module_port = bench::read_bench(folder.path("bench.toml"), {}).module.endpoint.port;
  }
  // Under pressure when it returns.
  void start_long(const std::vector<std::string>& more = {}) {
    std::vector<std::string> words = {"run", "long.toml",  "--bench", "bench.toml",  "--sensor",
                                      "S-1", "--operator", "t",       "--no-seating"};
    words.insert(words.end(), more.begin(), more.end());
    program = start(words);
    if (!wait_for([&] { return psi() > 3.0 && !store().branches(1).empty(); })) FAIL(log());
  }
  static bool wait_for(const std::function<bool()>& done) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(kWatchedPatience);
    for (bool so = false; !so; usleep(5000)) {
      try {
        so = done();
      } catch (const std::exception&) {  // the store is being made
      }
      if (std::chrono::steady_clock::now() > end) return false;
    }
    return true;
  }
  // A child of the run's program.
  [[nodiscard]] pid_t dead_man() const {
    for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
      const std::string name = entry.path().filename();
      if (name.find_first_not_of("0123456789") != std::string::npos) continue;
      std::ifstream status(entry.path() / "stat");
      std::string line;
      std::getline(status, line);
      const std::size_t end = line.rfind(')');
      if (end == std::string::npos) continue;
      char state = 0;
      pid_t parent = 0;
      std::istringstream(line.substr(end + 1)) >> state >> parent;
      if (parent == program->pid() && state != 'Z') return std::stoi(name);
    }
    FAIL("the run has no dead-man");
    return -1;
  }
  [[nodiscard]] db::RunStore store() const { return db::RunStore::open_read_only(folder.path("runs.db")); }
  [[nodiscard]] int events(const std::string& kind, const std::string& id) const {
    const auto all = store().events(1);
    return static_cast<int>(
        std::count_if(all.begin(), all.end(), [&](const auto& one) { return one.kind == kind && one.id == id; }));
  }
  [[nodiscard]] bool fired() const { return std::filesystem::exists(bench::TripFile(bench_id).dead_man_path()); }
  // The run ends by that fault, vented, without a trip, and the dead-man has done nothing.
  void check_ended_by(const std::string& id) {
    CHECK(program->wait() == 4);
    INFO(log());
    CHECK_THAT(log(), Catch::Contains("[" + id + "]"));
    const db::RunRecord row = store().run(1);
    CHECK(row.outcome == db::Outcome::kAborted);
    CHECK(row.safe_state == db::SafeState::kVerified);
    CHECK_THAT(row.reason, Catch::StartsWith(id));
    CHECK(psi() < 1.0);
    CHECK_FALSE(fired());
    CHECK_FALSE(bench::TripFile(bench_id).read());
  }
  // By a word; the exit code.
  int stop() {
    CHECK(run({"stop"}).code == 0);
    return program->wait();
  }
  // The bench is free, and works.
  void check_next_run() {
    write_file(folder.path("next.toml"),
               "schema = 1\nname = \"next\"\nunit = \"psi\"\nturning_points = [0, 4, 0]\nstep = 4\ndwell_s = 1\n"
               "[dwell]\ntolerance_s = 5\n");
    CHECK(start_run("next.toml")->wait() == 0);
    INFO(log());
    CHECK(store().run(2).outcome == db::Outcome::kCompleted);
  }
  std::unique_ptr<ChildProcess> program;
  int module_port = 0;
};

// An operator who reads the gauge for `devices calibrate-reference`, and says nothing.
struct AtTheGauge : Watched {
  AtTheGauge() {
    if (mkfifo(folder.path("keyboard").c_str(), 0600) != 0) FAIL("no pipe");
    keyboard = open(folder.path("keyboard").c_str(), O_RDWR | O_CLOEXEC);  // so it never ends
  }
  // Vented, asked for the first reading when it returns.
  void start_calibration(const std::string& more = {}) {
    program = std::make_unique<ChildProcess>(std::vector<std::string>{
        "/bin/sh", "-c",
        fmt::format("cd '{}' && exec '{}' devices calibrate-reference --bench bench.toml --gauge g --uncertainty 0.05 "
                    "--levels 0,20 {} <keyboard >>log 2>&1",
                    folder.path(), program_path(), more)});
    if (!wait_for([&] { return log().find("Hand gauge reads") != std::string::npos; })) FAIL(log());
  }
  ~AtTheGauge() { close(keyboard); }
  AtTheGauge(const AtTheGauge&) = delete;
  AtTheGauge& operator=(const AtTheGauge&) = delete;
  void type(const std::string& text) const {
    CHECK(write(keyboard, text.c_str(), text.size()) == static_cast<ssize_t>(text.size()));
  }
  int keyboard = -1;
};

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

TEST_CASE("dead-man watched: a frozen one ends the run with its own error, and the bench is free again") {
  Watched rig;
  rig.start_long();
  const auto frozen = std::chrono::steady_clock::now();
  stop_process(rig.dead_man());
  REQUIRE(Watched::wait_for([&] { return rig.psi() < 1.0; }));
  const double vented_s = seconds_since(frozen);
  WARN(fmt::format("FIGURE vented_after_dead_man_froze {:.2f} s, its time {:g} s", vented_s, kTimeout));
  CHECK(vented_s < 5.0 * kTimeout + 2.0);
  rig.check_ended_by("TB-DEADMAN-SILENT");
  rig.check_next_run();
}

TEST_CASE("dead-man watched: one that was stopped for less than its timeout continues, and nothing fires") {
  Watched rig;
  rig.start_long();
  const pid_t dead_man = rig.dead_man();
  for (int i = 0; i < 3; ++i) {
    stop_process(dead_man);
    usleep(static_cast<useconds_t>(0.2 * kTimeout * 1e6));
    kill(dead_man, SIGCONT);
    usleep(static_cast<useconds_t>(0.5 * kTimeout * 1e6));
  }
  usleep(static_cast<useconds_t>(2.0 * kTimeout * 1e6));
  CHECK_FALSE(rig.program->ended_within(std::chrono::milliseconds(0)));
  CHECK(rig.stop() == 4);
  INFO(rig.log());
  CHECK_THAT(rig.log(), Catch::Contains("[TB-RUN-STOPPED]") && !Catch::Contains("TB-DEADMAN"));
  CHECK_FALSE(rig.fired());
}

TEST_CASE("dead-man watched: one that is frozen until its run has ended does nothing afterwards") {
  Watched rig;
  rig.start_long();
  const pid_t dead_man = rig.dead_man();
  stop_process(dead_man);
  REQUIRE(Watched::wait_for([&] { return rig.psi() < 2.0; }));  // the run is on its way out
  kill(dead_man, SIGCONT);
  rig.check_ended_by("TB-DEADMAN-SILENT");
  usleep(500000);
  CHECK_FALSE(rig.fired());
}

TEST_CASE("dead-man watched: a killed dead-man is immediately reported as ended") {
  Watched rig;
  rig.start_long();
  const auto killed = std::chrono::steady_clock::now();
  kill(rig.dead_man(), SIGKILL);
  REQUIRE(Watched::wait_for([&] { return rig.psi() < 1.0; }));
  CHECK(seconds_since(killed) < 5.0);
  rig.check_ended_by("TB-DEADMAN-ENDED");
}

TEST_CASE("dead-man watched: one that no longer reaches the module is reported, and ends the run") {
  Watched rig;
  ModuleProxy proxy(rig.module_port);
  rig.start_long({"--set", fmt::format("module.port={}", proxy.port())});
  const auto blind = std::chrono::steady_clock::now();
  proxy.cut_off(true);
  REQUIRE(Watched::wait_for([&] { return rig.psi() < 1.0; }));
  CHECK(seconds_since(blind) < 5.0 * (2.0 * kTimeout + 1.0));
  rig.check_ended_by("TB-DEADMAN-BLIND");
  CHECK(rig.events("dead-man", "TB-DEADMAN-BLIND") == 1);
}

TEST_CASE("dead-man watched: with blind = warn a blind one is reported and the run continues") {
  Watched rig;
  ModuleProxy proxy(rig.module_port);
  rig.start_long({"--set", fmt::format("module.port={}", proxy.port()), "--set", "dead_man.blind=\"warn\""});
  proxy.cut_off(true);
  CHECK(Watched::wait_for([&] { return rig.events("dead-man", "TB-DEADMAN-BLIND") == 1; }));
  usleep(static_cast<useconds_t>(4.0 * kTimeout * 1e6));  // more than two looks
  proxy.cut_off(false);
  CHECK(Watched::wait_for([&] { return rig.events("dead-man", "") == 1; }));
  CHECK_FALSE(rig.program->ended_within(std::chrono::milliseconds(0)));
  CHECK(rig.events("dead-man", "TB-DEADMAN-BLIND") == 1);
  CHECK(rig.stop() == 4);
}

TEST_CASE("dead-man watched: if only it still reaches the module, its action and its proof are stored with the run") {
  Watched rig;
  ModuleProxy proxy(rig.module_port);
  rig.start_long({"--set", fmt::format("module.port={}", proxy.port())});
  proxy.cut_writers_off();
  CHECK(rig.program->wait() == 7);
  INFO(rig.log());
  const db::RunStore store = rig.store();
  CHECK(store.run(1).safe_state == db::SafeState::kUnverified);  // by the sequencer itself
  const auto events = store.events(1);
  const auto word = std::ranges::find(events, std::string("dead-man"), &db::EventRecord::kind);
  REQUIRE(word != events.end());
  CHECK_THAT(word->detail, Catch::Contains("verified") && !Catch::Contains("NOT verified"));
  CHECK(rig.psi() < 1.0);
  CHECK(rig.fired());
  CHECK_FALSE(bench::TripFile(rig.bench_id).read());  // proved safe: no person is needed
}

TEST_CASE("dead-man watched: calibrate-reference ends when it is lost while the operator reads the gauge") {
  const bool killed = GENERATE(true, false);
  AtTheGauge rig;
  rig.start_calibration();
  if (killed) kill(rig.dead_man(), SIGKILL);
  if (!killed) stop_process(rig.dead_man());
  CHECK(rig.program->wait() == 4);
  INFO(rig.log());
  CHECK_THAT(rig.log(), Catch::Contains(killed ? "[TB-DEADMAN-ENDED]" : "[TB-DEADMAN-SILENT]"));
  CHECK_THAT(rig.log(), Catch::Contains("vented, verified"));
  CHECK_FALSE(rig.fired());
  CHECK_FALSE(bench::TripFile(rig.bench_id).read());
}

TEST_CASE(
    "dead-man watched: calibrate-reference reports at once that it lost the module, and that it reaches it again") {
  AtTheGauge rig;
  ModuleProxy proxy(rig.module_port);
  rig.start_calibration(fmt::format("--set module.port={} --set dead_man.blind=warn", proxy.port()));
  const std::string warning = "[TB-DEADMAN-BLIND]";
  proxy.cut_off(true);
  CHECK(Watched::wait_for([&] { return rig.log().find(warning) != std::string::npos; }));
  proxy.cut_off(false);
  CHECK(Watched::wait_for([&] {  // told of the dead-man since
    const std::string log = rig.log();
    return log.rfind("dead-man") > log.rfind(warning);
  }));
  CHECK_FALSE(rig.program->ended_within(std::chrono::milliseconds(0)));
  rig.type("q\n");
  CHECK(rig.program->wait() == 4);
  INFO(rig.log());
  CHECK_THAT(rig.log(), Catch::Contains("TB-CALIBRATION-STOPPED") && Catch::Contains("vented, verified"));
}
