// Reasons for the end of a run, and parsing of its answers: without a rig and without a socket.
#include <catch2/catch.hpp>
#include <csignal>

#include "bench/common/error.h"
#include "bench/run/control/control.h"
#include "bench/run/control/control_client.h"
#include "bench/run/end_reason.h"
#include "bench/run/recorder.h"
#include "devices/device.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::bench;

namespace {

// Throws `thrown` and catches it.
template <class Thrown>
void met(EndReason& ending, const Thrown& thrown) {
  try {
    throw thrown;
  } catch (...) {
    ending.by_exception("here");
  }
}

const devices::Fault kDeviceFault("TB-SCANNER-LOST", "scanner", "gone", "plug it in");
const devices::Fault kTripFault("TB-CHAMBER-TRIP", "chamber", "67 psi", "look");

}  // namespace

TEST_CASE("answers: sender and acceptance are read, text that is not from a run gives no answer") {
  const auto live = read_answer("B/process/3", {12, 34, true},
                                R"({"bench":"B","run":9,"state":"paused","taken":true,"denied":true,"text":"t"})");
  REQUIRE(live);
  CHECK((live->name == "B/process/3" && live->bench == "B" && live->text == "t"));
  CHECK((live->server.process == 12 && live->server.user == 34 && live->server.in_group));
  CHECK((live->status.run == 9 && live->status.state == RunState::kPaused));
  CHECK((live->taken && live->denied));
  const auto bare = read_answer("B", {}, "{}");
  REQUIRE(bare);
  CHECK_FALSE((bare->taken || bare->denied || bare->status.run != 0));
  const std::vector<std::string> states = {"prepared",  "running",  "pausing", "paused",
                                           "suspended", "stopping", "ended"};
  for (std::size_t i = 0; i < states.size(); ++i) CHECK(to_string(static_cast<RunState>(i)) == states[i]);
  for (const char* strange : {"", "[]", "7", "{", R"({"run":"x"})", R"({"taken":1})"})
    CHECK_FALSE(read_answer("B", {}, strange));
}

TEST_CASE("ending: a command gives its outcome and exit code") {
  const auto ended = [](Command command, int signal) {
    const StopRequest signals;
    Control control;
    EndReason ending(control, signals);
    met(ending, RunEndRequested{command, signal, "bob"});
    CHECK(ending.error().value().where() == "here");
    CHECK_FALSE(ending.store_failed());
    CHECK_THAT(ending.error()->what(), Catch::Contains("bob"));
    return std::tuple(ending.error()->id(), ending.error()->code(), ending.outcome());
  };
  CHECK(ended(Command::kStop, 0) == std::tuple("TB-RUN-STOPPED", ExitCode::kStopped, db::Outcome::kStopped));
  CHECK(ended(Command::kStop, SIGTERM) == std::tuple("TB-RUN-STOPPED", ExitCode::kTerminated, db::Outcome::kStopped));
  CHECK(ended(Command::kAbort, 0) == std::tuple("TB-RUN-ABORTED", ExitCode::kStopped, db::Outcome::kAborted));
  CHECK(ended(Command::kPanic, 0) == std::tuple("TB-RUN-PANIC", ExitCode::kStopped, db::Outcome::kAborted));
}

TEST_CASE("ending: a fault gives its outcome, and which command outranks which fault") {
  const StopRequest signals;
  const auto ended = [&](const auto& thrown, std::optional<Command> word) {
    Control control;
    if (word) CHECK(control.ask(*word, "bob").taken);
    EndReason ending(control, signals);
    met(ending, thrown);
    return std::tuple(ending.error().value().id(), ending.error()->code(), ending.outcome(), ending.store_failed());
  };
  using db::Outcome;
  CHECK(ended(kDeviceFault, {}) == std::tuple("TB-SCANNER-LOST", ExitCode::kDevice, Outcome::kFailed, false));
  CHECK(ended(kTripFault, {}) == std::tuple("TB-CHAMBER-TRIP", ExitCode::kStopped, Outcome::kAborted, false));
  const db::StoreError full("TB-STORE-FULL", "full", "make room");
  CHECK(ended(full, {}) == std::tuple("TB-STORE-FULL", ExitCode::kStore, Outcome::kFailed, true));
  CHECK(ended(kDeviceFault, Command::kStop) ==
        std::tuple("TB-RUN-STOPPED", ExitCode::kStopped, Outcome::kStopped, false));
  CHECK(ended(kDeviceFault, Command::kAbort) ==
        std::tuple("TB-RUN-ABORTED", ExitCode::kStopped, Outcome::kAborted, false));
  CHECK(ended(kTripFault, Command::kAbort) ==
        std::tuple("TB-CHAMBER-TRIP", ExitCode::kStopped, Outcome::kAborted, false));
  CHECK(ended(kTripFault, Command::kPanic) == std::tuple("TB-RUN-PANIC", ExitCode::kStopped, Outcome::kAborted, false));
  CHECK(ended(full, Command::kStop) == std::tuple("TB-STORE-FULL", ExitCode::kStore, Outcome::kFailed, true));
  CHECK(ended(full, Command::kPanic) == std::tuple("TB-RUN-PANIC", ExitCode::kStopped, Outcome::kAborted, true));
  const Error unsafe("TB-SAFE-UNVERIFIED", "not proved", "");
  CHECK(ended(unsafe, Command::kPanic) == std::tuple("TB-RUN-PANIC", ExitCode::kUnsafe, Outcome::kAborted, false));
}

TEST_CASE("ending: a late abort or panic ends a run that nothing else has ended") {
  const StopRequest signals;
  struct Answers {
    std::optional<Error> error;
    db::Outcome outcome;
    std::vector<std::string> events;
  };
  const auto told = [&](const std::function<void(EndReason&, Control&)>& act) {
    const tests::TemporaryFolder folder;
    db::RunStore store = db::RunStore::open(folder.path("s.db"), db::Durability::kNormal);
    const std::int64_t number = tests::begin_example(store).run;
    devices::ManualClock clock;
    Recorder recorder(store, number, clock);
    Control control;
    EndReason ending(control, signals);
    act(ending, control);
    ending.record_last_command("at the end");
    CHECK_FALSE(control.ask(Command::kAbort, "late").taken);
    ending.write(recorder);
    Answers what{ending.error(), ending.outcome(), {}};
    for (const db::EventRecord& event : store.events(number)) what.events.push_back(event.kind + " " + event.id);
    return what;
  };
  using Events = std::vector<std::string>;
  const Answers done = told([](EndReason&, Control&) {});
  CHECK_FALSE(done.error);
  CHECK(done.outcome == db::Outcome::kCompleted);
  CHECK(done.events.empty());
  const Answers stop = told([](EndReason&, Control& control) { (void)control.ask(Command::kStop, "x"); });
  CHECK_FALSE(stop.error);
  CHECK(stop.events == Events{"word TB-RUN-STOPPED"});
  const Answers abort = told([](EndReason&, Control& control) { (void)control.ask(Command::kAbort, "x"); });
  CHECK(abort.error.value().id() == "TB-RUN-ABORTED");
  CHECK(abort.events == Events{"fault TB-RUN-ABORTED"});
  const Answers both = told([](EndReason& ending, Control& control) {
    met(ending, kDeviceFault);
    (void)control.ask(Command::kAbort, "x");
    ending.by(Error("TB-SAFE-UNVERIFIED", "", ""));  // something has ended it already
  });
  CHECK(both.error.value().id() == "TB-SCANNER-LOST");
  CHECK(both.events == Events{"fault TB-SCANNER-LOST", "word TB-RUN-ABORTED"});
  const Answers same = told([](EndReason& ending, Control& control) {
    (void)control.ask(Command::kStop, "x");
    met(ending, kDeviceFault);
  });
  CHECK(same.error.value().id() == "TB-RUN-STOPPED");
  CHECK_THAT(same.error->what(), Catch::Contains("TB-SCANNER-LOST"));
  CHECK(same.events == Events{"fault TB-SCANNER-LOST", "fault TB-RUN-STOPPED"});
  const Answers unsafe =
      told([](EndReason& ending, Control&) { ending.by(Error("TB-SAFE-UNVERIFIED", "not proved", "")); });
  CHECK(unsafe.error.value().id() == "TB-SAFE-UNVERIFIED");
  CHECK(unsafe.outcome == db::Outcome::kFailed);
}
