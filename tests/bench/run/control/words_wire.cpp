// Commands to several runs on one machine: a stopped run, silent clients, clients that hang up. The times are bounds of
// what must not happen, many times as long as what does.
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cerrno>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <thread>

#include "bench/common/error.h"
#include "bench/run/control/control_client.h"
#include "bench/run/control/control_socket.h"
#include "bench/run/control/locks.h"
#include "bench/run/control/machine_name.h"
#include "bench/run/control/peer.h"
#include "tests/support/answering_run.h"
#include "tests/support/process.h"
#include "tests/support/refusal.h"

using namespace tactbench::bench;
using namespace tactbench::tests;
using std::chrono::milliseconds;

namespace {

// What a process that was stopped leaves of its run: the names are held, nobody takes a connection.
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

TEST_CASE("commands: a stopped run does not delay commands to another run, with its queue free or full") {
  const bool full = GENERATE(false, true);
  Frozen frozen("a-frozen");
  if (full) frozen.fill();
  AnsweringRun live("live", 3, "live.db");
  ListenOptions options;
  options.longest = std::chrono::seconds(60);
  Heard heard;
  const double took = seconds_of([&] { heard = say_to(run_names(), Command::kStop, options); });
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

TEST_CASE("commands: a single run is waited for no longer than its timeout, and only the named bench is asked") {
  Frozen frozen("a-frozen");
  AnsweringRun live("live", 3, "live.db");
  ListenOptions options;
  options.longest = milliseconds(200);
  double took = seconds_of([&] { CHECK(say_to({"a-frozen"}, Command::kPanic, options).silent.size() == 1); });
  CHECK(took >= 0.2);
  CHECK(took < 5.0);
  options.longest = std::chrono::seconds(60);
  options.enough = [](const LiveRun& run) { return run.status.run == 3; };
  options.stragglers = std::chrono::seconds(60);
  took = seconds_of([&] { CHECK(say_to(run_names(), Command::kStatus, options).answers.size() == 1); });
  CHECK(took < 20.0);
  CHECK(run_names("live") == std::vector<std::string>{"live"});
  CHECK(run_names("liv").empty());
}

TEST_CASE("commands: silent clients delay no command, whatever their number") {
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

TEST_CASE("commands: a client disconnected before its command was read succeeds at the next try") {
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

TEST_CASE("commands: a resume whose sender has hung up is ignored, a panic still ends the run") {
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
    CHECK_FALSE(run.control.take_resume());
    leave_behind("panic");
    REQUIRE(send_command("thawed", Command::kStatus));
  }
  const StopRequest signals;
  const auto asked = run.control.asked(signals);
  REQUIRE(asked);
  CHECK(asked->command == Command::kPanic);
}

TEST_CASE("commands: a bench whose id cannot be a file name is found by that id only") {
  AnsweringRun odd("../odd rig/7", 1, "../odd rig/7.db"), plain(".._odd_rig_7", 2, ".._odd_rig_7.db");
  const auto names = run_names("../odd rig/7");
  REQUIRE(names.size() == 1);
  const auto answer = send_command(names.front(), Command::kStatus);
  REQUIRE(answer);
  CHECK(answer->bench == "../odd rig/7");
  CHECK(answer->status.run == 1);
  CHECK(run_names().size() == 2);
}

TEST_CASE("commands: who holds a bench is told with its run and store, to another run and to another program") {
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
