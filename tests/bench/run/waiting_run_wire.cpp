// Runs that wait for a person: what a client of the run is told meanwhile, what the person is told, what is done for
// --on-event, and what the run writes down of it. How long it waits differs from time to time, so no time is compared.

#include <fmt/format.h>
#include <catch2/catch.hpp>

#include <algorithm>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "bench/run/control/control_client.h"
#include "bench/run/time_estimate.h"
#include "db/sqlite.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/bench/run/kill_record.h"
#include "tests/bench/run/quick_store.h"
#include "tests/support/endless_run.h"
#include "tests/support/live_runs.h"
#include "tests/support/process.h"
#include "tests/support/small_run.h"
#include "tests/support/text.h"

using namespace tactbench;
using namespace tactbench::tests;
using Texts = std::vector<std::string>;
using bench::Command;
using bench::ExitCode;
using bench::RunState;

namespace {

// Asks a run until it ends, and acts once on each question, and on each pause without one and each suspension that is
// seen.
class PersonAtTheRun {
 public:
  using Act = std::function<void(const std::string& name, const bench::RunStatus& status)>;
  PersonAtTheRun(std::string name, Act act)
      : thread_([asked = std::move(name), acts = std::move(act)] { watch(asked, acts); }) {}
  ~PersonAtTheRun() { thread_.join(); }
  PersonAtTheRun(const PersonAtTheRun&) = delete;
  PersonAtTheRun& operator=(const PersonAtTheRun&) = delete;

 private:
  static void watch(const std::string& name, const Act& act) {
    int answered = 0;
    for (auto live = bench::send_command(name, Command::kStatus); live;
         live = bench::send_command(name, Command::kStatus)) {
      const bench::RunStatus& status = live->status;
      const bool unanswered = status.question.empty() || status.question_id > answered;
      if (status.state == RunState::kSuspended || (status.state == RunState::kPaused && unanswered)) {
        answered = std::max(answered, status.question_id);
        act(name, status);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  }
  std::thread thread_;
};

// Changes of state by their states; what was proved safe, a way back and a question without an answer by their kind.
Texts course_of(const db::RunStore& store) {
  Texts course;
  for (const db::EventRecord& event : store.events(1)) {
    if (event.kind == "state") course.push_back(event.detail.substr(0, event.detail.find(':')));
    if (event.kind == "safe" || event.kind == "way-back" || event.kind == "prompt") course.push_back(event.kind);
  }
  return course;
}

// Repeat, branch, attempt, and whether it is void.
Texts branches_of(const db::RunStore& store) {
  Texts branches;
  for (const db::BranchRecord& branch : store.branches(1))
    branches.push_back(
        fmt::format("{}.{}.{}{}", branch.repeat, branch.ordinal, branch.attempt, branch.is_void ? " void" : ""));
  return branches;
}

struct WaitingRun {
  bench::RunRequest request = small_request();
  // Runs it with a person at it; `act` of the person, `at_step` in the run itself.
  bench::RunResult carry_out(const PersonAtTheRun::Act& act,
                             const std::function<void(const std::string& name, const sequences::Step&)>& at_step) {
    request.on_event = "echo \"$TACTBENCH_EVENT $TACTBENCH_RUN $TACTBENCH_REASON\" >>" + folder.path("events");
    std::unique_ptr<PersonAtTheRun> person;
    std::string name;
    request.on_step = [&](const sequences::Step& step) {
      if (!person) {
        name = live_runs().at(0).name;
        person = std::make_unique<PersonAtTheRun>(name, act);
      }
      at_step(name, step);
    };
    Captured errors(stderr);
    bench::RunResult result = run_small(request, store);
    person.reset();
    notes = lines_of(errors.text());
    return result;
  }
  // It is paused once in that branch, resumed, and completes.
  void rest_before(int repeat, int branch) {
    bool asked = false;
    const bench::RunResult result = carry_out(
        [](const std::string& name, const bench::RunStatus&) { (void)bench::send_command(name, Command::kResume); },
        [&](const std::string& name, const sequences::Step& step) {
          if (asked || step.repeat != repeat || step.branch != branch) return;
          asked = true;
          (void)bench::send_command(name, Command::kPause);
        });
    CHECK(result.outcome == db::Outcome::kCompleted);
  }
  // The commands for the events run in the background, in parallel.
  [[nodiscard]] Texts reported_events(std::size_t count) const {
    const auto told = [path = folder.path("events")] {
      return std::filesystem::exists(path) ? lines_of(read_file(path)) : Texts();
    };
    CHECK(comes_true([&] { return told().size() >= count; }));
    Texts sorted = told();
    std::ranges::sort(sorted);
    return sorted;
  }
  const TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
  Texts notes;
};

}  // namespace

TEST_CASE("waiting run: two questions and a pause are asked, answered, reported and stored") {
  WaitingRun run;
  run.request.recipes = {
      recipe_of("unit = \"psi\"\nturning_points = [0, 8, 0]\nstep = 4\n[prompt]\nbefore = \"mount it\"\n"
                "[conditioning]\ncycles = 1\npeak = 8\n"),
      recipe_of("unit = \"psi\"\nturning_points = [0, 4]\nstep = 4\n[prompt]\nbefore = \"turn it\"\n")};
  const bench::TimeEstimate estimate(run.request.recipes, sequences::compile(run.request.recipes),
                                     time_model(run.request.bench));
  run.request.estimate = &estimate;
  std::vector<bench::RunStatus> seen;
  const bench::RunResult result = run.carry_out(
      [&](const std::string& name, const bench::RunStatus& status) {
        if (status.question.empty()) {
          (void)bench::send_command(name, Command::kResume);
          return;
        }
        seen.push_back(status);
        const std::string words = status.question_id == 1 ? bench::answer_packet(1, "all done", "bob") : "resume";
        bench::RunConnection connection(name, words);
        (void)comes_true([&] { return connection.newest().has_value() || !connection.open(); });
      },
      [&](const std::string& name, const sequences::Step& step) {
        if (step.kind == sequences::StepKind::kMeasure && step.sequence == 0 && step.ordinal == 0)
          (void)bench::send_command(name, Command::kPause);
      });
  CHECK(result.outcome == db::Outcome::kCompleted);
  CHECK(std::ranges::none_of(run.store.branches(1), &db::BranchRecord::is_void));  // a pause comes between branches
  CHECK(result.waiting_seconds > 0.5);                                             // three waits of at least 0.2 s
  REQUIRE(seen.size() == 2);
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(seen[i].question == (i == 0 ? "mount it" : "turn it"));
    CHECK(seen[i].question_id == static_cast<int>(i) + 1);
    CHECK(seen[i].prompts_left == 2 - static_cast<int>(i));
    CHECK((seen[i].step == (i == 0 ? 0 : 8) && seen[i].steps == 11 && seen[i].frames == (i == 0 ? 0 : 5)));
    CHECK((seen[i].left_low_s < seen[i].left_s && seen[i].left_s < seen[i].left_high_s));
  }
  CHECK(seen[1].left_s < seen[0].left_s);
  CHECK(course_of(run.store) == Texts{"prepared -> running", "safe", "running -> pausing", "pausing -> paused",
                                      "paused -> running", "running -> pausing", "safe", "pausing -> paused",
                                      "paused -> running", "way-back", "safe", "running -> pausing",
                                      "pausing -> paused", "paused -> running", "running -> stopping", "safe"});
  const auto events = run.store.events(1);
  CHECK(std::ranges::any_of(events, [](const db::EventRecord& event) {  // whose answer it was, and which
    return event.kind == "state" && event.detail.find("bob") != std::string::npos &&
           event.detail.find("all done") != std::string::npos;
  }));
  for (const char* told : {"mount it", "turn it", "tactbench resume 1"}) {
    CHECK(
        std::ranges::any_of(run.notes, [&](const std::string& line) { return line.find(told) != std::string::npos; }));
  }
  const Texts told = run.reported_events(4);
  REQUIRE(told.size() == 4);
  CHECK(told[0].starts_with("done 1 "));
  for (std::size_t i = 1; i < 4; ++i) CHECK(told[i].starts_with("waiting 1 "));
  CHECK((told[1].ends_with("mount it") && told[3].ends_with("turn it")));
}

TEST_CASE("waiting run: after a rest longer than the recipe allows only the current repeat is measured again") {
  WaitingRun run;
  run.request.recipes = {
      recipe_of("unit = \"psi\"\nturning_points = [0, 4, 0]\nstep = 4\nrepeats = 2\nrest_restart_s = 0.1\n")};
  run.rest_before(1, 0);
  CHECK(branches_of(run.store) == Texts{"0.0.0", "0.1.0", "1.0.0 void", "1.0.1", "1.1.0"});
}

TEST_CASE("waiting run: after a long rest the branches of an earlier process are measured again, too") {
  WaitingRun run;
  run.request.recipes = {recipe_of("unit = \"psi\"\nturning_points = [0, 4, 0, 4]\nstep = 4\nrest_restart_s = 0.1\n")};
  run.request.on_step = [](const sequences::Step& step) {
    if (step.branch == 1) throw std::runtime_error("power cut");
  };
  CHECK(run_small(run.request, run.store).outcome == db::Outcome::kFailed);
  db::sqlite::Connection(run.store.path(), db::sqlite::Access::kReadWrite)
      .execute("UPDATE runs SET ended_utc = '2999-01-01T00:00:00Z'");  // between the processes it did not rest
  run.request.resume = 1;
  run.rest_before(0, 1);
  CHECK(branches_of(run.store) == Texts{"0.0.0 void", "0.1.0 void", "0.1.1 void", "0.0.1", "0.1.2", "0.2.0"});
}

TEST_CASE("waiting run: with --yes no question is asked, and that is recorded") {
  WaitingRun run;
  run.request.assume_yes = true;
  run.request.recipes = {
      recipe_of("unit = \"psi\"\nturning_points = [0, 4]\nstep = 4\n[prompt]\nbefore = \"mount it\"\n")};
  CHECK(run_small(run.request, run.store).outcome == db::Outcome::kCompleted);
  CHECK(course_of(run.store) == Texts{"prepared -> running", "prompt", "running -> stopping", "safe"});
}

TEST_CASE("waiting run: status and progress while the supply is missing, and until the run has ended") {
  WaitingRun run;
  run.request =
      small_request({{"environment.sensor", "[{quantity = 'supply_bar', unit = 9, address = 20, type = 'f32'}]"}});
  run.request.recipes = {small_recipe(
      "[[suspend]]\nquantity = \"supply_bar\"\ntrip_below = 6\nresume_above = 6.5\nhold_s = 2\ntimeout_s = 600\n")};
  run.request.bench.simulation->plant.faults = {planned_fault(bench::FaultKind::kSupplyLost, 45.0, 8.0, 0.001)};
  Texts seen;  // of the person's thread until it has ended
  const bench::RunResult result =
      run.carry_out([&](const std::string&, const bench::RunStatus& status) { seen.push_back(status.reason); },
                    [](const std::string&, const sequences::Step&) {});
  CHECK(result.outcome == db::Outcome::kCompleted);
  REQUIRE_FALSE(seen.empty());
  for (const std::string& reason : seen) CHECK_THAT(reason, Catch::Contains("supply_bar") && Catch::Contains("0.00"));
  REQUIRE(run.notes.size() == 1);
  CHECK_THAT(run.notes[0], Catch::Contains("run 1") && Catch::Contains("supply_bar"));
  const Texts told = run.reported_events(2);
  REQUIRE(told.size() == 2);
  CHECK((told[0].starts_with("done 1 ") && told[1].starts_with("waiting 1 supply_bar")));
}

// A run that was interrupted and is opened again, in this process and under the manual clock.
// kill_campaign_realtime.cpp does it with SIGKILL.

namespace {

struct PowerCut : std::runtime_error {
  PowerCut() : std::runtime_error("power cut") {}
};

constexpr int kFrames = 15, kRepeats = 2;

// Ends a run at the `at`-th step that is carried out (from 0).
std::function<void(const sequences::Step&)> cut_at(int at) {
  return [at, seen = 0](const sequences::Step&) mutable {
    if (seen++ == at) throw PowerCut();
  };
}

struct Interrupted {
  Interrupted() {
    const auto compiled = sequences::compile(small_recipe(), 0);
    steps = static_cast<int>(compiled.size());
    for (const sequences::BranchSpan& span : sequences::branches(compiled)) {
      if (span.kind == sequences::SpanKind::kBranch) starts.push_back(static_cast<int>(span.first));
    }
  }
  bench::RunResult run_until(int at) {
    bench::RunRequest request = small_request();
    request.on_step = cut_at(at);
    return run_small(request, store);
  }
  bench::RunResult resume(std::int64_t run, const std::function<void(bench::RunRequest&)>& change = {}) {
    bench::RunRequest request = small_request();
    request.resume = run;
    if (change) change(request);
    return run_small(request, store);
  }
  // As if the run had ended so much earlier.
  void age(std::int64_t run, const std::string& how_much) {
    const auto earlier = [&](const std::string& column) {
      return fmt::format("{0} = strftime('%Y-%m-%dT%H:%M:%SZ', {0}, '-{1}')", column, how_much);
    };
    db::sqlite::Connection raw(store.path(), db::sqlite::Access::kReadWrite);
    raw.execute(fmt::format("UPDATE runs SET {}, {}, {} WHERE run = {}", earlier("started_utc"), earlier("seen_utc"),
                            earlier("ended_utc"), run));
  }
  [[nodiscard]] std::vector<std::string> void_reasons(std::int64_t run) const {
    std::vector<std::string> reasons;
    for (const db::BranchRecord& branch : store.branches(run)) {
      if (branch.is_void) {
        reasons.push_back(fmt::format("{}/{} {}", branch.repeat, branch.ordinal, branch.void_reason));
      }
    }
    return reasons;
  }
  [[nodiscard]] bool has_event(std::int64_t run, const std::string& kind) const {
    const std::vector<db::EventRecord> events = store.events(run);
    return std::any_of(events.begin(), events.end(), [&](const auto& event) { return event.kind == kind; });
  }
  void check_final_set(std::int64_t run) const {
    const FinalSet set = judge_final_set(store, run, kFrames, kRepeats);
    CHECK(set.faults == std::vector<std::string>());
    CHECK(set.doubled == 0);
  }
  QuickStore store;
  int steps = 0;            // of small_recipe()
  std::vector<int> starts;  // those at which a branch begins
};

template <class Work>
std::string error_id_of(const Work& work) {
  try {
    work();
  } catch (const bench::Error& error) {
    CHECK(error.code() == ExitCode::kUsage);
    return error.id();
  }
  return "none";
}

}  // namespace

TEST_CASE("resume: interrupted at or inside any branch, complete branches are kept, the incomplete one is repeated") {
  Interrupted bench;
  REQUIRE(bench.starts.size() == 8);
  std::vector<int> moments = {0, 1};  // conditioning
  for (const int start : bench.starts) moments.insert(moments.end(), {start, start + 2});
  for (const int moment : moments) {
    INFO("interrupted at step " << moment << " of " << bench.steps);
    const std::int64_t run = bench.run_until(moment).run;
    REQUIRE(bench.store.run(run).outcome == db::Outcome::kFailed);
    const std::vector<std::string> before = committed_frames(bench.store.path(), run);
    const auto branches_before = bench.store.branches(run);
    const bench::RunResult resumed = bench.resume(run);
    REQUIRE_FALSE(resumed.error);
    CHECK(resumed.run == run);
    bench.check_final_set(run);
    std::vector<std::string> after = committed_frames(bench.store.path(), run);
    REQUIRE(after.size() >= before.size());
    after.resize(before.size());
    CHECK(after == before);
    // The branch under way alone was voided: those before it were whole.
    const auto reasons = bench.void_reasons(run);
    if (branches_before.empty()) {
      CHECK(reasons.empty());
    } else {
      REQUIRE(reasons.size() == 1);
      CHECK(bench.has_event(run, "way-back") == (branches_before.size() > 1));
    }
    CHECK(bench.store.branches(run).size() == 8 + reasons.size());
  }
}

TEST_CASE("resume: after a long rest the whole repeat is measured again, after a short one only the branch") {
  Interrupted bench;
  const auto [rest, voids] = GENERATE(table<std::string, std::size_t>({{"2 hours", 3}, {"10 minutes", 1}}));
  const std::int64_t run = bench.run_until(bench.starts[6] + 1).run;  // branch 2 of the second repeat
  bench.age(run, rest);
  const std::int64_t ended_ns = bench.store.last_time_ns(run);
  REQUIRE_FALSE(bench.resume(run).error);
  bench.check_final_set(run);
  const auto reasons = bench.void_reasons(run);
  REQUIRE(reasons.size() == voids);
  for (const std::string& reason : reasons) CHECK_THAT(reason, Catch::StartsWith("1/"));
  if (voids == 3) {
    for (const std::size_t i : {0U, 1U}) CHECK_THAT(reasons[i], Catch::Contains("72"));  // 7200 s
    CHECK(bench.store.frames(run).back().time_ns > ended_ns + 7'200'000'000'000);        // time in the run went on
  }
}

TEST_CASE("resume: a run that died before its devices were stored gets them stored") {
  Interrupted bench;
  bench::RunRequest request = small_request();
  request.on_begun = [](std::int64_t) { throw PowerCut(); };
  CHECK_THROWS_AS(run_small(request, bench.store), PowerCut);
  CHECK(bench.store.mark_interrupted(bench::utc_now()) == 1);
  CHECK(bench.store.run(1).devices.empty());
  REQUIRE_FALSE(bench.resume(1).error);
  CHECK(bench.store.run(1).devices.size() == 4);
  bench.check_final_set(1);
}

TEST_CASE("resume: a run interrupted repeatedly, even on its return path, is completed") {
  Interrupted bench;
  const std::int64_t run = bench.run_until(bench.starts[5] + 1).run;
  for (int at = 0; at < 9; ++at) {  // conditioning, turning points, first frames of the branch
    CHECK(bench.resume(run, [&](bench::RunRequest& request) { request.on_step = cut_at(at); }).error);
  }
  REQUIRE_FALSE(bench.resume(run).error);
  bench.check_final_set(run);
}

TEST_CASE("resume: is rejected for a completed run, other recipes, other steps or another scanner") {
  Interrupted bench;
  const std::int64_t completed = bench.run_until(-1).run;
  CHECK(error_id_of([&] { (void)bench.resume(completed); }) == "TB-RUN-COMPLETED");
  const std::int64_t run = bench.run_until(bench.starts[2] + 1).run;
  const std::string hash = bench.store.run(run).content_sha256;
  CHECK(error_id_of([&] {
          (void)bench.resume(run,
                             [](bench::RunRequest& request) { request.recipes = {small_recipe("dwell_s = 3\n")}; });
        }) == "TB-RUN-CHANGED");
  CHECK(error_id_of([&] {
          (void)bench.resume(run, [](bench::RunRequest& request) {  // the same text, compiled otherwise
            request.recipes.front().step = devices::Psi(4.0);
          });
        }) == "TB-RUN-CHANGED");
  CHECK(bench.store.run(run).content_sha256 == hash);  // nothing touched
  CHECK(bench.store.content_hash(run) == hash);
  const bench::RunResult other = bench.resume(run, [](bench::RunRequest& request) {
    request.bench = small_request({{"simulation.scanner_serial", "\"SIM-SCANNER-2\""}}).bench;
  });
  REQUIRE(other.error);
  CHECK(other.error->id() == "TB-RESUME-DEVICES");
  CHECK(other.error->code() == ExitCode::kDevice);
  REQUIRE_FALSE(bench.resume(run).error);
  bench.check_final_set(run);
}

TEST_CASE("resume: in the second sequence the first one is kept, conditioning is repeated") {
  Interrupted bench;
  const auto which = GENERATE(0U, 1U, 2U, 3U);
  const int moment = bench.steps + std::vector<int>{0, 1, bench.starts[0] + 1, bench.starts[3] + 1}.at(which);
  bench::RunRequest request = small_request();
  request.recipes = {small_recipe(), small_recipe("dwell_s = 1\n")};
  request.on_step = cut_at(moment);
  const std::int64_t run = run_small(request, bench.store).run;
  INFO("interrupted at step " << moment << " of " << bench.steps);
  REQUIRE(bench.store.run(run).outcome == db::Outcome::kFailed);
  request.on_step = nullptr;
  request.resume = run;
  REQUIRE_FALSE(run_small(request, bench.store).error);
  std::map<sequences::BranchKey, int> valid;
  for (const db::BranchRecord& branch : bench.store.branches(run)) {
    INFO(branch.sequence << '/' << branch.repeat << '/' << branch.ordinal << ' ' << branch.void_reason);
    CHECK((branch.sequence == 1 || !branch.is_void));
    valid[{branch.sequence, branch.repeat, branch.ordinal}] += branch.is_void ? 0 : 1;
  }
  CHECK(valid.size() == 16);
  for (const auto& [key, count] : valid) CHECK(count == 1);
  CHECK(analysis::load_dataset(bench.store, run).sequences.size() == 2);
}

TEST_CASE("resume: kept frames and the end position count the whole run, not only the last process") {
  Interrupted bench;
  const std::int64_t run = bench.run_until(bench.starts[5] + 1).run;
  const std::int64_t before = bench.store.frame_count(run);
  REQUIRE(before > 0);
  for (const int more : {0, 9}) {  // at once, and after some frames
    const bench::RunResult broken =
        bench.resume(run, [&](bench::RunRequest& request) { request.on_step = cut_at(more); });
    const std::int64_t kept = bench.store.frame_count(run);
    CHECK((kept > before) == (more > 0));
    CHECK(broken.frames_kept == kept);
    REQUIRE(broken.error);
    CHECK_THAT(broken.error->rig_state(), Catch::Contains(fmt::format("{} frames", kept)));
    CHECK_THAT(broken.error->where(),
               Catch::Contains(fmt::format("{}", run)) && Catch::EndsWith(fmt::format(" {}", kept)));
  }
  const bench::RunResult whole = bench.resume(run);
  CHECK(whole.frames_kept == bench.store.frame_count(run));
}

TEST_CASE("time estimate: a resumed run is used like an uninterrupted one") {
  Interrupted bench;
  const auto learned = [&](int runs) {
    const std::vector<sequences::Recipe> recipes = {small_recipe()};
    bench::TimeEstimate estimate(recipes, sequences::compile(recipes), sequences::TimeModel());
    estimate.learn(bench.store, bench.store.run(1).bench_id, {}, true);
    CHECK(estimate.total().runs == runs);
    return estimate.total();
  };
  (void)bench.run_until(-1);
  const bench::TimeBand unbroken = learned(1);
  for (const int moment : {bench.starts[1] + 1, bench.starts[5] + 1}) {
    const std::int64_t run = bench.run_until(moment).run;
    bench.age(run, "10 minutes");
    REQUIRE_FALSE(bench.resume(run).error);
  }
  const bench::TimeBand all = learned(3);
  CHECK(all.p50_s == Approx(unbroken.p50_s).epsilon(0.03));
  CHECK(all.p90_s < 1.15 * unbroken.p50_s);
}
