// A run that was interrupted and is opened again, in this process and under the manual clock.
// kill_campaign_realtime.cpp does it with SIGKILL.
#include <catch2/catch.hpp>

#include "bench/run/time_estimate.h"
#include "tests/bench/run/kill_record.h"
#include "tests/bench/run/quick_store.h"
#include "tests/support/small_run.h"

using namespace tactbench;
using namespace tactbench::tests;
using bench::ExitCode;

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
