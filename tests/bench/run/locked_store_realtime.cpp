// Another program that has locked the store while a run measures, in real time: what the chamber does meanwhile (the
// plant's truth), what is measured and kept, and who is named. Without a waiting run each lock beyond 5 s ended it.

#include <fmt/format.h>
#include <catch2/catch.hpp>

#include <algorithm>
#include <memory>
#include <string>
#include <thread>
#include <tuple>
#include <vector>

#include "bench/guard/trip.h"
#include "db/run_store.h"
#include "tests/bench/run/quick_store.h"
#include "tests/support/child_process.h"
#include "tests/support/hosted_rig.h"
#include "tests/support/in_terminal.h"
#include "tests/support/live_runs.h"
#include "tests/support/process.h"
#include "tests/support/run_recipe.h"
#include "tests/support/small_run.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

// A process that holds the store's write lock for so long; made when the lock is held.
class OtherWriter {
 public:
  OtherWriter(const std::string& store, double seconds)
      : child_({"/usr/bin/python3", "-c",
                fmt::format("import sqlite3, time\n"
                            "c = sqlite3.connect('{}', timeout=60, isolation_level=None)\n"
                            "c.execute('BEGIN IMMEDIATE'); print('locked', flush=True)\n"
                            "time.sleep({}); c.execute('ROLLBACK')",
                            store, seconds)}) {
    REQUIRE(child_.line() == "locked");
  }
  [[nodiscard]] bool holds() { return !child_.ended_within(std::chrono::milliseconds(0)); }
  [[nodiscard]] std::string name() const { return fmt::format("python3 (pid {})", child_.pid()); }

 private:
  ChildProcess child_;
};

bool is_reported(const db::RunStore& store, const std::string& kind, const std::string& name) {
  return std::ranges::any_of(store.events(1), [&](const db::EventRecord& event) {
    return event.kind == kind && event.detail.find(name) != std::string::npos;
  });
}

// At the level of 30 psi of a run on a rig in real time.
struct HeldRun {
  explicit HeldRun(const char* watchdog_ms)
      : rig(std::vector<sequences::Override>{{"module.watchdog_ms", watchdog_ms}}) {
    REQUIRE(HostedRig::seconds_until([&] { return rig.psi() > 25.0; }, 60.0) < 60.0);
  }
  HostedRig rig;
  const std::string db = rig.folder.path("runs.db");
  std::unique_ptr<ChildProcess> run = rig.begin_run("[20, 30, 20]\nstep = 10\ndwell_s = 0.5\n");
};

}  // namespace

TEST_CASE("locked store: during a short lock the pressure is held and the module fed, and nothing is repeated") {
  HeldRun held("2000");
  double lowest = 100.0;
  std::string name;
  {
    OtherWriter other(held.db, 4.0);
    name = other.name();
    while (other.holds()) lowest = std::min(lowest, held.rig.psi());
  }
  CHECK(lowest > 19.0);
  CHECK(held.run->wait() == 0);
  const db::RunStore store = db::RunStore::open_read_only(held.db);
  CHECK(store.run(1).outcome == db::Outcome::kCompleted);
  CHECK(store.frame_count(1) == 3);
  CHECK(store.void_frame_count(1) == 0);
  CHECK(is_reported(store, "warning", name));
}

TEST_CASE("locked store: a lock while the devices are stored does not starve the dead-man") {
  HostedRig rig(std::vector<sequences::Override>{{"dead_man.progress_ms", "2500"}});
  db::RunStore store = db::RunStore::open(rig.folder.path("runs.db"), db::Durability::kNormal);
  bench::RunRequest request = small_request();
  request.bench = rig.client();
  request.recipes = {recipe_of("unit = \"psi\"\nturning_points = [0, 8]\nstep = 8\ndwell_s = 0.2\n")};
  std::unique_ptr<OtherWriter> other;
  request.on_rig = [&](bench::Rig&, bench::RigMoment moment) {
    if (moment == bench::RigMoment::kOpened) other = std::make_unique<OtherWriter>(store.path(), 4.0);
  };
  const bench::RunResult result = run_small(request, store);
  INFO((result.error ? result.error->id() : "none"));
  CHECK_FALSE(result.error);
  CHECK(store.frame_count(1) == 2);
  CHECK_FALSE(bench::TripFile(request.bench.id).read());
}

TEST_CASE("locked store: a longer lock is waited for vented, then the branch is repeated and nothing is lost") {
  HeldRun held("5000");
  std::string name;
  {
    OtherWriter other(held.db, 16.0);
    name = other.name();
    CHECK(HostedRig::seconds_until([&] { return held.rig.psi() < 1.0; }, 14.0) < 14.0);
    double highest = 0.0;
    while (other.holds()) highest = std::max(highest, held.rig.psi());
    CHECK(highest < 1.0);
  }
  CHECK(held.run->wait() == 0);
  const db::RunStore store = db::RunStore::open_read_only(held.db);
  CHECK(store.run(1).outcome == db::Outcome::kCompleted);
  CHECK(store.run(1).safe_state == db::SafeState::kVerified);
  CHECK(store.void_frame_count(1) > 0);  // the frame in hand was kept
  CHECK(store.frame_count(1) - store.void_frame_count(1) == 3);
  CHECK(store.check_content(1).holds());
  CHECK(is_reported(store, "state", name));
}

TEST_CASE("locked store: in virtual time a short lock changes no frame, and a lock at the end changes no outcome") {
  using Measured = std::vector<std::tuple<std::int64_t, double, std::vector<std::uint16_t>>>;
  const auto measured = [](bool locked) {
    QuickStore store;
    std::unique_ptr<OtherWriter> other;
    bench::RunRequest request = small_request();
    int steps = 0;
    request.on_step = [&](const sequences::Step&) {
      if (locked && ++steps == 20) other = std::make_unique<OtherWriter>(store.path(), 2.0);
    };
    request.on_rig = [&](bench::Rig&, bench::RigMoment moment) {
      if (locked && moment == bench::RigMoment::kTearingDown) other = std::make_unique<OtherWriter>(store.path(), 6.0);
    };
    const bench::RunResult result = run_small(request, store);
    CHECK_FALSE(result.error);
    CHECK(store.run(1).outcome == db::Outcome::kCompleted);
    CHECK(store.run(1).content_sha256 == store.content_hash(1));
    CHECK(store.void_frame_count(1) == 0);
    if (locked) CHECK(is_reported(store, "warning", other->name().substr(0, 7)));
    Measured all;
    for (const db::FrameRecord& frame : store.frames(1))
      all.emplace_back(frame.time_ns, frame.reference_psi, frame.counts);
    return all;
  };
  CHECK(measured(true) == measured(false));
}

TEST_CASE("locked store: a stop ends a run that waits for the store, vented, and the next start closes its row") {
  QuickStore store;
  std::unique_ptr<OtherWriter> other;
  bench::RunRequest request = small_request();
  int steps = 0, steps_while_locked = 0;
  std::unique_ptr<std::thread> person;
  request.on_step = [&](const sequences::Step&) {
    steps_while_locked += other ? 1 : 0;
    if (++steps != 20) return;
    other = std::make_unique<OtherWriter>(store.path(), 60.0);
    person = std::make_unique<std::thread>([] {
      for (auto live = live_runs(); !live.empty(); live = live_runs()) {
        if (live.front().status.state == bench::RunState::kSuspended)
          (void)bench::send_command(live.front().name, bench::Command::kStop);
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
      }
    });
  };
  const bench::RunResult result = run_small(request, store);
  person->join();
  REQUIRE(result.error);
  CHECK(result.error->id() == "TB-RUN-STOPPED");
  CHECK(result.safe == db::SafeState::kVerified);
  CHECK(steps_while_locked <= 1);
  const std::int64_t kept = store.frame_count(1);
  other.reset();
  CHECK(store.mark_interrupted(bench::utc_now()) == 1);
  request.resume = 1;
  request.on_step = {};
  const bench::RunResult resumed = run_small(request, store);
  CHECK_FALSE(resumed.error);
  CHECK(store.frame_count(1) >= kept);
  CHECK(store.check_content(1).holds());
}

// A run that asks the person at its terminal.

TEST_CASE("prompt: the question of a recipe is asked at the terminal, and Enter answers it") {
  const TemporaryFolder folder;
  write_file(folder.path("asked.toml"),
             "schema = 1\nname = \"asked\"\nunit = \"psi\"\nturning_points = [0, 8, 0]\nstep = 4\n[prompt]\nbefore = "
             "\"mount the sensor\"\n");
  init_bench(folder);
  InTerminal run(folder.path(),
                 {"run", "asked.toml", "--bench", "bench.toml", "--set", "bench.id=\"asked\"", "--sensor", "S-1",
                  "--operator", "A. Smith", "--no-seating"},
                 100, 40);
  REQUIRE(run.shows("tactbench resume 1"));
  run.type("\n");
  CHECK(run.wait() == 0);
  CHECK_THAT(run.shown(), Catch::Contains("mount the sensor"));
  const db::RunStore store = db::RunStore::open_read_only(folder.path("runs.db"));
  std::vector<std::string> states;
  for (const db::EventRecord& event : store.events(1)) {
    if (event.kind == "state") states.push_back(event.detail.substr(0, event.detail.find(':')));
  }
  CHECK(states == std::vector<std::string>{"prepared -> running", "running -> pausing", "pausing -> paused",
                                           "paused -> running", "running -> stopping"});
}
