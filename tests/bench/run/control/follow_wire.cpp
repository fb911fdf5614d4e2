// Clients that follow a run: the newest status at a bounded rate, whoever reads or does not; and answers to a question,
// of which one wins.

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>
#include <catch2/catch.hpp>

#include <array>
#include <chrono>
#include <memory>
#include <random>
#include <thread>

#include "analysis/dataset.h"
#include "bench/run/control/control_client.h"
#include "bench/run/time_estimate.h"
#include "tests/bench/run/finished_run.h"
#include "tests/bench/run/quick_store.h"
#include "tests/support/answering_run.h"
#include "tests/support/endless_run.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;
using std::chrono::milliseconds;

namespace {

struct Answering : AnsweringRun {
  explicit Answering(const std::string& id) : AnsweringRun(id, 3, id + ".db") {}
  void ask(const std::string& question) {
    status.question = question;
    ++status.question_id;
    status.state = RunState::kPaused;
    publish();
  }
  void count(std::int64_t frames) {
    status.frames = frames;
    publish();
  }
};

std::optional<LiveRun> next_of(RunConnection& connection) {
  std::optional<LiveRun> got;
  (void)comes_true([&] { return (got = connection.newest()).has_value() || !connection.open(); });
  return got;
}

LiveRun say(const std::string& bench, const std::string& words) {
  // A queue that others filled refuses for a moment.
  std::optional<RunConnection> connection;
  REQUIRE(comes_true([&] { return connection.emplace(bench, words).open(); }));
  const std::optional<LiveRun> answer = next_of(*connection);
  REQUIRE(answer);
  return *answer;
}

}  // namespace

TEST_CASE("follow: each update arrives, and the status is repeated if nothing is new") {
  Answering run("followed");
  RunConnection follower("followed", "follow");
  REQUIRE(follower.open());
  CHECK(comes_true([&] { return next_of(follower)->status.frames == 0; }));
  run.count(17);
  CHECK(comes_true([&] { return next_of(follower)->status.frames == 17; }));
  CHECK(next_of(follower));  // nothing new is told again
  run.socket.reset();
  CHECK(comes_true([&] {
    (void)follower.newest();
    return !follower.open();
  }));
}

TEST_CASE("follow: at most 20 statuses per second, always the newest, to every follower") {
  Answering run("followed");
  std::vector<std::unique_ptr<RunConnection>> followers;
  for (int i = 0; i < 3; ++i) followers.push_back(std::make_unique<RunConnection>("followed", "follow"));
  const auto begun = std::chrono::steady_clock::now();
  std::int64_t told = 0;
  std::array<int, 3> came{};
  std::array<std::int64_t, 3> last{-1, -1, -1};
  while (std::chrono::steady_clock::now() - begun < milliseconds(1000)) {
    run.count(++told);
    for (std::size_t i = 0; i < followers.size(); ++i) {
      if (const auto got = followers[i]->newest()) {
        ++came.at(i);
        CHECK(got->status.frames > last.at(i));
        last.at(i) = got->status.frames;
      }
    }
    std::this_thread::sleep_for(milliseconds(1));
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  for (const int count : came) {
    CHECK(count >= 2);
    CHECK(count <= static_cast<int>(20.0 * seconds) + 2);
  }
}

TEST_CASE("follow: a follower that does not read delays nobody, and gets few outdated updates when it reads again") {
  Answering run("followed");
  RunConnection frozen("followed", "follow");
  RunConnection reader("followed", "follow");
  REQUIRE(next_of(reader));
  std::int64_t told = 0;
  const auto begun = std::chrono::steady_clock::now();
  while (std::chrono::steady_clock::now() - begun < milliseconds(3000)) {
    run.count(++told);
    std::this_thread::sleep_for(milliseconds(20));
  }
  CHECK(comes_true([&] { return next_of(reader)->status.frames == told; }));
  CHECK(say("followed", to_string(Command::kStatus)).status.frames == told);
  int unread = 0;
  std::array<char, 32768> bytes{};
  while (::recv(frozen.descriptor(), bytes.data(), bytes.size(), MSG_DONTWAIT) > 0) ++unread;
  CHECK(unread > 0);
  CHECK(unread < 40);  // of about 60 that were told, and of any number in an hour
}

TEST_CASE("follow: sixteen followers are accepted, a further one is refused, and none delays the sequencer") {
  Answering run("followed");
  std::vector<std::unique_ptr<RunConnection>> followers;
  for (int i = 0; i < 16; ++i) {
    followers.push_back(std::make_unique<RunConnection>("followed", "follow"));
    REQUIRE(next_of(*followers.back()));
  }
  CHECK_THAT(say("followed", "follow").text, Catch::Contains("16"));
  followers.pop_back();
  CHECK(comes_true([&] { return say("followed", "follow").text.empty(); }));
  double longest = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const auto before = std::chrono::steady_clock::now();
    run.count(i);
    longest = std::max(longest, std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count());
    std::this_thread::sleep_for(milliseconds(1));
  }
  CHECK(longest < 2.0);  // it would be for ever
  CHECK(say("followed", to_string(Command::kPause)).taken);
}

TEST_CASE("follow: random packets neither end the server nor command the run") {
  Answering run("followed");
  std::mt19937 chance(7);
  for (int i = 0; i < 300; ++i) {
    std::string packet(chance() % 80, ' ');
    for (char& c : packet) c = static_cast<char>(chance());
    if (i % 5 == 0) packet = "answer " + packet;
    if (i % 7 == 0) packet = "follow" + packet;
    const RunConnection one("followed", packet);
  }
  const LiveRun after = say("followed", to_string(Command::kStatus));
  CHECK(after.status.state == RunState::kRunning);
  CHECK_FALSE(run.control.pause_wanted());
}

TEST_CASE("answer: an open question is answered once, a second sender gets the name of the first") {
  Answering run("asked");
  CHECK_FALSE(say("asked", answer_packet(1, "yes", "bob")).taken);
  run.ask("Point indenter mounted?");
  CHECK_FALSE(say("asked", "answer").taken);
  const LiveRun first = say("asked", answer_packet(1, "with 2 Nm", "bob"));
  CHECK(first.taken);
  REQUIRE(first.status.answer);
  CHECK(first.status.answer->text == "with 2 Nm");
  const LiveRun second = say("asked", answer_packet(1, "no", "eve"));
  CHECK_FALSE(second.taken);
  CHECK_THAT(second.text, Catch::Contains("bob"));
  CHECK(run.control.answer_to(1)->who.starts_with("bob"));
  run.ask("And the cable?");
  CHECK(say("asked", to_string(Command::kResume)).taken);
  CHECK(run.control.answer_to(2)->text.empty());
  CHECK(run.control.consume_resume());
}

// A run waits, vented, while the compressed air is missing, and continues once it has been back for a while.

namespace {

bench::RunRequest request_with(double lost_at_s, double lasts_s, double timeout_s) {
  bench::RunRequest request =
      small_request({{"environment.sensor", "[{quantity = 'supply_bar', unit = 9, address = 20, type = 'f32'}]"}});
  request.recipes = {
      small_recipe(fmt::format("[[suspend]]\nquantity = \"supply_bar\"\ntrip_below = 6\nresume_above = 6.5\n"
                               "hold_s = 2\ntimeout_s = {}\n",
                               timeout_s))};
  request.bench.simulation->plant.faults = {planned_fault(bench::FaultKind::kSupplyLost, lost_at_s, lasts_s, 0.001)};
  return request;
}

}  // namespace

TEST_CASE("suspension: a supply that does not return ends the run, which can be resumed") {
  QuickStore store;
  const bench::RunResult ended = run_small(request_with(45.0, 1e6, 10.0), store);
  REQUIRE(ended.error);
  CHECK(ended.error->id() == "TB-RUN-SUSPENDED");
  CHECK(ended.safe == db::SafeState::kVerified);
  bench::RunRequest again = request_with(1e6, 1.0, 10.0);
  again.resume = ended.run;
  const bench::RunResult result = run_small(again, store);
  if (result.error) FAIL(result.error->what());
  CHECK(analysis::load_dataset(store, result.run).sequences.at(0).repeats.size() == 2);
}

TEST_CASE("suspension: the wait is not learned as time of the recipe") {
  std::vector<double> learned;
  for (const double lasts_s : {0.0, 30.0}) {
    QuickStore store;
    const bench::RunRequest request = request_with(lasts_s > 0.0 ? 45.0 : 1e6, lasts_s, 600.0);
    const bench::RunResult result = run_small(request, store);
    if (result.error) FAIL(result.error->what());
    CHECK(result.waiting_seconds == Approx(lasts_s).margin(8.0));
    bench::TimeEstimate estimate(request.recipes, sequences::compile(request.recipes), sequences::TimeModel());
    estimate.learn(store, request.bench.id, request.overrides, false);
    CHECK(estimate.total().runs == 1);
    learned.push_back(estimate.total().p50_s);
  }
  CHECK(learned[1] == Approx(learned[0]).epsilon(0.05));
}
