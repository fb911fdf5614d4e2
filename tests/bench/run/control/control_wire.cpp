// Commands to a run on a bench that is simulated in its own process: sent from a step's own callback, so that each
// arrives at a known place of the recipe, through the real socket.
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cerrno>
#include <chrono>
#include <filesystem>
#include <functional>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "bench/common/error.h"
#include "bench/rig/rig.h"
#include "bench/run/control/control_client.h"
#include "bench/run/control/control_socket.h"
#include "bench/run/control/locks.h"
#include "bench/safety/safe_state.h"
#include "bench/simulation/plant.h"
#include "devices/wire/modbus/modbus_link.h"
#include "tests/bench/run/kill_record.h"
#include "tests/bench/run/quick_store.h"
#include "tests/devices/few_descriptors.h"
#include "tests/support/answering_run.h"
#include "tests/support/endless_run.h"
#include "tests/support/live_runs.h"
#include "tests/support/process.h"
#include "tests/support/refusal.h"
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
  // Events of run 1, "kind id", that show why it ended.
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

// Action during the sequencer's next command, before it polls commands again.
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

TEST_CASE("control: a panic outranks the fault that follows it, and both are recorded") {
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

TEST_CASE("control: a stop or an abort outranks a later device fault, but not a trip") {
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

TEST_CASE("control: after the last step a panic or an abort ends the run, a stop is answered as too late") {
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

// Commands to several runs on one machine: a stopped run, silent clients, clients that hang up. The times are bounds of
// what must not happen, many times as long as what does.

using namespace tactbench::bench;
using std::chrono::milliseconds;

namespace {

// State after a process was stopped: the names are held, but no connection is accepted.
struct Frozen {
  explicit Frozen(const std::string& id) : name(id), run(id + "/run/7") {}
  void fill() {  // until no more can wait there
    for (int one = connect_to_name(name.text()); one >= 0; one = connect_to_name(name.text())) waiting.push_back(one);
    REQUIRE(errno == EAGAIN);
  }
  ~Frozen() {
    for (const int one : waiting) close(one);
  }
  MachineName name, run;
  std::vector<int> waiting;
};

// Holds its name, and answers nobody yet.
struct Unserved {
  Unserved(const std::string& id, RunState state) : name(id) {
    REQUIRE(name.held());
    config.id = id;
    RunStatus status;
    status.state = state;
    control.publish(status);
  }
  MachineName name;
  BenchConfig config;
  Control control;
};

double seconds_of(const std::function<void()>& work) {
  const auto begun = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
}

}  // namespace

TEST_CASE("commands: a stopped run with a free or a full queue does not delay commands to another run") {
  const bool full = GENERATE(false, true);
  Frozen frozen("a-frozen");
  if (full) frozen.fill();
  AnsweringRun live("live", 3, "live.db");
  ListenOptions options;
  options.longest = std::chrono::seconds(60);
  RunReplies heard;
  const double took = seconds_of([&] { heard = send_to_runs(run_names(), Command::kStop, options); });
  CHECK(took < 10.0);  // 0.2 s are meant; it would take 60 s, or for ever, if one waited for the other
  REQUIRE(heard.answers.size() == 1);
  CHECK(heard.answers[0].taken);
  CHECK(heard.answers[0].bench == "live");
  CHECK(heard.answers[0].status.run == 3);
  REQUIRE(heard.silent.size() == 1);
  CHECK(heard.silent[0].bench == "a-frozen");
  CHECK(heard.silent[0].run == 7);
  CHECK(heard.silent[0].server.has_value() == !full);  // who holds it is told by a connection alone
  CHECK_FALSE(heard.silent[0].stranger);
}

TEST_CASE("commands: one run is waited for no longer than the timeout, and only the named bench is contacted") {
  Frozen frozen("a-frozen");
  AnsweringRun live("live", 3, "live.db");
  ListenOptions options;
  options.longest = milliseconds(200);
  double took = seconds_of([&] { CHECK(send_to_runs({"a-frozen"}, Command::kPanic, options).silent.size() == 1); });
  CHECK(took >= 0.2);
  CHECK(took < 5.0);
  options.longest = std::chrono::seconds(60);
  options.enough = [](const LiveRun& run) { return run.status.run == 3; };
  options.stragglers = std::chrono::seconds(60);
  took = seconds_of([&] { CHECK(send_to_runs(run_names(), Command::kStatus, options).answers.size() == 1); });
  CHECK(took < 20.0);
  CHECK(run_names("live") == std::vector<std::string>{"live"});
  CHECK(run_names("liv").empty());
}

TEST_CASE("commands: silent clients do not delay commands, however many they are") {
  AnsweringRun live("live", 3, "live.db");
  std::vector<int> idle;
  for (int i = 0; i < 200; ++i) {
    const int one = connect_to_name("live");
    if (one >= 0) idle.push_back(one);
  }
  REQUIRE(idle.size() >= 64);
  const double took = seconds_of([] {
    for (int i = 0; i < 20; ++i) CHECK(send_command("live", Command::kStatus));
  });
  CHECK(took < 10.0);
  const auto stopped = send_command("live", Command::kStop);
  REQUIRE(stopped);
  CHECK(stopped->taken);
  for (const int one : idle) close(one);
  CHECK(send_command("live", Command::kStatus));
}

TEST_CASE("commands: a client disconnected before its command was read succeeds at the next attempt") {
  Unserved run("crowded", RunState::kRunning);
  std::optional<LiveRun> answer;
  std::thread client([&] { answer = send_command("crowded", Command::kPanic); });
  pollfd waiting{run.name.descriptor(), POLLIN, 0};
  CHECK(poll(&waiting, 1, 10'000) == 1);
  close(accept(run.name.descriptor(), nullptr, nullptr));
  const ControlSocket socket(run.config, run.control, 5, &run.name);
  client.join();
  REQUIRE(answer);
  CHECK(answer->taken);
  const StopRequest signals;
  CHECK(run.control.asked(signals)->command == Command::kPanic);
}

TEST_CASE("commands: a resume from a disconnected sender is ignored, a panic still ends the run") {
  Unserved run("thawed", RunState::kPaused);
  const auto leave_behind = [&](const std::string& word) {
    const int client = connect_to_name("thawed");
    REQUIRE(client >= 0);
    REQUIRE(send(client, word.data(), word.size(), MSG_NOSIGNAL) > 0);
    close(client);
  };
  leave_behind("resume");
  {
    const ControlSocket socket(run.config, run.control, 4, &run.name);
    REQUIRE(send_command("thawed", Command::kStatus));  // after the one that waited
    CHECK_FALSE(run.control.consume_resume());
    leave_behind("panic");
    REQUIRE(send_command("thawed", Command::kStatus));
  }
  const StopRequest signals;
  const auto asked = run.control.asked(signals);
  REQUIRE(asked);
  CHECK(asked->command == Command::kPanic);
}

TEST_CASE("commands: a bench with an id that cannot be a file name is found only by that id") {
  AnsweringRun odd("../odd rig/7", 1, "../odd rig/7.db"), plain(".._odd_rig_7", 2, ".._odd_rig_7.db");
  const auto names = run_names("../odd rig/7");
  REQUIRE(names.size() == 1);
  const auto answer = send_command(names.front(), Command::kStatus);
  REQUIRE(answer);
  CHECK(answer->bench == "../odd rig/7");
  CHECK(answer->status.run == 1);
  CHECK(run_names().size() == 2);
}

TEST_CASE("commands: the holder of a bench is reported with run and store, to another run and another program") {
  AnsweringRun live("held bench", 3, "held bench.db");
  const auto refused = [&](const std::function<void()>& take, const std::vector<std::string>& parts) {
    const auto error = refusal_by(take);
    REQUIRE(error);
    CHECK(error->id() == "TB-BENCH-LOCKED");
    CHECK(error->code() == ExitCode::kUsage);
    CHECK(error->where() == shown_name(run_names("held bench").at(0)));
    for (const std::string& part : parts) CHECK(std::string(error->what()).find(part) != std::string::npos);
  };
  const std::string holder = peer_text({getpid(), geteuid(), false});
  refused([&] { const BenchLock lock(live.config); }, {holder, "run 3", "held bench.db"});
  refused(
      [&] {
        Control control;
        const ControlSocket socket(live.config, control, 4);
      },
      {holder});
}

// A run that pauses at the end of each branch, loaded as it is there, on the watchdog of the shipped bench: the module
// must be fed while the safe state is being proved.

namespace {

const std::string kLevels =
    "unit = \"psi\"\nturning_points = [0, 60, 50, 60, 0]\nstep = 10\ndwell_s = 2\nrepeats = 1\n"
    "[conditioning]\ncycles = 1\npeak = 60\n";

// Resumes each pause of the run, until the run ends.
void resume_each_pause(const std::string& socket) {
  for (auto live = bench::send_command(socket, Command::kStatus); live;
       live = bench::send_command(socket, Command::kStatus)) {
    if (live->status.state == bench::RunState::kPaused) (void)bench::send_command(socket, Command::kResume);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
}

}  // namespace

TEST_CASE("control: a run can pause at the end of every branch, under any load") {
  const auto& [recipe, branches] = GENERATE(table<std::string, int>({{kLevels, 4}, {press_text(1), 2}}));
  INFO(recipe);
  QuickStore store;
  bench::RunRequest request = small_request();
  request.recipes = {recipe_of(recipe)};
  request.assume_yes = true;
  std::thread person;
  int asked = 0;
  request.on_step = [&](const sequences::Step& step) {
    if (step.kind == sequences::StepKind::kConditioning || step.branch < asked) return;
    const auto live = live_runs();
    REQUIRE(live.size() == 1);
    CHECK(bench::send_command(live.front().name, Command::kPause));
    ++asked;
    if (!person.joinable()) person = std::thread(resume_each_pause, live.front().name);
  };
  const bench::RunResult result = run_small(request, store);
  if (person.joinable()) person.join();
  CHECK(asked == branches);
  INFO((result.error ? result.error->what() : ""));
  CHECK(result.outcome == db::Outcome::kCompleted);
  int paused = 0;
  for (const db::EventRecord& event : store.events(1))
    paused += event.kind == "state" && event.detail.starts_with("pausing -> paused") ? 1 : 0;
  CHECK(paused == branches);
}

TEST_CASE("safe state: the module is fed while waiting for the array") {
  bench::Rig rig(small_request().bench);
  rig.open();
  bench::UnloadedFrame baseline = bench::unloaded_frame_of(rig.array().read(8));
  for (double& counts : baseline) counts -= 20000.0;  // which it never comes down to
  const auto begun = rig.clock().now();
  CHECK(make_safe(rig, baseline).state == db::SafeState::kUnverified);
  CHECK(rig.clock().now() - begun > std::chrono::seconds(5));
  CHECK_NOTHROW(rig.source().keep_alive());
}

// Talks with runs leave nothing open, at either end.

namespace {

std::ptrdiff_t open_descriptors() {
  const std::filesystem::directory_iterator all("/proc/self/fd");
  return std::distance(begin(all), end(all));
}

// The state from which a live run of bench "thrifty" answers.
struct ThriftyRun {
  ThriftyRun() {
    config.id = "thrifty";
    RunStatus status;
    status.run = 3;
    status.state = RunState::kRunning;
    control.publish(status);
  }
  BenchConfig config;
  Control control;
};

}  // namespace

TEST_CASE("descriptors: commanding, following and answering a run leave no descriptor open") {
  ThriftyRun run;
  const auto before_run = open_descriptors();
  {
    const ControlSocket socket(run.config, run.control, 3);
    REQUIRE(send_command("thrifty", Command::kStatus));
    std::ptrdiff_t before = 0;
    CHECK(comes_true(
        [&] { return (before = open_descriptors()) == before_run + 4; }));  // two names, the word to stop, the spare
    for (int i = 0; i < 5; ++i) {
      CHECK(send_command("thrifty", Command::kStatus));
      CHECK(send_command("thrifty", Command::kPause));
      CHECK(send_command("thrifty", Command::kResume));
      CHECK_FALSE(send_command("not-there", Command::kStatus));
      RunConnection follower("thrifty", "follow");
      CHECK(comes_true([&] { return follower.newest().has_value(); }));
      RunConnection answering("thrifty", answer_packet(1, "yes", ""));
      CHECK(comes_true([&] { return answering.newest().has_value(); }));
      CHECK(MachineName("thrifty").owner() != "");
      CHECK_FALSE(MachineName("thrifty").held());
    }
    CHECK(comes_true([&] { return open_descriptors() == before; }));
  }
  CHECK(open_descriptors() == before_run);
}

TEST_CASE("descriptors: a run that can open no more descriptors still receives commands one after another") {
  ThriftyRun run;
  const ControlSocket socket(run.config, run.control, 3);
  REQUIRE(send_command("thrifty", Command::kStatus));
  std::vector<bool> taken;
  {
    const FewDescriptors for_the_client(1);
    for (const Command command :
         {Command::kPause, Command::kResume, Command::kPause, Command::kStop, Command::kPanic}) {
      const auto answer = send_command("thrifty", command);
      taken.push_back(answer && answer->taken);
    }
  }
  CHECK(taken == std::vector<bool>(5, true));
}

TEST_CASE("descriptors: a run with too few descriptors for its command socket ends with an error") {
  BenchConfig config;
  config.id = "starved";
  Control control;
  for (int left = 0; left < 6; ++left) {
    std::string id = "none";
    try {
      const FewDescriptors few(left);
      const ControlSocket socket(config, control, 3);
    } catch (const Error& error) {
      id = error.id();
    }
    INFO(left << " descriptors left: " << id);
    CHECK((id == "none" || id == "TB-SYSTEM-LIMIT" || id == "TB-BENCH-NAME"));
    CHECK((id == "none") == (left >= 3));
  }
}
