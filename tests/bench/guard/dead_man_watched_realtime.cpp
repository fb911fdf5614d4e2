// The dead-man's own process fails while a run is under pressure: frozen, ended, or cut off from the module. The run's
// program notices, says what it is, and ends vented; nothing fires that should not.
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "bench/guard/trip.h"
#include "bench/run/control/control_socket.h"
#include "db/run_store.h"
#include "tests/support/module_proxy.h"
#include "tests/support/paths.h"
#include "tests/support/served_rig.h"

using namespace tactbench;
using namespace tactbench::tests;

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
