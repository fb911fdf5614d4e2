// `watch` of a run whose answers the test gives one by one: what it prints of them.
#include "bench/monitor/run_view.h"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>

#include "bench/run/control/locks.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/bench/monitor/status_example.h"
#include "tests/db/store_example.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

// A run as seen by its clients: the i-th request gets the i-th answer; after the last one it closes the connection.
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
    lock->lock_new_run(begun.run);
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
    nlohmann::json reply{{"bench", "rig-1"}, {"denied", denied}, {"taken", true}, {"text", ""}};
    add_status_json(reply, status);
    return reply.dump();
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

}  // namespace

TEST_CASE("watch: prints each phase and the end of the run, and ignores answers of other runs") {
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
  for (const char* phase : {"warming up", "step 1 of 9", "step 2 of 9", "step 3 of 9"})
    CHECK_THAT(printed, Catch::Contains(phase));
  CHECK_THAT(printed, !Catch::Contains("other"));  // another run's, or one that denies
  REQUIRE(ended);
  CHECK(ended->record.outcome == db::Outcome::kCompleted);
}
