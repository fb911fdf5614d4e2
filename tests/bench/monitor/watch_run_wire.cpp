// `watch` of a run whose answers the test gives one by one: each line that it prints, and each block that it paints.
#include "bench/monitor/watch_run.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "bench/run/control/locks.h"
#include "bench/run/control/machine_name.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/bench/monitor/status_example.h"
#include "tests/db/store_example.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

// A run as those who ask it see it: the i-th question gets the i-th answer; after the last one it hangs up for good.
class AnswersOneByOne {
 public:
  // `before_end`: done once all answers were given.
  AnswersOneByOne(const std::string& name, std::vector<std::string> answers, std::function<void()> before_end)
      : name_(std::make_unique<bench::MachineName>(name)),
        thread_([this, texts = std::move(answers), ends = std::move(before_end)] {
          for (const std::string& text : texts) answer(text);
          ends();
          name_.reset();
        }) {}
  ~AnswersOneByOne() { thread_.join(); }
  AnswersOneByOne(const AnswersOneByOne&) = delete;
  AnswersOneByOne& operator=(const AnswersOneByOne&) = delete;

 private:
  void answer(const std::string& text) const {
    pollfd waiting{name_->descriptor(), POLLIN, 0};
    if (::poll(&waiting, 1, 20'000) != 1) return;
    const int client = ::accept(name_->descriptor(), nullptr, nullptr);
    std::array<char, 64> word{};
    (void)::recv(client, word.data(), word.size(), 0);
    (void)::send(client, text.data(), text.size(), MSG_NOSIGNAL);
    ::close(client);
  }
  std::unique_ptr<bench::MachineName> name_;
  std::thread thread_;
};

struct WatchedStore {
  WatchedStore() : store(db::RunStore::open(folder.path("runs.db"))), begun(begin_example(store)) {
    lock.emplace(store.path());
    lock->take_new(begun.run);
    live = example_live();
    live.name = "watched";
    live.status.run = begun.run;
    live.status.store = store.path();
    live.status.state = bench::RunState::kRunning;
    live.status.readings->time_s = 10.0;
  }
  [[nodiscard]] std::string answer(const std::string& phase, double time_s, std::int64_t run = 0,
                                   bool denied = false) const {
    bench::RunStatus status = live.status;
    status.phase = phase;
    status.readings->time_s = time_s;
    if (run != 0) status.run = run;
    nlohmann::json told{{"bench", "rig-1"}, {"denied", denied}, {"taken", true}, {"text", ""}};
    tell_status(told, status);
    return told.dump();
  }
  // By the run's process, as its last.
  void end() {
    store.end_run(begun.run, db::Outcome::kCompleted, "all steps done", db::SafeState::kVerified,
                  "2026-01-01T01:00:00Z");
    lock.reset();
  }
  const TemporaryFolder folder;
  db::RunStore store;
  Begun begun;
  bench::LiveRun live;
  std::optional<bench::RunLock> lock;
};

std::string line_at(const char* time, const char* phase) {
  return fmt::format(
      "run 1 running: {}; set-point 40.0, feedback 39.98, reference 40.01 psi, settled; {} elapsed, 0:10:45 left + 1 "
      "prompt (0:10:30 to 0:11:20); 10 x real time; 12 frames stored",
      phase, time);
}

}  // namespace

TEST_CASE("watch a run: a line for each phase, whoever does not answer is reported, and the end is told") {
  WatchedStore watched;
  watched.live.status.phase = "warming up";
  bench::WatchRunOptions options;
  options.every = std::chrono::milliseconds(1);
  options.line_every = std::chrono::hours(1);
  const bench::StopRequest stop;
  std::optional<bench::StoredRun> ended;
  const std::string printed = printed_by([&] {
    const AnswersOneByOne run(
        "watched",
        {watched.answer("warming up", 11.0), watched.answer("small, step 1 of 9, loading", 12.0),
         watched.answer("small, step 2 of 9, loading", 13.0), watched.answer("other", 14.0, 99),
         watched.answer("other", 15.0, 0, true), "no JSON", watched.answer("small, step 3 of 9, loading", 16.0)},
        [&] { watched.end(); });
    ended = bench::watch_run(watched.live, options, stop);
  });
  CHECK(printed == line_at("0:00:10", "warming up") + "\n" + line_at("0:00:12", "small, step 1 of 9, loading") + "\n" +
                       line_at("0:00:13", "small, step 2 of 9, loading") +
                       "; it does not answer: its process is stopped, or just ends\n" +
                       line_at("0:00:16", "small, step 3 of 9, loading") +
                       "\nrun 1 on bench 'bench-a' (simulated): completed, 0 frames\n"
                       "  recipe    up, down; sensor S-1, operator N. Nobody\n  reason    all steps done\n"
                       "  safe      verified\n  ended     2026-01-01T01:00:00Z\n");
  REQUIRE(ended);
  CHECK(ended->record.outcome == db::Outcome::kCompleted);
}

TEST_CASE(
    "watch a run: where a line is due, one is printed though the phase is the same, and one that died is told so") {
  WatchedStore watched;
  watched.live.status.phase = "warming up";
  bench::WatchRunOptions options;
  options.every = std::chrono::milliseconds(1);
  options.line_every = std::chrono::milliseconds(0);
  const bench::StopRequest stop;
  const std::string printed = printed_by([&] {
    const AnswersOneByOne run("watched", {watched.answer("warming up", 11.0)}, [&] { watched.lock.reset(); });
    const auto ended = bench::watch_run(watched.live, options, stop);
    if (ended && ended->record.outcome == db::Outcome::kIncomplete) fmt::print("(incomplete)\n");
  });
  CHECK(printed == line_at("0:00:10", "warming up") + "\n" + line_at("0:00:11", "warming up") +
                       "\nrun 1 on bench 'bench-a' (simulated): incomplete (no process carries it out), 0 frames\n"
                       "  recipe    up, down; sensor S-1, operator N. Nobody\n"
                       "  started   2024-05-01T09:00:00Z\n(incomplete)\n");
}

TEST_CASE("watch a run: on a terminal each block is painted over the one before, with the newest frame below it") {
  WatchedStore watched;
  db::FrameRecord frame = example_frame(watched.begun.branch, 0);
  frame.wrench.reset();
  frame.reference_psi = 8.0;
  watched.store.append_frame(watched.begun.run, frame);
  watched.live.status.phase = "warming up";
  bench::WatchRunOptions options;
  options.every = std::chrono::milliseconds(1);
  options.terminal = true;
  options.unit = analysis::PressureUnit::kKilopascal;
  const bench::StopRequest stop;
  std::optional<bench::StoredRun> ended;
  const std::string printed = printed_by([&] {
    const AnswersOneByOne run("watched", {watched.answer("x", 11.0, 98), watched.answer("8.0 psi", 12.0)},
                              [&] { watched.end(); });
    ended = bench::watch_run(watched.live, options, stop);
  });
  REQUIRE(ended);
  std::optional<bench::ArrayView> array = bench::newest_array(watched.store, ended->record);
  REQUIRE(array);
  array->title = "frame 1 at 55.2 kPa";
  const auto block = [&](std::vector<std::string> lines, std::size_t above) {
    return bench::painted(bench::watch_block(lines, array, bench::Shades::kCharacters, {80, 24}), 80, above);
  };
  const std::vector<std::string> warm = {
      "run 1 on bench 'rig-1' (simulated): running",
      "  recipe    up, down; sensor S-1, operator N. Nobody",
      "  phase     warming up",
      "  pressure  set-point 275.8, feedback 275.7, reference 275.9 kPa, settled",
      "  time      0:00:10 elapsed, 0:10:45 left + 1 prompt (0:10:30 to 0:11:20); 10 x real time",
      "  frames    12 stored, 211 planned"};
  std::vector<std::string> silent = warm, loaded = warm;
  silent[0] += "; it does not answer: its process is stopped, or just ends";
  loaded[2] = "  phase     55.2 kPa";
  loaded[4].replace(12, 7, "0:00:12");
  const std::size_t high = 6 + 1 + 14;  // the map's heading, and the lines beside the map
  CHECK(printed == block(warm, 0) + block(silent, high) + block(loaded, high) +
                       block({"run 1 on bench 'bench-a' (simulated): completed, 1 frame",
                              "  recipe    up, down; sensor S-1, operator N. Nobody", "  reason    all steps done",
                              "  safe      verified", "  ended     2026-01-01T01:00:00Z"},
                             high));
}
