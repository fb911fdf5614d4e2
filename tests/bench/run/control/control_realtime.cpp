// Commands and signals to a run on a rig in its own process. An answer is promised within 200 ms; the quickest of
// several shows whether it waits for anything but the machine. Other times are printed as FIGURE lines, with a wide
// bound.

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <array>
#include <chrono>
#include <csignal>
#include <optional>
#include <thread>

#include "bench/guard/trip.h"
#include "bench/run/control/control_client.h"
#include "bench/run/control/locks.h"
#include "db/run_store.h"
#include "tests/bench/page/served_page.h"
#include "tests/bench/run/control/apart.h"
#include "tests/bench/run/kill_record.h"
#include "tests/support/child_process.h"
#include "tests/support/endless_run.h"
#include "tests/support/live_runs.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"
#include "tests/support/served_rig.h"
#include "tests/support/variable.h"

using namespace tactbench;
using namespace tactbench::tests;
using nlohmann::json;

namespace {

constexpr double kWordRate = 10.0;
constexpr int kFrames = 11, kRepeats = 2;
constexpr double kQuickAnswer = 0.2, kMost = 10.0, kPatience = 30.0;

struct WordRig : ServedRig {
  WordRig() : ServedRig(kWordRate) {
    write_file(folder.path("small.toml"),
               "schema = 1\nname = \"small\"\nunit = \"psi\"\nturning_points = [0, 12, 4, 12, 0]\nstep = 4\n"
               "repeats = 2\ndwell_s = 2\n[dwell]\ntolerance_s = 5\n");
  }
  [[nodiscard]] std::unique_ptr<ChildProcess> start_small() const {
    return start({"run", "small.toml", "--bench", "bench.toml", "--sensor", "S-1", "--operator", "t", "-q",
                  "--no-seating", "--on-event", "echo $TACTBENCH_EVENT $TACTBENCH_RUN >> told"});
  }
  bool wait_pressure() {
    return comes_true([&] { return !live_runs().empty() && psi() > 3.0; });
  }
  [[nodiscard]] static bool is(bench::RunState state) {
    const auto live = live_runs();
    return live.size() == 1 && live.front().status.state == state;
  }
  // A word through the program; its real time counts, with that of starting a program.
  Finished say(const std::string& word) {
    time_answers();
    const auto start = std::chrono::steady_clock::now();
    const std::size_t end = word.find(' ');
    Finished answer = end == std::string::npos ? run({word}) : run({word.substr(0, end), word.substr(end + 1)});
    const double took = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    worst_answer_s = std::max(worst_answer_s, took);
    return answer;
  }
  [[nodiscard]] json row(std::int64_t number = 1) const {
    return json::parse(run({"runs", "show", std::to_string(number), "--json"}).out);
  }
  [[nodiscard]] db::RunStore store() const { return db::RunStore::open_read_only(folder.path("runs.db")); }
  [[nodiscard]] std::vector<std::string> states() const {
    std::vector<std::string> states;
    for (const db::EventRecord& event : store().events(1)) {
      if (event.kind == "state") states.push_back(event.detail.substr(0, event.detail.find(':')));
    }
    return states;
  }
  [[nodiscard]] bool told(const std::string& lines) const {
    return comes_true(
        [&] { return std::filesystem::exists(folder.path("told")) && read_file(folder.path("told")) == lines; });
  }
  void time_answers() {
    const auto live = live_runs();
    // One quick answer of many will do: a busy machine holds most of them up, a run that answers late all of them.
    for (int i = 0; (i < 5 || (i < 20 && quickest_answer_s >= kQuickAnswer)) && live.size() == 1; ++i) {
      const auto start = std::chrono::steady_clock::now();
      if (!bench::send_command(live.front().name, bench::Command::kStatus)) continue;
      const double took = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      quickest_answer_s = std::min(quickest_answer_s, took);
    }
  }
  double quickest_answer_s = kPatience, worst_answer_s = 0.0;
};

}  // namespace

TEST_CASE("control: a pause waits vented at the end of the branch, and resume continues by the path back") {
  WordRig rig;
  const auto run = rig.start_small();
  REQUIRE(rig.wait_pressure());
  const Finished pause = rig.say("pause");
  INFO(pause.err);
  CHECK(pause.code == 0);
  CHECK_THAT(pause.out, Catch::Contains("run 1"));
  const auto asked = std::chrono::steady_clock::now();
  REQUIRE(comes_true([] { return !WordRig::is(bench::RunState::kRunning); }));
  const double acted_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - asked).count();
  REQUIRE(comes_true([] { return WordRig::is(bench::RunState::kPaused); }));
  CHECK(rig.psi() < 1.0);
  CHECK(rig.say("pause").code == 2);
  CHECK_THAT(rig.run({"pause"}).err, Catch::Contains("TB-RUN-WORD"));
  for (int i = 0; i < 50; ++i) CHECK(rig.psi() < 1.0);
  const Finished second = rig.run({"run", "small.toml", "--bench", "bench.toml", "--sensor", "S-1", "--operator", "u"});
  CHECK(second.code == 2);
  CHECK_THAT(second.err, Catch::Contains("TB-BENCH-LOCKED") && Catch::Contains("pid ") && Catch::Contains("run 1 of "));
  CHECK(rig.say("resume").code == 0);
  CHECK(run->wait() == 0);
  CHECK(rig.states() == std::vector<std::string>{"prepared -> running", "running -> pausing", "pausing -> paused",
                                                 "paused -> running", "running -> stopping"});
  const auto events = rig.store().events(1);
  CHECK(std::any_of(events.begin(), events.end(), [](const auto& event) { return event.kind == "way-back"; }));
  CHECK(std::any_of(events.begin(), events.end(),
                    [](const auto& event) { return event.kind == "safe" && event.id == "verified"; }));
  CHECK(judge_final_set(rig.store(), 1, kFrames, kRepeats).faults == std::vector<std::string>());
  CHECK(rig.told("waiting 1\ndone 1\n"));
  const Finished late = rig.run({"pause", "1"});
  CHECK(late.code == 2);
  CHECK_THAT(late.err, Catch::Contains("TB-RUN-NOT-LIVE"));
  WARN(fmt::format("FIGURE worst_answer_to_a_word {:.3f} s\nFIGURE state_pausing_after {:.3f} s", rig.worst_answer_s,
                   acted_s));
  CHECK(rig.quickest_answer_s < kQuickAnswer);
  CHECK(acted_s < kMost);
  CHECK(rig.worst_answer_s < kMost);
}

TEST_CASE("control: stop, abort and panic end a run at once, and panic latches a trip") {
  struct Row {
    std::string word, outcome, id;
  };
  const Row row = GENERATE(values<Row>({{"stop", "stopped", "TB-RUN-STOPPED"},
                                        {"stop --abort", "aborted", "TB-RUN-ABORTED"},
                                        {"panic", "aborted", "TB-RUN-PANIC"}}));
  WordRig rig;
  const auto run = rig.start_small();
  REQUIRE(rig.wait_pressure());
  INFO(row.word);
  CHECK(rig.say(row.word).code == 0);
  const double safe_s = rig.seconds_until_safe(kPatience);
  WARN(fmt::format("FIGURE safe_after_{} {:.3f} s, process time at {:g} x", row.word, safe_s, kWordRate));
  CHECK(safe_s < kPatience);
  CHECK(run->wait() == 4);
  INFO(rig.log());
  CHECK_THAT(rig.log(), Catch::Contains(row.id));
  const json ended = rig.row();
  CHECK(ended["outcome"] == row.outcome);
  CHECK(ended["safe_state"] == "verified");
  CHECK(rig.told("failed 1\n"));
  CHECK(rig.quickest_answer_s < kQuickAnswer);
  CHECK(rig.worst_answer_s < kMost);
  CHECK(bench::TripFile(rig.bench_id).read().has_value() == (row.word == "panic"));
  if (row.word == "panic") {
    const Finished refused = rig.run({"resume", "1", "--bench", "bench.toml"});
    CHECK(refused.code == 4);
    CHECK_THAT(refused.err, Catch::Contains("TB-BENCH-TRIPPED"));
    CHECK(rig.run({"devices", "reset", "--bench", "bench.toml", "--operator", "t"}).code == 0);
  }
  const Finished resumed = rig.run({"resume", "1", "--bench", "bench.toml", "-q"});
  INFO(resumed.err);
  CHECK(resumed.code == 0);
  CHECK(judge_final_set(rig.store(), 1, kFrames, kRepeats).faults == std::vector<std::string>());
}

TEST_CASE("control: Ctrl-C pauses, again after a resume it pauses again, and a second one ends the run") {
  WordRig rig;
  const auto run = rig.start_small();
  for (int i = 0; i < 2; ++i) {
    REQUIRE(rig.wait_pressure());
    run->signal(SIGINT);
    REQUIRE(comes_true([] { return WordRig::is(bench::RunState::kPaused); }));
    CHECK(rig.psi() < 1.0);
    if (i == 0) CHECK(rig.say("resume").code == 0);
  }
  run->signal(SIGINT);
  CHECK(run->wait() == 130);
  CHECK(rig.row()["outcome"] == "stopped");
  CHECK(rig.row()["safe_state"] == "verified");
}

TEST_CASE("control: Ctrl-C twice, or SIGTERM, ends a run under pressure, vented") {
  const auto [signal, times, code] = GENERATE(table<int, int, int>({{SIGINT, 2, 130}, {SIGTERM, 1, 143}}));
  WordRig rig;
  const auto run = rig.start_small();
  REQUIRE(rig.wait_pressure());
  run->signal(signal);
  if (times == 2) {  // two signals at once may be one
    REQUIRE(comes_true([] { return WordRig::is(bench::RunState::kPausing); }));
    run->signal(signal);
  }
  CHECK(run->wait() == code);
  CHECK(rig.psi() < 1.0);
  CHECK(rig.row()["outcome"] == "stopped");
  CHECK(rig.row()["safe_state"] == "verified");
}

TEST_CASE("control: commands without a run, with two runs and to another bench give an error with a remedy") {
  const TemporaryFolder folder;
  const std::string program = program_path();
  const auto say = [&](const std::vector<std::string>& words) { return run_program(program, words, folder.path()); };
  const Finished nobody = say({"pause"});
  CHECK(nobody.code == 2);
  CHECK_THAT(nobody.err, Catch::Contains("TB-RUN-NOT-LIVE"));
  REQUIRE(say({"init"}).code == 0);
  write_file(folder.path("long.toml"),
             "schema = 1\nname = \"long\"\nunit = \"psi\"\nturning_points = [0, 60, 0]\nstep = 2\nrepeats = 1000\n");
  std::vector<std::unique_ptr<ChildProcess>> runs;
  for (const char* name : {"one", "two"}) {
    const std::string db = folder.path(std::string(name) + ".db");
    REQUIRE(say({"sensors", "add", "S-1", "--type", "sensor.toml", "--db", db}).code == 0);
    const std::string line = fmt::format(
        "cd '{}' && exec '{}' run long.toml --bench bench.toml --sensor S-1 --operator t -q --no-seating "
        "--db '{}' 2>>log",
        folder.path(), program, db);
    runs.push_back(std::make_unique<ChildProcess>(std::vector<std::string>{"/bin/sh", "-c", line}));
  }
  REQUIRE(comes_true([] { return live_runs().size() == 2; }));
  const Finished both = say({"stop"});
  CHECK(both.code == 2);
  CHECK_THAT(both.err, Catch::Contains("TB-RUN-AMBIGUOUS") && Catch::Contains("one.db") && Catch::Contains("two.db"));
  CHECK(say({"stop", "1"}).code == 2);
  CHECK(say({"stop", "7"}).code == 2);
  CHECK(say({"stop", "1", "--db", folder.path("one.db")}).code == 0);
  CHECK(runs[0]->wait() == 4);
  std::filesystem::copy_file(folder.path("one.db"), folder.path("runs.db"));
  const Finished which = say({"resume", "1"});  // ended in runs.db, live in two.db
  CHECK(which.code == 2);
  CHECK_THAT(which.err, Catch::Contains("TB-RUN-AMBIGUOUS") && Catch::Contains("two.db"));
  CHECK(say({"stop"}).code == 0);
  CHECK(runs[1]->wait() == 4);
  write_file(folder.path("other.toml"), [&] {
    std::string text = read_file(folder.path("bench.toml"));
    const std::size_t at = text.find("simulated-rig");
    REQUIRE(at != std::string::npos);
    return text.replace(at, 13, "another-rig");
  }());
  const Finished elsewhere = say({"resume", "1", "--db", "one.db", "--bench", "other.toml"});
  CHECK(elsewhere.code == 2);
  CHECK_THAT(elsewhere.err, Catch::Contains("TB-RESUME-BENCH") && Catch::Contains("another-rig"));
}

// Commands to runs in other processes, one of which is stopped.

namespace {

// With its real time, that of starting the program included.
struct Timed {
  Finished finished;
  double seconds = 0.0;
};

Timed timed(const std::vector<std::string>& words, const std::string& folder) {
  const auto begun = std::chrono::steady_clock::now();
  Timed done{run_program(program_path(), words, folder), 0.0};
  done.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  return done;
}

}  // namespace

TEST_CASE("commands: a stopped run with a full queue is named, and other runs answer") {
  struct Row {
    bool full;
    std::vector<std::string> words;
  };
  const Row row = GENERATE(
      values<Row>({{false, {"panic"}}, {true, {"panic", "--db", "runs.db"}}, {true, {"stop", "--bench", "two"}}}));
  EndlessRun frozen("one"), healthy("two");
  REQUIRE(frozen.lives());
  REQUIRE(healthy.lives());
  frozen.process().signal(SIGSTOP);
  const std::string name = bench::run_names("one").at(0);
  std::vector<int> waiting;
  for (int one = row.full ? bench::connect_to_name(name) : -1; one >= 0; one = bench::connect_to_name(name))
    waiting.push_back(one);
  CHECK(waiting.empty() == !row.full);
  const std::string folder = healthy.folder.path();
  const Timed unnamed = timed({"stop"}, folder);
  CHECK(unnamed.finished.code == 2);
  CHECK_THAT(unnamed.finished.err,
             Catch::Contains("TB-RUN-AMBIGUOUS") && Catch::Contains("'one'") && Catch::Contains("'two'"));
  const Timed silent = timed({"panic", "--bench", "one"}, folder);
  CHECK(silent.finished.code == 2);
  CHECK_THAT(silent.finished.err, Catch::Contains("TB-RUN-SILENT") && Catch::Contains("'one'"));
  const Timed heard = timed(row.words, folder);
  INFO(heard.finished.err);
  CHECK(heard.finished.code == 0);
  WARN(fmt::format("FIGURE answer_beside_a_stopped_run {:.3f} s", heard.seconds));
  for (const Timed* each : {&unnamed, &silent, &heard}) CHECK(each->seconds < 20.0);  // 2 s are meant
  CHECK(healthy.process().wait() == 4);
  for (const int one : waiting) close(one);
  frozen.process().signal(SIGCONT);  // it may still find the panic
  std::optional<int> code;
  REQUIRE(comes_true([&] {
    (void)timed({"stop", "--bench", "one"}, folder);
    return (code = frozen.process().ended_within(std::chrono::milliseconds(50))).has_value();
  }));
  CHECK(code == 4);
}

// A closed terminal, a reader of the output that ends or is stopped, unexpected signals: the run ends safely or
// continues, and its record is complete.

namespace {

// Runs in whole or until they are ended, on a rig in the program's own process.
struct Desk {
  Desk() {
    // The tests may run under nohup, and children inherit that.
    std::signal(SIGHUP, SIG_DFL);
    const std::string recipe = "schema = 1\nname = \"r\"\nunit = \"psi\"\nturning_points = [0, 60, 0]\nstep = 2\n";
    write_file(folder.path("long.toml"), recipe + "repeats = 1000\n");
    write_file(folder.path("short.toml"), recipe);
    REQUIRE(call({"init"}).code == 0);
    REQUIRE(call({"sensors", "add", "S-1", "--type", "sensor.toml"}).code == 0);
  }
  [[nodiscard]] Finished call(const std::vector<std::string>& words) const {
    return run_program(program_path(), words, folder.path());
  }
  static std::vector<std::string> run_arguments(const std::string& recipe) {
    return {"run", recipe, "--bench", "bench.toml", "--sensor", "S-1", "--operator", "t", "--no-seating"};
  }
  // In a shell, `redirected` to what it says: "2>&-".
  [[nodiscard]] std::unique_ptr<ChildProcess> start(const std::vector<std::string>& words,
                                                    const std::string& redirected) const {
    return std::make_unique<ChildProcess>(std::vector<std::string>{
        "/bin/sh", "-c",
        fmt::format("cd '{}' && exec '{}' {} {}", folder.path(), program_path(), fmt::join(words, " "), redirected)});
  }
  [[nodiscard]] db::RunStore store() const { return db::RunStore::open_read_only(folder.path("runs.db")); }
  [[nodiscard]] bool has_frames() const {
    try {
      return store().frame_count(1) > 0;
    } catch (const db::StoreError&) {  // it is being made
      return false;
    }
  }
  static bool paused() {
    const auto live = live_runs();
    return live.size() == 1 && live.front().status.state == bench::RunState::kPaused;
  }
  void check_row(db::Outcome outcome) const {
    const db::RunRecord row = store().run(1);
    CHECK(row.outcome == outcome);
    CHECK(row.safe_state == db::SafeState::kVerified);
    CHECK(row.content_sha256 == store().content_hash(1));
  }
  TemporaryFolder folder;
};

// A named pipe with a reader that closes it, or stops reading.
class Pipe {
 public:
  explicit Pipe(const std::string& path) : path_(path) {
    if (::mkfifo(path.c_str(), 0600) != 0) throw std::runtime_error("cannot make " + path);
    reader_ = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  }
  ~Pipe() { close_reader(); }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  void close_reader() {
    if (reader_ >= 0) ::close(std::exchange(reader_, -1));
  }
  [[nodiscard]] bool has_output() const {
    char byte = 0;
    return ::read(reader_, &byte, 1) == 1;
  }
  void fill() const {
    const int writer = ::open(path_.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC);
    const std::array<char, 4096> bytes{};
    while (::write(writer, bytes.data(), bytes.size()) > 0) {
    }
    ::close(writer);
  }

 private:
  std::string path_;
  int reader_ = -1;
};

}  // namespace

TEST_CASE("end of run: every signal ends a run like a request to terminate") {
  // ending.cpp raises the others.
  const auto [number, code] = GENERATE(table<int, int>({{SIGHUP, 129}, {SIGXCPU, 152}, {64, 192}}));
  const Desk desk;
  const Finished run = run_program(program_path(), Desk::run_arguments("long.toml"), desk.folder.path(),
                                   {number, [&] { return desk.has_frames(); }});
  INFO(run.err);
  CHECK(run.code == code);
  CHECK_THAT(run.err, Catch::Contains("[TB-RUN-STOPPED]"));
  desk.check_row(db::Outcome::kStopped);
}

TEST_CASE(
    "end of run: after the reader of standard error has ended, the run continues, and pauses and stops as asked") {
  const Desk desk;
  Pipe pipe(desk.folder.path("err"));
  const auto run = desk.start(Desk::run_arguments("long.toml"), "2>err");
  REQUIRE(comes_true([&] { return pipe.has_output(); }));  // the estimate
  pipe.close_reader();
  REQUIRE(comes_true([&] { return desk.has_frames(); }));
  run->signal(SIGINT);
  REQUIRE(comes_true(Desk::paused));  // two notes later
  run->signal(SIGINT);
  CHECK(run->wait() == 130);
  desk.check_row(db::Outcome::kStopped);
}

TEST_CASE("end of run: a run without a reader of its result, or with its streams closed, completes") {
  const Desk desk;
  const bool closed = GENERATE(false, true);
  Pipe pipe(desk.folder.path("out"));
  if (!closed) {
    const auto run = desk.start(Desk::run_arguments("short.toml"), ">out 2>&1");
    REQUIRE(comes_true([&] { return pipe.has_output(); }));
    pipe.close_reader();
    CHECK(run->wait() == 0);
  } else {
    CHECK(desk.start(Desk::run_arguments("short.toml"), "<&- >&- 2>&-")->wait() == 0);
  }
  desk.check_row(db::Outcome::kCompleted);
  CHECK(desk.call({"verify", "1"}).code == 0);
}

TEST_CASE("end of run: a stopped reader of standard error does not delay it") {
  const Desk desk;
  const Pipe pipe(desk.folder.path("err"));
  pipe.fill();
  CHECK(desk.start(Desk::run_arguments("short.toml"), "2>err")->wait() == 0);
  desk.check_row(db::Outcome::kCompleted);
}

TEST_CASE("end of run: live ends when the reader of its output ends") {
  const Desk desk;
  Pipe pipe(desk.folder.path("out"));
  const auto watch = desk.start({"live", "--bench", "bench.toml", "--interval", "0.05"}, ">out");
  REQUIRE(comes_true([&] { return pipe.has_output(); }));
  pipe.close_reader();
  CHECK(watch->wait() == 0);
}

// Who may do what, as the table of docs/safety.md says: other users of the machine against a run, on the machine's own
// names. Other users, and a group of their own for members, take root's rights; without them the tests say that they
// were skipped.

namespace {

constexpr int kOwner = 5, kOther = kNobodyHere, kGroup = kGroupHere;

// Shell words before a program: another user, the group's member or not, on a machine that has such a group. `own`: a
// folder for what the user keeps.
std::string as_user(int user, bool member, const std::string& own) {
  return fmt::format(
      "unshare -m /bin/sh -c 'mount --bind \"$0/group\" /etc/group && exec setpriv --reuid={0} --regid={0} {1} env -u "
      "TACTBENCH_RUNTIME_DIR HOME=\"$0\" XDG_STATE_HOME=\"$0\" TMPDIR=\"$0\" \"$@\"' '{2}' ",
      user, member ? fmt::format("--groups {}", kGroup) : std::string("--clear-groups"), own);
}

struct Users {
  Users() {
    write_file(folder.path("group"), fmt::format("root:x:0:\ntactbench:x:{}:\n", kGroup));
    (void)run_program("/bin/sh", {"-c", "chmod -R a+rwX ."}, folder.path());
  }
  [[nodiscard]] Finished say(int user, bool member, const std::string& words) const {
    return run_program("/bin/sh", {"-c", as_user(user, member, folder.path()) + "'" + program_path() + "' " + words},
                       folder.path());
  }
  // That all of it is allowed here.
  [[nodiscard]] bool can() const {
    const Finished tried = say(kOther, true, "--version");
    if (tried.code != 0)
      WARN("skipped: this needs root, its capabilities and a program that all can read: " + tried.err);
    return tried.code == 0;
  }
  const TemporaryFolder folder;
};

// Another user's process that holds a name and answers whoever asks that it is run 1 of `store` on `bench` and takes
// all.
struct Stranger : Apart {
  Stranger(const std::string& what, const std::string& bench, const std::string& store = "x.db")
      : Apart([&](const Stay& stay) {
          become_nobody(kNobodyHere);
          const bench::MachineName name(what);
          const std::string lie = fmt::format(
              R"({{"bench":"{}","taken":true,"run":1,"state":"running","store":"{}","text":"run 1"}})", bench, store);
          std::thread([&] {
            for (;;) {
              const int client = accept4(name.descriptor(), nullptr, nullptr, SOCK_CLOEXEC);
              if (client >= 0) (void)send(client, lie.data(), lie.size(), MSG_NOSIGNAL);
              if (client < 0) usleep(1000);
            }
          }).detach();
          stay();
        }) {
    REQUIRE(ready());
  }
};

}  // namespace

TEST_CASE("users: root, the owner and members of the group of the owner may command a run") {
  const Users users;
  if (!users.can()) return;
  struct Row {
    int user;
    bool member, owner_is_member, may;
  };
  const Row row = GENERATE(values<Row>({{0, false, false, true},
                                        {kOwner, false, false, true},
                                        {kOther, false, false, false},
                                        {kOther, true, true, true},
                                        {kOther, true, false, false},
                                        {kOther, false, true, false}}));
  INFO("user " << row.user << ", member " << row.member << ", owner a member " << row.owner_is_member);
  const Variable scope("TACTBENCH_RUNTIME_DIR", std::nullopt);
  const std::string id = fmt::format("users-{}", getpid());
  EndlessRun run(id, as_user(kOwner, row.owner_is_member, users.folder.path()));
  REQUIRE(run.lives());  // root hears anybody
  const Finished word = users.say(row.user, row.member, "stop --bench " + id);
  INFO(word.err);
  CHECK(word.code == (row.may ? 0 : 2));
  if (!row.may) {
    CHECK_THAT(word.err, Catch::Contains("TB-RUN-DENIED"));
    CHECK_FALSE(run.process().ended_within(std::chrono::milliseconds(300)));
    CHECK(users.say(kOwner, row.owner_is_member, "stop --bench " + id).code == 0);
  }
  CHECK(run.process().wait() == 4);
}

TEST_CASE("users: an answer of another user is not trusted, and the run it names is not shown") {
  const Users users;
  if (!users.can()) return;
  const Variable scope("TACTBENCH_RUNTIME_DIR", std::nullopt);
  const std::string id = fmt::format("stranger-{}", getpid());
  const Stranger stranger(id, "x");
  const Finished panic = users.say(kOwner, false, "panic --bench " + id);
  CHECK(panic.code == 2);
  CHECK_THAT(panic.err, Catch::Contains("TB-RUN-DENIED") && Catch::Contains("nobody (pid "));
  // Nor does it stand in the way of a word to a run that is real.
  EndlessRun run(fmt::format("real-{}", getpid()), as_user(kOwner, false, users.folder.path()));
  REQUIRE(run.lives());
  const Finished real = users.say(kOwner, false, fmt::format("panic --db '{}'", run.folder.path("runs.db")));
  INFO(real.err);
  CHECK(real.code == 0);
  CHECK(run.process().wait() == 4);
}

TEST_CASE("users: a false answer in the name of a run does not block the panic of root") {
  const Users users;
  if (!users.can()) return;
  const Variable scope("TACTBENCH_RUNTIME_DIR", std::nullopt);
  const std::string id = fmt::format("doubled-{}", getpid());
  EndlessRun run(id, as_user(kOwner, false, users.folder.path()));
  REQUIRE(run.lives());
  const Stranger stranger(id + "/process/1", id);
  const Finished panic = users.say(0, false, "panic --bench " + id);
  INFO(panic.err);
  CHECK(panic.code == 0);
  CHECK(run.process().wait() == 4);
}

TEST_CASE("users: root does not trust another user who claims to be a run of the store, by command or on the page") {
  const Users users;
  if (!users.can()) return;
  const Variable scope("TACTBENCH_RUNTIME_DIR", std::nullopt);
  const std::string id = fmt::format("{}", getpid());
  EndlessRun run("run-" + id, as_user(kOwner, false, users.folder.path()));
  const std::string store = run.folder.path("runs.db");
  // Before the run's name in the alphabet, as many as an impatient look might give up at.
  std::vector<std::unique_ptr<Stranger>> strangers;
  for (const char* name : {"a", "b", "c", "d"})
    strangers.push_back(std::make_unique<Stranger>(name + id, name + id, store));
  const std::string named = fmt::format("nobody (pid {})", strangers[0]->process());
  for (const char* word : {"panic", "stop", "stop --abort"}) {
    const Finished said = users.say(0, false, fmt::format("{} --bench a{}", word, id));
    INFO(said.err);
    CHECK(said.code == 2);
    CHECK_THAT(said.err, Catch::Contains("TB-RUN-DENIED") && Catch::Contains(named));
  }
  const Finished status = users.say(0, false, fmt::format("status --json --bench a{}", id));
  CHECK(nlohmann::json::parse(status.out)["live"] == false);
  REQUIRE(run.lives());
  const WordsPage page([&](bench::PageOptions& options) { options.db = store; });
  RawClient viewer(page.server->port());
  REQUIRE(viewer.send(page.head("GET /events", page.server->access().read_token)));
  CHECK_THAT(viewer.read(20'000, "\"live\":true"), Catch::Contains("\"bench\":\"run-" + id));
  const nlohmann::json panic = page.command({{"word", "panic"}, {"run", 1}});
  CHECK(panic["taken"] == true);
  CHECK_THAT(panic["by"].get<std::string>(), Catch::Contains("pid") && !Catch::Contains("nobody"));
  CHECK(run.process().wait() == 4);
}
