// Programs that this one starts: how they end, their environment, and that no process of them remains.

#include "bench/common/child_process.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>
#include <catch2/catch.hpp>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "bench/common/error.h"
#include "bench/common/shard.h"

using namespace tactbench::bench;
using tactbench::bench::Error;
using tactbench::bench::Shard;
using tactbench::bench::shard_from;

namespace {

// A pipe: children write to the end passed to them, the test reads the other.
struct ChildOutput {
  ChildOutput() {
    int ends[2];
    REQUIRE(::pipe2(ends, O_CLOEXEC) == 0);
    read_end = ends[0];
    write_end = ends[1];
  }
  ~ChildOutput() { ::close(read_end); }
  // Until nobody holds the other end any more, or `until` has come.
  std::string text(char until = '\0') const {
    std::string all;
    for (char c = 0; ::read(read_end, &c, 1) == 1;) {
      all += c;
      if (c == until) break;
    }
    return all;
  }
  int read_end = -1, write_end = -1;
};

ChildProgram shell_child(const std::string& line, int output = -1, const std::vector<std::string>& variables = {},
                         bool ends_with_parent = false) {
  ChildStart start;
  start.ends_with_parent = ends_with_parent;
  start.arguments = {"/bin/sh", "-c", line};
  start.environment = environment_with(variables);
  start.output = output;
  return ChildProgram(std::move(start));
}

constexpr auto kAtOnce = std::chrono::steady_clock::time_point::min();

}  // namespace

TEST_CASE("child program: arguments and exit code are passed, both output streams go to the descriptor") {
  const ChildOutput output;
  ChildProgram child = shell_child("cat; echo out; echo err >&2; exit 5", output.write_end);
  CHECK(output.text() == "out\nerr\n");  // cat found an empty input
  const int status = child.wait();
  REQUIRE(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 5);
  CHECK(child.wait() == status);
  CHECK(child.ended() == status);
  CHECK(child.ended_by(kAtOnce) == status);
}

TEST_CASE("child program: inherits the environment plus its own variables, each only once") {
  ::setenv("TACTBENCH_CHILD_TEST", "ours", 1);
  ::setenv("TACTBENCH_CHILD_OTHER", "kept", 1);
  const std::vector<std::string> environment = environment_with({"TACTBENCH_CHILD_TEST=its own"});
  CHECK(environment.front() == "TACTBENCH_CHILD_TEST=its own");
  CHECK(std::ranges::count_if(
            environment, [](const std::string& entry) { return entry.starts_with("TACTBENCH_CHILD_TEST="); }) == 1);
  const ChildOutput output;
  ChildProgram child = shell_child("echo $TACTBENCH_CHILD_TEST, $TACTBENCH_CHILD_OTHER", output.write_end,
                                   {"TACTBENCH_CHILD_TEST=its own"});
  CHECK(output.text() == "its own, kept\n");
  CHECK(child.wait() == 0);
  ::unsetenv("TACTBENCH_CHILD_TEST");
  ::unsetenv("TACTBENCH_CHILD_OTHER");
}

TEST_CASE("child program: a failed start reports the reason and closes the descriptor") {
  const ChildOutput output;
  ChildStart start;
  start.arguments = {"/no/such/program"};
  start.output = output.write_end;
  try {
    const ChildProgram child(std::move(start));
    FAIL("started");
  } catch (const std::system_error& error) {
    CHECK(error.code() == std::errc::no_such_file_or_directory);
  }
  CHECK(output.text().empty());
  CHECK((::fcntl(output.write_end, F_GETFD) == -1 && errno == EBADF));
}

TEST_CASE(
    "child program: has its own process group, and default handling of signals that the parent ignores or blocks") {
  const auto before = ::signal(SIGPIPE, SIG_IGN);
  sigset_t pipe_alone, old;
  ::sigemptyset(&pipe_alone);
  ::sigaddset(&pipe_alone, SIGPIPE);
  ::pthread_sigmask(SIG_BLOCK, &pipe_alone, &old);
  const ChildOutput output;
  ChildProgram child =
      shell_child("read id name state parent group rest </proc/$$/stat; echo $group; echo $$; kill -PIPE $$; exit 3",
                  output.write_end);
  const std::string group = output.text('\n'), process = output.text('\n');
  ::pthread_sigmask(SIG_SETMASK, &old, nullptr);
  ::signal(SIGPIPE, before);
  CHECK(group == process);
  const int status = child.wait();
  CHECK((WIFSIGNALED(status) && WTERMSIG(status) == SIGPIPE));
}

TEST_CASE("child program: terminates on request, or is killed with its process group") {
  const ChildOutput told, killed;
  ChildProgram child = shell_child("echo ready; exec sleep 1000", told.write_end);
  REQUIRE(told.text('\n') == "ready\n");
  CHECK_FALSE(child.ended());
  CHECK_FALSE(child.ended_by(kAtOnce));
  child.terminate();
  const int status = child.wait();
  CHECK((WIFSIGNALED(status) && WTERMSIG(status) == SIGTERM));
  ChildProgram parent = shell_child("sleep 1000 & echo ready; wait", killed.write_end);
  REQUIRE(killed.text('\n') == "ready\n");
  parent.kill_group();
  CHECK(killed.text().empty());  // nobody holds it any more
  CHECK(WTERMSIG(parent.wait()) == SIGKILL);
}

TEST_CASE("child program: is killed when its owner object is destroyed, unless it was moved") {
  const ChildOutput output;
  {
    ChildProgram first = shell_child("sleep 1000 & echo ready; wait", output.write_end);
    REQUIRE(output.text('\n') == "ready\n");
    ChildProgram second = std::move(first);
    CHECK_FALSE(second.ended());
    ChildProgram third = shell_child("exit 0");
    third = std::move(second);
    CHECK_FALSE(third.ended());
  }
  CHECK(output.text().empty());
}

TEST_CASE("child program: if its exit status was collected elsewhere, it counts as 127") {
  for (const bool waits : {true, false}) {
    ChildProgram child = shell_child("exit 3");
    REQUIRE(::waitpid(child.process(), nullptr, 0) == child.process());
    const int status = waits ? child.wait() : child.ended().value_or(-1);
    CHECK((WIFEXITED(status) && WEXITSTATUS(status) == 127));
    CHECK(child.ended() == status);
  }
  ChildProgram first = shell_child("exit 4");
  const ChildProgram second = std::move(first);
  CHECK_FALSE(first.ended());
  CHECK(WEXITSTATUS(first.wait()) == 127);  // moved from: there is none
  CHECK(second.process() > 0);
}

TEST_CASE("child program: after release it continues without its object") {
  pid_t process = -1;
  {
    ChildProgram child = shell_child("exec sleep 1000");
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

TEST_CASE("child program: on request it is asked to terminate when its starter ends") {
  const ChildOutput output;
  const pid_t starter = ::fork();
  if (starter == 0) {
    alarm(60);
    ChildProgram child = shell_child("trap 'echo asked; exit 0' TERM; echo ready; while :; do sleep 0.02; done",
                                     ::fcntl(output.write_end, F_DUPFD_CLOEXEC, 0), {}, true);
    char byte = 0;
    (void)!::read(output.read_end, &byte, 1);  // of "ready"
    child.let_go();
    ::_exit(0);
  }
  int status = -1;
  CHECK(::waitpid(starter, &status, 0) == starter);
  CHECK(status == 0);
  ::close(output.write_end);
  CHECK(output.text() == "eady\nasked\n");
}

// Parts of a work: together all of it, no item twice.

TEST_CASE("shard: the parts cover each item once, and differ in size by at most one") {
  for (const int of : {1, 2, 3, 7, 8}) {
    int held = 0, least = 1080, most = 0;
    for (int number = 1; number <= of; ++number) {
      const Shard shard{number, of};
      int own = 0;
      for (std::size_t place = 0; place < 1080; ++place) {
        own += shard.holds(place) ? 1 : 0;
      }
      held += own;
      least = std::min(least, own);
      most = std::max(most, own);
    }
    CHECK(held == 1080);
    CHECK(most - least <= 1);
  }
}

TEST_CASE("shard: a part is given as K/N, anything else is rejected") {
  const Shard shard = shard_from("3/8");
  CHECK((shard.number == 3 && shard.of == 8 && shard.text() == "3/8" && !shard.is_whole()));
  CHECK(shard_from("1/1").is_whole());
  for (const char* typed :
       {"", "3", "0/8", "9/8", "-1/8", "3/", "/8", "3/8/2", "a/b", "3 / 8", "1/1001", "1/99999999999"}) {
    CAPTURE(typed);
    try {
      (void)shard_from(typed);
      FAIL("it was taken");
    } catch (const Error& error) {
      CHECK(error.id() == "TB-USAGE");
    }
  }
}
