// A new store for a test, and processes next to the test's own.
#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>

#include "tests/db/store_example.h"
#include "tests/support/process.h"

namespace tactbench::tests {

// A new store in a folder that is removed with it.
class NewStore : TemporaryFolder, public db::RunStore {
 public:
  NewStore() : RunStore(open(TemporaryFolder::path("runs.db"))) {}
  using RunStore::path;
};

// The exit code of `action` in a separate process.
template <class Action>
int in_child(Action action) {
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) _exit(action());
  int status = 0;
  REQUIRE(waitpid(child, &status, 0) == child);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace tactbench::tests
