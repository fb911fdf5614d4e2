// Copies at their edges: descriptors, names that are taken, and logs that cannot be read along.
#include <fcntl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>

#include "db/sqlite.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::RunStore;

namespace {

std::size_t open_descriptors() {
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) count += entry.path().empty() ? 0 : 1;
  return count;
}

// The exit code of `action` in a process of its own.
template <class Action>
int in_child(Action action) {
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) _exit(action());
  int status = 0;
  REQUIRE(waitpid(child, &status, 0) == child);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace

TEST_CASE("a snapshot leaves no descriptor open, and takes one of any number") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  store_example(store);
  store.snapshot(folder.path("first.db"));
  const std::size_t before = open_descriptors();
  for (int i = 0; i < 5; ++i) store.snapshot(folder.path("copy-" + std::to_string(i) + ".db"));
  store_error([&] { store.snapshot(folder.path("first.db")); });
  CHECK(open_descriptors() == before);
  CHECK(in_child([&] {  // without a standard input the name's file gets its number
          close(0);
          const std::string id = store_error([&] { store.snapshot(folder.path("zero.db")); });
          return id.empty() && std::filesystem::exists(folder.path("zero.db")) ? 0 : 1;
        }) == 0);
}

TEST_CASE("in a read-only folder a store with a log beside it is not read without the log") {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  REQUIRE(in_child([&] {
            auto* store = new RunStore(RunStore::open(path));  // never closed: the log stays
            store_example(*store);
            return 0;
          }) == 0);
  REQUIRE(std::filesystem::file_size(path + "-wal") > 0);
  std::filesystem::remove(path + "-shm");
  chmod(path.c_str(), 0444);
  chmod(folder.path().c_str(), 0555);
  const int code = in_child([&] {
    if (geteuid() == 0 && (setgid(65534) != 0 || setuid(65534) != 0)) return 3;
    return store_error([&] { RunStore::open_read_only(path); }).empty() ? 1 : 0;
  });
  chmod(folder.path().c_str(), 0755);
  CHECK(code == 0);
}

TEST_CASE("all runs that are copied come with their verdicts under seal, the first as well as the last") {
  const TemporaryFolder folder;
  RunStore source = RunStore::open(folder.path("a.db")), target = RunStore::open(folder.path("b.db"));
  db::VerdictRecord verdict;
  verdict.verdict = "pass";
  for (int i = 0; i < 3; ++i) source.replace_verdicts(store_example(source), 0, {verdict});
  store_example(target);
  for (const std::int64_t run : target.copy_runs_from(source, {1, 2, 3})) {
    CAPTURE(run);
    CHECK(target.verdicts(run).size() == 1);
    CHECK(target.check_seals(run).empty());
  }
  CHECK(target.runs().size() == 4);
  CHECK(target.copy_runs_from(source, {}).empty());
}
