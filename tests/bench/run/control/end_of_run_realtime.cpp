// A closed terminal, a reader of the output that ends or is stopped, unexpected signals: the run ends safely or
// continues, and its record is complete.
#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <csignal>

#include "bench/run/control/control_client.h"
#include "db/run_store.h"
#include "tests/support/child_process.h"
#include "tests/support/endless_run.h"
#include "tests/support/live_runs.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;

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
  // signals.cpp raises the others.
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
