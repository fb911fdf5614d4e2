// Programs that this one starts, at their edges: ends that nobody tells of, programs that are let go, and one that ends
// with its starter.
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdlib>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "bench/common/child_process.h"

using namespace tactbench::bench;

namespace {

ChildProgram started(const std::string& line, int output = -1, bool ends_with_us = false) {
  ChildStart start;
  start.words = {"/bin/sh", "-c", line};
  start.environment = environment_with({});
  start.output = output;
  start.ends_with_us = ends_with_us;
  return ChildProgram(std::move(start));
}

// The next line from there; what came so far after 20 s without one.
std::string line_from(int descriptor) {
  std::string line;
  for (pollfd ready{descriptor, POLLIN, 0}; ::poll(&ready, 1, 20'000) == 1;) {
    char c = 0;
    if (::read(descriptor, &c, 1) != 1 || c == '\n') break;
    line += c;
  }
  return line;
}

}  // namespace

TEST_CASE("child program: an end that another took note of counts as 127") {
  for (const bool waits : {true, false}) {
    ChildProgram child = started("exit 3");
    REQUIRE(::waitpid(child.process(), nullptr, 0) == child.process());
    const int status = waits ? child.wait() : child.ended().value_or(-1);
    CHECK((WIFEXITED(status) && WEXITSTATUS(status) == 127));
    CHECK(child.ended() == status);
  }
  ChildProgram first = started("exit 4");
  const ChildProgram second = std::move(first);
  CHECK_FALSE(first.ended());
  CHECK(WEXITSTATUS(first.wait()) == 127);  // moved from: there is none
  CHECK(second.process() > 0);
}

TEST_CASE("child program: its end is waited for up to a time, and is told at once when it has come") {
  ChildProgram child = started("exit 6");
  const auto patient = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  const std::optional<int> status = child.ended_by(patient);
  REQUIRE(status);
  CHECK(WEXITSTATUS(*status) == 6);
  child.terminate();  // nobody is there any more
  ChildProgram endless = started("exec sleep 1000");
  const auto begun = std::chrono::steady_clock::now();
  CHECK_FALSE(endless.ended_by(begun + std::chrono::milliseconds(50)));
  CHECK(std::chrono::steady_clock::now() - begun >= std::chrono::milliseconds(50));
}

TEST_CASE("child program: one that is let go goes on without its object") {
  pid_t process = -1;
  {
    ChildProgram child = started("exec sleep 1000");
    process = child.process();
    child.let_go();
    CHECK(child.process() == -1);
    CHECK_FALSE(child.ended());
    child.terminate();
    child.kill_group();
  }
  int status = 0;
  CHECK(::waitpid(process, &status, WNOHANG) == 0);
  REQUIRE(::kill(process, SIGKILL) == 0);
  CHECK(::waitpid(process, &status, 0) == process);
  CHECK((WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL));
}

TEST_CASE("child program: one that ends with its starter is asked to end when that is gone") {
  std::array<int, 2> ends{-1, -1};
  REQUIRE(::pipe2(ends.data(), O_CLOEXEC) == 0);
  const pid_t starter = ::fork();
  if (starter == 0) {
    ChildProgram child = started("trap 'echo asked; exit 0' TERM; echo ready; while :; do sleep 0.02; done",
                                 ::fcntl(ends[1], F_DUPFD_CLOEXEC, 0), true);
    char byte = 0;
    (void)!::read(ends[0], &byte, 1);  // of "ready"
    child.let_go();
    ::_exit(0);
  }
  int status = -1;
  CHECK(::waitpid(starter, &status, 0) == starter);
  CHECK(status == 0);
  ::close(ends[1]);
  CHECK(line_from(ends[0]) == "eady");
  CHECK(line_from(ends[0]) == "asked");
  ::close(ends[0]);
}
