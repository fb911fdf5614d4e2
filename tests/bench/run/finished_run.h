// A run on the simulated rig in a temporary store: what it reported while it ran and what it left. Checks the
// invariants of every run with it, however it ends. Not for runs that are resumed.
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "db/run_store.h"
#include "tests/support/live_runs.h"
#include "tests/support/process.h"
#include "tests/support/small_run.h"

namespace tactbench::tests {

inline double in_s(std::int64_t ns) { return static_cast<double>(ns) * 1e-9; }

class FinishedRun {
 public:
  explicit FinishedRun(bench::RunRequest request) {
    request.on_step = [this, own = request.on_step](const sequences::Step& step) {
      if (own) own(step);
      const std::vector<bench::LiveRun> live = live_runs();
      if (live.size() == 1) told.push_back(live.front().status);
    };
    result = run_small(request, store);
    frames = store.frames(result.run);
    branches = store.branches(result.run);
    for (const db::FrameRecord& frame : frames) void_frames += branch_of(frame).is_void ? 1 : 0;
    check_laws();
  }
  [[nodiscard]] const db::BranchRecord& branch_of(const db::FrameRecord& frame) const {
    return *std::ranges::find(branches, frame.branch, &db::BranchRecord::branch);
  }
  // Of the events of these kinds, in the order of time: a change of state by its states, others by kind and id.
  [[nodiscard]] std::vector<std::string> course(const std::set<std::string>& kinds) const {
    std::vector<std::string> course;
    for (const db::EventRecord& event : store.events(result.run)) {
      if (!kinds.contains(event.kind)) continue;
      const std::string more = event.kind == "state" ? event.detail.substr(0, event.detail.find(':')) : event.id;
      course.push_back(more.empty() ? event.kind : event.kind + " " + more);
    }
    return course;
  }
  // Kind and verdict.
  [[nodiscard]] std::vector<std::string> checks() const {
    std::vector<std::string> checks;
    for (const db::CheckRecord& check : store.checks(result.run)) checks.push_back(check.kind + " " + check.verdict);
    return checks;
  }
  [[nodiscard]] std::vector<std::string> flags() const {
    std::vector<std::string> flags;
    for (const db::FrameRecord& frame : frames) flags.push_back(frame.flags);
    return flags;
  }
  [[nodiscard]] int voids() const {
    return static_cast<int>(std::ranges::count_if(branches, &db::BranchRecord::is_void));
  }

  const TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
  bench::RunResult result;
  std::vector<bench::RunStatus> told;  // to a client, as each step began
  std::vector<db::FrameRecord> frames;
  std::vector<db::BranchRecord> branches;
  std::int64_t void_frames = 0;

 private:
  // Of every run, however it ends.
  void check_laws() const {
    CHECK(result.frames_kept == static_cast<std::int64_t>(frames.size()));
    CHECK(result.content_sha256 == store.content_hash(result.run));
    CHECK(store.run(result.run).safe_state == result.safe);
    CHECK((result.outcome == db::Outcome::kCompleted) == !result.error);
    CHECK(store.run(result.run).outcome == result.outcome);
    std::int64_t stored = 0;
    for (const bench::RunStatus& status : told) {
      CHECK(status.step <= status.steps);
      CHECK(status.frames <= status.frames_planned);  // those of void branches are counted apart
      CHECK(status.frames_void <= void_frames);
      CHECK(status.frames + status.frames_void >= stored);
      stored = status.frames + status.frames_void;
    }
    CHECK(stored <= result.frames_kept);
    if (!told.empty()) CHECK(static_cast<std::int64_t>(frames.size()) - void_frames <= told.back().frames_planned);
    std::map<std::tuple<int, int, int>, int> attempts, valid;
    for (const db::BranchRecord& branch : branches) {
      const std::tuple place(branch.sequence, branch.repeat, branch.ordinal);
      CHECK(branch.attempt == attempts[place]++);
      CHECK((valid[place] += branch.is_void ? 0 : 1) <= 1);
      CHECK(branch.is_void != branch.void_reason.empty());
    }
    std::int64_t last_ns = -1;
    for (const db::FrameRecord& frame : frames) {
      CHECK(frame.time_ns > last_ns);
      CHECK(frame.in_band_ns <= frame.since_command_ns);
      CHECK(has_consistent_shape(frame));
      last_ns = frame.time_ns;
    }
    const auto events = store.events(result.run);
    const auto state = [](const db::EventRecord& event) { return event.kind == "state"; };
    const auto first = std::ranges::find_if(events, state);
    const auto last = std::find_if(events.rbegin(), events.rend(), state);
    REQUIRE(first != events.end());
    CHECK(first->detail.starts_with("prepared -> "));
    CHECK(last->detail.find(" -> stopping") != std::string::npos);
    CHECK(events.back().kind == "safe");
    CHECK(in_s(events.back().time_ns) == Approx(result.process_seconds).margin(0.01));
  }
};

}  // namespace tactbench::tests
