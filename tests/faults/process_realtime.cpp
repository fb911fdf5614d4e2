// Sequencers in a process of their own, ended or stopped from outside, on a rig that outlives them, in real time.
#include <fmt/format.h>
#include <catch2/catch.hpp>
#include <csignal>
#include <set>
#include <tuple>

#include "tests/faults/faulty_run.h"
#include "tests/support/child_process.h"
#include "tests/support/hosted_rig.h"
#include "tests/support/paths.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

const double kPatience_s = 4.0 * roominess();  // 2 are aimed at with the shipped times
constexpr int kFrames = 5;

class OwnProcess {
 public:
  explicit OwnProcess(const std::vector<sequences::Override>& overrides = {}) : rig_(overrides) {
    write_file(rig_.folder.path("up.toml"),
               "schema = 1\nname = \"up\"\nunit = \"psi\"\nturning_points = [0, 60, 0]\nstep = 30\ndwell_s = 1\n"
               "[guard]\ntolerance_psi = 2\n");
    REQUIRE(call({"sensors", "add", "S-1", "--type", "sensor.toml", "--db", db()}).code == 0);
    child_ = std::make_unique<ChildProcess>(
        std::vector<std::string>{program_path(), "run", rig_.folder.path("up.toml"), "--bench", bench(), "--sensor",
                                 "S-1", "--operator", "t", "-q", "--no-seating", "--db", db()});
  }
  Finished call(const std::vector<std::string>& words) {
    return run_program(program_path(), words, rig_.folder.path());
  }
  [[nodiscard]] std::string db() const { return rig_.folder.path("runs.db"); }
  [[nodiscard]] std::string bench() const { return rig_.folder.path("bench.toml"); }
  void await_psi(double psi) {
    REQUIRE(HostedRig::seconds_until([&] { return rig_.psi() > psi; }, 60.0) < 60.0);
  }
  void check_vented() {
    CHECK(HostedRig::seconds_until([&] { return rig_.psi() < 1.0; }, kPatience_s) < kPatience_s);
  }
  ChildProcess& child() { return *child_; }
  // Once the fault is gone: the run is completed, each frame there once. How it had ended, for the cell.
  std::string resumed() {
    const Finished again = call({"resume", "1", "--bench", bench(), "-q", "--db", db()});
    INFO(again.err);
    CHECK(again.code == 0);
    const db::RunStore store = db::RunStore::open_read_only(db());
    CHECK(store.run(1).outcome == db::Outcome::kCompleted);
    CHECK(store.run(1).content_sha256 == store.content_hash(1));
    std::set<std::int64_t> standing;
    for (const db::BranchRecord& branch : store.branches(1)) {
      if (!branch.is_void) standing.insert(branch.branch);
    }
    std::set<int> ordinals;
    int frames = 0;
    for (const db::FrameRecord& frame : store.frames(1)) {
      if (standing.count(frame.branch) == 0) continue;
      ++frames;
      ordinals.insert(frame.ordinal);
    }
    CHECK(frames == kFrames);
    CHECK(ordinals.size() == kFrames);
    return again.code == 0 ? "resumed" : "NOT resumed";
  }

 private:
  HostedRig rig_;
  std::unique_ptr<ChildProcess> child_;
};

constexpr double kPoints[] = {30.0, 59.5};

}  // namespace

TEST_CASE("separate process: after SIGKILL the chamber is vented, and the run can be resumed") {
  std::vector<std::string> cells;
  for (const double psi : kPoints) {
    OwnProcess own;
    own.await_psi(psi);
    own.child().signal(SIGKILL);
    own.check_vented();
    CHECK(own.child().wait() == -SIGKILL);
    cells.push_back(fmt::format("interrupted, vented by the dead-man, {}", own.resumed()));
  }
  check_row("process", "SIGKILL", cells);
}

TEST_CASE("separate process: SIGSTOP vents the chamber, SIGCONT aborts the run, and it can be resumed after a reset") {
  std::vector<std::string> cells;
  for (const double psi : kPoints) {
    OwnProcess own;
    own.await_psi(psi);
    own.child().signal(SIGSTOP);
    own.check_vented();
    own.child().signal(SIGCONT);
    CHECK(own.child().wait() == 4);
    CHECK(db::RunStore::open_read_only(own.db()).run(1).outcome == db::Outcome::kAborted);
    CHECK(own.call({"resume", "1", "--bench", own.bench(), "-q", "--db", own.db()}).code == 4);  // tripped
    CHECK(own.call({"devices", "reset", "--bench", own.bench(), "--operator", "t"}).code == 0);
    cells.push_back(fmt::format("aborted 4 DEADMAN-FIRED, vented by the dead-man, {}", own.resumed()));
  }
  check_row("process", "SIGSTOP, then SIGCONT", cells);
}

// What a steady clock sees of a machine that stood still, or of a wall clock that was set: time has gone by. 0.3 s
// where the watchers have the shipped times, in proportion where they have more.
TEST_CASE("separate process: a pause of 0.3 s does not prevent the run from completing") {
  std::vector<std::string> cells;
  for (const double psi : kPoints) {
    OwnProcess own(std::vector<sequences::Override>{{"dead_man.timeout_ms", "5000"}});  // more than 3 jumps
    own.await_psi(psi);
    own.child().signal(SIGSTOP);
    usleep(static_cast<useconds_t>(300000 * roominess()));
    own.child().signal(SIGCONT);
    CHECK(own.child().wait() == 0);
    CHECK(db::RunStore::open_read_only(own.db()).frame_count(1) >= kFrames);
    cells.emplace_back("completed 0, verified");
  }
  check_row("process", "time jumps by 0.3 s", cells);
}
