#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <cstdio>

#include "db/sqlite.h"
#include "tests/db/new_store.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::Durability;
using db::RunStore;

TEST_CASE("run store: a frame is visible to another connection as soon as it is acknowledged") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"), Durability::kNormal);
  const Begun begun = begin_example(store);
  const RunStore reader = RunStore::open_read_only(folder.path("runs.db"));
  for (int i = 0; i < 5; ++i) {
    CHECK(reader.frame_count(begun.run) == i);
    store.append_frame(begun.run, example_frame(begun.branch, i));
    CHECK(reader.frames(begun.run).back().ordinal == i);
  }
  store.set_state(begun.run, "running", {});
  CHECK(reader.run(begun.run).state == "running");
}

TEST_CASE("run store: a run whose process dies keeps every acknowledged frame and becomes interrupted") {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  REQUIRE(in_child([&] {
            auto* store = new RunStore(RunStore::open(path, Durability::kNormal));  // never closed
            const Begun begun = begin_example(*store);
            store->set_state(begun.run, "running", {1, "state", "", ""});
            for (int i = 0; i < 40; ++i) store->append_frame(begun.run, example_frame(begun.branch, i));
            return 9;
          }) == 9);
  RunStore store = RunStore::open(path);
  CHECK(store.run(1).outcome == db::Outcome::kIncomplete);
  store_example(store);  // a run that ended stays as it is
  const std::int64_t prepared = begin_example(store).run;
  store.append_event(prepared, {41, "note", "", ""});
  CHECK(store.frame_count(1) == 40);
  CHECK(store.mark_interrupted("2024-05-01T11:00:00Z") == 2);
  const db::RunRecord run = store.run(1);
  CHECK(run.outcome == db::Outcome::kInterrupted);
  CHECK(run.state == "ended");
  CHECK(run.safe_state == db::SafeState::kUnknown);
  CHECK(run.ended_utc == "2024-05-01T11:00:00Z");
  CHECK_THAT(run.reason, Catch::StartsWith("TB-RUN-INTERRUPTED"));
  CHECK(run.content_sha256 == store.content_hash(1));
  const db::EventRecord event = store.events(1).back();
  CHECK((event.kind == "state" && event.id == "TB-RUN-INTERRUPTED"));
  CHECK_THAT(event.detail, Catch::StartsWith("running -> ended"));
  CHECK_THAT(store.events(prepared).back().detail, Catch::StartsWith("prepared -> ended"));
  CHECK(store.events(prepared).back().time_ns == 41);
  CHECK(event.time_ns == example_frame(1, 39).time_ns);  // the last known time of the run
  CHECK(store.run(2).outcome == db::Outcome::kCompleted);
  CHECK(store.mark_interrupted("2024-05-01T12:00:00Z") == 0);
  CHECK(store.run(1).ended_utc == "2024-05-01T11:00:00Z");
}

// Killed at no chosen point: within a commit as well as between two.
TEST_CASE("run store: SIGKILL at any moment loses no acknowledged frame and leaves an intact file") {
  for (int round = 0; round < 6; ++round) {
    const TemporaryFolder folder;
    const std::string path = folder.path("runs.db");
    int pipe_ends[2];
    REQUIRE(pipe(pipe_ends) == 0);
    const pid_t child = fork();
    REQUIRE(child >= 0);
    if (child == 0) {
      RunStore store = RunStore::open(path, round == 0 ? Durability::kFull : Durability::kNormal);
      const Begun begun = begin_example(store);
      for (int i = 0;; ++i) {
        store.append_frame(begun.run, example_frame(begun.branch, i));
        if (write(pipe_ends[1], &i, sizeof i) != sizeof i) _exit(1);
      }
    }
    close(pipe_ends[1]);
    int last = -1, got = 0;
    while (last < 10 + 41 * round && read(pipe_ends[0], &got, sizeof got) == sizeof got) last = got;
    kill(child, SIGKILL);
    int status = 0;
    REQUIRE(waitpid(child, &status, 0) == child);
    REQUIRE(WIFSIGNALED(status));
    while (read(pipe_ends[0], &got, sizeof got) == sizeof got) last = got;
    close(pipe_ends[0]);
    RunStore store = RunStore::open(path);
    const std::vector<db::FrameRecord> frames = store.frames(1);
    REQUIRE(static_cast<int>(frames.size()) >= last + 1);
    CHECK(static_cast<int>(frames.size()) <= last + 2);
    for (std::size_t i = 0; i < frames.size(); ++i) REQUIRE(frames[i].ordinal == static_cast<int>(i));
    CHECK(store.mark_interrupted("") == 1);
    CHECK(store.content_hash(1) == store.run(1).content_sha256);
    db::sqlite::Connection raw(path, db::sqlite::Access::kReadOnly);
    CHECK(raw.text("PRAGMA integrity_check") == "ok");
  }
}

TEST_CASE("run store: several processes may create one store at once and write to it at once") {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  constexpr int kWriters = 6;
  constexpr int kFrames = 30;
  std::vector<pid_t> children;
  for (int i = 0; i < kWriters; ++i) {
    const pid_t child = fork();
    REQUIRE(child >= 0);
    if (child == 0) {
      std::string why;
      const std::string id = store_error(
          [&] {
            RunStore store = RunStore::open(path, Durability::kNormal);
            const Begun begun = begin_example(store);
            for (int f = 0; f < kFrames; ++f) store.append_frame(begun.run, example_frame(begun.branch, f));
            store.end_run(begun.run, db::Outcome::kCompleted, "", db::SafeState::kVerified, "");
          },
          &why);
      if (!id.empty()) std::fprintf(stderr, "%s %s\n", id.c_str(), why.c_str());
      _exit(id.empty() ? 0 : 1);
    }
    children.push_back(child);
  }
  for (const pid_t child : children) {
    int status = 0;
    REQUIRE(waitpid(child, &status, 0) == child);
    CHECK((WIFEXITED(status) && WEXITSTATUS(status) == 0));
  }
  const RunStore store = RunStore::open_read_only(path);
  const std::vector<db::RunRecord> runs = store.runs();
  REQUIRE(runs.size() == kWriters);
  for (const db::RunRecord& run : runs) {
    CHECK(store.frame_count(run.run) == kFrames);
    CHECK(run.content_sha256 == runs.front().content_sha256);
    CHECK(store.content_hash(run.run) == run.content_sha256);
  }
}
