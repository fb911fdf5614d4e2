// Commands to a run on a bench that is simulated in its own process: sent from a step's own callback, so that each
// arrives at a known place of the recipe, through the real socket.
#include <unistd.h>

#include <catch2/catch.hpp>

#include "bench/rig/rig.h"
#include "bench/run/control/control_client.h"
#include "bench/run/control/peer.h"
#include "bench/simulation/plant.h"
#include "devices/wire/modbus/modbus_link.h"
#include "tests/bench/run/kill_record.h"
#include "tests/bench/run/quick_store.h"
#include "tests/support/live_runs.h"
#include "tests/support/small_run.h"

using namespace tactbench;
using namespace tactbench::tests;
using bench::Command;
using bench::ExitCode;

namespace {

bench::LiveRun the_live_run() {
  const std::vector<bench::LiveRun> live = live_runs();
  REQUIRE(live.size() == 1);
  return live.front();
}

bench::LiveRun say(Command command) {
  const auto answer = bench::send_command(the_live_run().name, command);
  REQUIRE(answer);
  return *answer;
}

struct Words {
  // `act` is told of the `at`-th step.
  bench::RunResult run(int at, const std::function<void()>& act) {
    bench::RunRequest request = small_request({{"module.watchdog_ms", "60000"}});  // never what is met
    int seen = 0;
    request.on_step = [&](const sequences::Step&) {
      if (seen++ == at) act();
    };
    request.on_rig = [&](bench::Rig& made, bench::RigMoment moment) {
      rig = &made;
      if (moment == bench::RigMoment::kTearingDown && on_way_out) on_way_out();
    };
    return run_small(request, store);
  }
  // Of run 1, "kind id", those that tell why it ended.
  [[nodiscard]] std::vector<std::string> reasons() const {
    std::vector<std::string> reasons;
    for (const db::EventRecord& event : store.events(1)) {
      if (event.kind == "fault" || event.kind == "word" || event.kind == "attempt") {
        reasons.push_back(event.kind + " " + event.id);
      }
    }
    return reasons;
  }
  QuickStore store;
  bench::Rig* rig = nullptr;  // while a run lives
  std::function<void()> on_way_out;
};

constexpr int kMidway = 15;  // a step under pressure
using Reasons = std::vector<std::string>;

// What the sequencer's next command meets, before it looks at words again.
struct Met {
  std::string id;
  std::function<void(bench::Rig&)> make;
};
const Met kFiredDeadMan{"TB-DEADMAN-FIRED",
                        [](bench::Rig& rig) { rig.guard().trip(bench::kDeadManFired, "a panic was commanded"); }};
const Met kTripped{"TB-GUARD-TRIPPED", [](bench::Rig& rig) { rig.guard().trip("TB-CHAMBER-TRIP", "66 psi"); }};
// As the dead-man's vent, which lands between our writing and reading back: the output stands at zero.
const Met kZeroed{"TB-MODULE-READBACK", [](bench::Rig& rig) {
                    devices::ModbusLink other(rig.config().module.endpoint, "another master", rig.clock());
                    const std::uint16_t zero = 0;
                    other.write_registers(rig.config().module.profile.outputs.address, std::span(&zero, 1));
                    rig.clock().wait_until(rig.clock().now() + std::chrono::milliseconds(600));  // a look is due
                  }};
const Met kRefused{"TB-MODBUS-EXCEPTION",
                   [](bench::Rig& rig) { rig.plant()->inject(bench::FaultKind::kModuleException, std::nullopt, 1); }};

}  // namespace

TEST_CASE("control: a panic wins over the fault that follows it, and the record keeps both") {
  const Met met = GENERATE(kFiredDeadMan, kTripped, kZeroed, kRefused);
  INFO(met.id);
  Words words;
  const bench::RunResult result = words.run(kMidway, [&] {
    CHECK(say(Command::kPanic).taken);
    met.make(*words.rig);
  });
  REQUIRE(result.error);
  CHECK(result.error->id() == "TB-RUN-PANIC");
  CHECK(result.error->code() == ExitCode::kStopped);
  CHECK_THAT(result.error->what(), Catch::Contains(met.id));
  CHECK(result.outcome == db::Outcome::kAborted);
  CHECK(result.safe == db::SafeState::kVerified);
  CHECK(result.branches_redone == 0);
  CHECK(words.reasons() == Reasons{"fault " + met.id, "fault TB-RUN-PANIC"});
  CHECK(words.store.run(1).content_sha256 == words.store.content_hash(1));
}

TEST_CASE("control: a stop or an abort wins over a device that fails after it, not over a trip") {
  struct Row {
    Command command;
    db::Outcome outcome;
    std::string id;
  };
  const Row row = GENERATE(values<Row>({{Command::kStop, db::Outcome::kStopped, "TB-RUN-STOPPED"},
                                        {Command::kAbort, db::Outcome::kAborted, "TB-RUN-ABORTED"}}));
  const Met met = GENERATE(kRefused, kTripped, kFiredDeadMan);
  const bool wins = met.id == kRefused.id;
  INFO(row.id << ", " << met.id);
  Words words;
  const bench::RunResult result = words.run(kMidway, [&] {
    CHECK(say(row.command).taken);
    met.make(*words.rig);
  });
  REQUIRE(result.error);
  CHECK(result.error->id() == (wins ? row.id : met.id));
  if (wins) CHECK_THAT(result.error->what(), Catch::Contains("by " + bench::peer_text({getpid(), geteuid(), false})));
  CHECK(result.safe == db::SafeState::kVerified);
  CHECK(result.error->code() == ExitCode::kStopped);
  CHECK(result.outcome == (wins ? row.outcome : db::Outcome::kAborted));
  CHECK(result.branches_redone == 0);
  CHECK(words.reasons() ==
        (wins ? Reasons{"fault " + met.id, "fault " + row.id} : Reasons{"fault " + met.id, "word " + row.id}));
}

TEST_CASE("control: a fault before the panic remains the reason of the end, and the panic is recorded") {
  Words words;
  words.on_way_out = [] { CHECK(say(Command::kPanic).taken); };
  const bench::RunResult result = words.run(kMidway, [&] { kTripped.make(*words.rig); });
  REQUIRE(result.error);
  CHECK(result.error->id() == kTripped.id);
  CHECK(result.outcome == db::Outcome::kAborted);
  CHECK(words.reasons() == Reasons{"fault " + kTripped.id, "word TB-RUN-PANIC"});
}

TEST_CASE("control: after the last step a panic or an abort ends the run, and a stop is answered as too late") {
  const Command command = GENERATE(Command::kPause, Command::kStop, Command::kAbort, Command::kPanic);
  const bool late = command == Command::kPause || command == Command::kStop;
  Words words;
  bench::LiveRun answer;
  words.on_way_out = [&] { answer = say(command); };
  const bench::RunResult result = words.run(-1, [] {});
  CHECK(answer.taken == !late);
  if (late) {
    CHECK_FALSE(result.error);
    CHECK(result.outcome == db::Outcome::kCompleted);
    CHECK(words.reasons() == Reasons{});
    return;
  }
  REQUIRE(result.error);
  CHECK(result.outcome == db::Outcome::kAborted);
  CHECK(words.reasons() == Reasons{command == Command::kPanic ? "fault TB-RUN-PANIC" : "fault TB-RUN-ABORTED"});
  bench::RunRequest request = small_request();
  request.resume = 1;
  REQUIRE_FALSE(run_small(request, words.store).error);
  CHECK(judge_final_set(words.store, 1, 15, 2).faults == std::vector<std::string>());
}
