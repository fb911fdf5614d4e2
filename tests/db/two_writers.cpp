// Two processes at one run: each changes the state that it has checked, and a run that another ended is not written.
#include <sqlite3.h>
#include <sys/wait.h>
#include <unistd.h>
#include <catch2/catch.hpp>

#include <array>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "db/schema.h"
#include "db/sqlite.h"
#include "tests/db/new_store.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::RunStore;
using db::sqlite::Access;
using db::sqlite::Connection;

namespace {

constexpr int kGoesOn = 0, kRefused = 5, kOther = 9;

int resume_in_child(const std::string& path, int start) {
  char none = 0;
  if (read(start, &none, 1) != 0) return kOther;  // until the parent closes its end
  const std::string id = store_error([&] {
    RunStore store = RunStore::open(path);
    store.reopen_run(1, {9, "state", "", "ended -> prepared: resumed"});
  });
  return id.empty() ? kGoesOn : id == "TB-STORE-CONFLICT" ? kRefused : kOther;
}

// Starts `count` processes that resume run 1; `held`: all of them wait for the store when it becomes free.
std::map<int, int> resume_at_once(const std::string& path, int count, bool held) {
  std::array<int, 2> ends{};
  REQUIRE(pipe(ends.data()) == 0);
  std::vector<pid_t> children;
  for (int i = 0; i < count; ++i) {
    const pid_t child = fork();
    REQUIRE(child >= 0);
    if (child == 0) {
      close(ends[1]);
      _exit(resume_in_child(path, ends[0]));
    }
    children.push_back(child);
  }
  close(ends[0]);
  {
    Connection holder(path, Access::kReadWrite);
    std::unique_ptr<db::sqlite::Transaction> transaction;
    if (held) transaction = std::make_unique<db::sqlite::Transaction>(holder);
    close(ends[1]);
    if (held) usleep(300'000);
  }
  std::map<int, int> fates;
  for (const pid_t child : children) {
    int status = 0;
    REQUIRE(waitpid(child, &status, 0) == child);
    ++fates[WIFEXITED(status) ? WEXITSTATUS(status) : -1];
  }
  return fates;
}

}  // namespace

TEST_CASE("run store: if several processes resume a run at the same time, only one succeeds, and the run verifies") {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  {
    RunStore store = RunStore::open(path);
    const Begun begun = begin_example(store);
    store.append_frame(begun.run, example_frame(begun.branch, 0));
    REQUIRE(store.mark_interrupted(kUtc) == 1);
  }
  for (int round = 0; round < 20; ++round) {
    CAPTURE(round);
    const std::map<int, int> fates = resume_at_once(path, 3, round < 5);
    CHECK(fates == std::map<int, int>{{kGoesOn, 1}, {kRefused, 2}});
    RunStore store = RunStore::open(path);
    CHECK(store.events(1).size() == static_cast<std::size_t>(2 * round + 2));  // interrupted and resumed, each once
    CHECK(store.check_content(1).holds());
    REQUIRE(store.mark_interrupted(kUtc) == 1);
    CHECK(store.check_content(1).holds());
  }
}

TEST_CASE("run store: a run that another process ended accepts no more rows, and still verifies") {
  NewStore own;
  RunStore other = RunStore::open(own.path());
  const Begun begun = begin_example(own);
  own.append_frame(begun.run, example_frame(begun.branch, 0));
  REQUIRE(other.mark_interrupted(kUtc) == 1);
  CHECK(store_error([&] { own.append_frame(begun.run, example_frame(begun.branch, 1)); }) == "TB-STORE-CONFLICT");
  const auto begun_anew = [&](auto action) {  // each as the first to notice
    other.reopen_run(begun.run, {9, "state", "", "resumed"});
    own.set_seen(begun.run, kUtc);
    REQUIRE(other.mark_interrupted(kUtc) == 1);
    return store_error(action);
  };
  db::BranchRecord branch = example_branch();
  branch.attempt = 1;
  CHECK(begun_anew([&] { own.begin_branch(begun.run, branch); }) == "TB-STORE-CONFLICT");
  CHECK(begun_anew([&] { own.void_branch(begun.branch, "late"); }) == "TB-STORE-CONFLICT");
  CHECK(begun_anew([&] { own.set_state(begun.run, "running", {1, "state", "", ""}); }) == "TB-STORE-CONFLICT");
  CHECK(begun_anew([&] { own.append_event(begun.run, {1, "note", "", ""}); }) == "TB-STORE-CONFLICT");
  CHECK(begun_anew([&] {
          own.append_check(begun.run, {begun.run, 1, "tare", "pass", "{}", {}});
        }) == "TB-STORE-CONFLICT");
  CHECK(begun_anew([&] { own.append_series(begun.run, {{0, 0, {1.0}, {2.0}}}); }) == "TB-STORE-CONFLICT");
  CHECK(begun_anew([&] { own.end_run(begun.run, db::Outcome::kFailed, "late", {}, kUtc); }) == "TB-STORE-CONFLICT");
  CHECK(other.frame_count(begun.run) == 1);
  CHECK(other.run(begun.run).outcome == db::Outcome::kInterrupted);
  CHECK(other.check_content(begun.run).holds());
}

TEST_CASE("run store: a run that was changed after its end is not resumed") {
  NewStore store;
  const Begun begun = begin_example(store);
  store.append_frame(begun.run, example_frame(begun.branch, 0));
  store.append_check(begun.run, {begun.run, 4, "seating", "fail", "{}", {}});
  store.end_run(begun.run, db::Outcome::kStopped, "stopped", db::SafeState::kVerified, kUtc);
  Connection(store.path(), Access::kReadWrite).execute("DELETE FROM checks");
  CHECK(store_error([&] { store.reopen_run(begun.run, {9, "state", "", "resumed"}); }) == "TB-STORE-CONFLICT");
  CHECK(store.run(begun.run).outcome == db::Outcome::kStopped);
  CHECK(store.events(begun.run).empty());
  CHECK_FALSE(store.check_content(begun.run).holds());
}

namespace {

// Makes the tables of a store just before another connection, `watched`, lists what there is in the same file.
struct MakesMeanwhile {
  std::string path;
  int made = 0, held_off = 0;
};

int make_before_listing(unsigned /*kind*/, void* context, void* /*statement*/, void* text) {
  if (std::string(static_cast<const char*>(text)).find("FROM main.sqlite_master") == std::string::npos) return 0;
  auto& maker = *static_cast<MakesMeanwhile*>(context);
  Connection other(maker.path, Access::kReadWrite, 0);
  ++(store_error([&] { db::migrate(other); }).empty() ? maker.made : maker.held_off);
  return 0;
}

}  // namespace

TEST_CASE("foreign objects: tables that another process creates during the check are not foreign") {
  const TemporaryFolder folder;
  MakesMeanwhile maker{folder.path("runs.db")};
  Connection watched(maker.path, Access::kReadWrite);
  REQUIRE(sqlite3_trace_v2(watched.handle(), SQLITE_TRACE_STMT, make_before_listing, &maker) == SQLITE_OK);
  const db::ForeignObjects found = db::foreign_objects(watched);
  CHECK((found.changed.empty() && found.added.empty()));
  CHECK(maker.made + maker.held_off == 1);
}
