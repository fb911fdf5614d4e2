// Standard streams that cannot be written, streams that are closed, and each signal that asks for the end. What changes
// the whole process is carried out in a process of its own.
#include <fcntl.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <functional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "bench/common/standard_streams.h"
#include "bench/common/stop_request.h"
#include "tests/support/process.h"

using namespace tactbench::bench;
using namespace tactbench::tests;

namespace {

// A copy of this process, which carries out `work` and ends with its value as the exit code; ended after a minute.
pid_t begin_apart(const std::function<int()>& work) {
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    for (const int number : {SIGALRM, SIGPIPE, SIGXFSZ}) std::signal(number, SIG_DFL);
    alarm(60);
    _exit(work());
  }
  return child;
}

// Its exit code; 1000 and the signal that ended it.
int end_of_apart(pid_t child) {
  int status = 0;
  REQUIRE(waitpid(child, &status, 0) == child);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
}

int done_apart(const std::function<int()>& work) { return end_of_apart(begin_apart(work)); }

struct OpenPipe {
  OpenPipe() { REQUIRE(pipe2(ends.data(), O_CLOEXEC) == 0); }
  ~OpenPipe() {
    for (const int end : ends)
      if (end >= 0) close(end);
  }
  OpenPipe(const OpenPipe&) = delete;
  OpenPipe& operator=(const OpenPipe&) = delete;
  void shut(std::size_t which) {
    close(ends.at(which));
    ends.at(which) = -1;
  }
  std::array<int, 2> ends{-1, -1};
};

bool leads_to_null(int descriptor) {
  std::array<char, 64> name{};
  const std::string link = "/proc/self/fd/" + std::to_string(descriptor);
  return readlink(link.c_str(), name.data(), name.size() - 1) > 0 && std::string(name.data()) == "/dev/null";
}

}  // namespace

TEST_CASE("standard streams: closed ones are opened on the null device, the others are unchanged") {
  for (int closed = 0; closed < 8; ++closed) {
    const OpenPipe kept;
    CHECK(done_apart([&] {
            for (int descriptor = 0; descriptor < 3; ++descriptor) {
              dup2(kept.ends[1], descriptor);
              if ((closed >> descriptor & 1) != 0) close(descriptor);
            }
            const int next = fcntl(kept.ends[1], F_DUPFD_CLOEXEC, 3);
            close(next);
            open_standard_descriptors();
            int found = 0;
            for (int descriptor = 0; descriptor < 3; ++descriptor)
              if (leads_to_null(descriptor)) found |= 1 << descriptor;
            return fcntl(kept.ends[1], F_DUPFD_CLOEXEC, 3) == next ? found : 100;  // no other was opened
          }) == closed);
  }
}

TEST_CASE("standard streams: a file gets all text, at once from standard error, on flush from standard output") {
  const TemporaryFolder folder;
  const auto written = [&](int descriptor, bool flush) {
    const int code = done_apart([&] {
      const int file = open(folder.path("f").c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
      dup2(file, descriptor);
      drop_unwritable_output();
      std::FILE* stream = descriptor == STDOUT_FILENO ? stdout : stderr;
      std::fputs("one\ntwo\n", stream);
      if (flush) std::fflush(stream);
      return output_is_lost() ? 1 : 0;
    });
    CHECK(code == 0);
    return read_file(folder.path("f"));
  };
  CHECK(written(STDOUT_FILENO, true) == "one\ntwo\n");
  CHECK(written(STDOUT_FILENO, false).empty());
  CHECK(written(STDERR_FILENO, false) == "one\ntwo\n");
}

TEST_CASE("standard streams: output without a reader is lost without a signal or an error") {
  for (const bool on_output : {true, false}) {
    OpenPipe pipe;
    pipe.shut(0);
    const int code = done_apart([&] {
      dup2(pipe.ends[1], on_output ? STDOUT_FILENO : STDERR_FILENO);
      drop_unwritable_output();
      std::FILE* stream = on_output ? stdout : stderr;
      if (output_is_lost()) return 10;
      errno = ERANGE;
      const int put = std::fputs("text\n", stream), flushed = std::fflush(stream);
      if (put < 0 || flushed != 0 || errno != ERANGE) return 11;
      return output_is_lost() ? 1 : 0;
    });
    CHECK(code == (on_output ? 1 : 0));
  }
}

TEST_CASE("standard streams: a file at its size limit keeps what fitted") {
  const TemporaryFolder folder;
  CHECK(done_apart([&] {
          const int file = open(folder.path("f").c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
          dup2(file, STDOUT_FILENO);
          drop_unwritable_output();
          const rlimit most{10, 10};
          setrlimit(RLIMIT_FSIZE, &most);
          std::fputs("0123456789abcde", stdout);
          std::fflush(stdout);
          return output_is_lost() ? 1 : 0;
        }) == 1);
  CHECK(read_file(folder.path("f")) == "0123456789");
}

TEST_CASE("standard streams: a write interrupted by signals arrives whole") {
  OpenPipe pipe;
  std::string text(400'000, 'x');
  for (std::size_t i = 0; i < text.size(); i += 100) text[i] = static_cast<char>('a' + i / 100 % 26);
  const pid_t child = begin_apart([&] {
    struct sigaction caught {};
    caught.sa_handler = [](int) {};
    sigaction(SIGUSR1, &caught, nullptr);  // without SA_RESTART
    dup2(pipe.ends[1], STDOUT_FILENO);
    drop_unwritable_output();
    std::fwrite("!", 1, 1, stdout);
    std::fflush(stdout);
    std::fwrite(text.data(), 1, text.size(), stdout);
    std::fflush(stdout);
    return output_is_lost() ? 1 : 0;
  });
  pipe.shut(1);
  char first = 0;
  REQUIRE(read(pipe.ends[0], &first, 1) == 1);
  CHECK(first == '!');
  std::string got;
  std::array<char, 4096> bytes{};
  for (ssize_t size = 0; (size = read(pipe.ends[0], bytes.data(), bytes.size())) > 0;) {
    got.append(bytes.data(), static_cast<std::size_t>(size));
    if (got.size() < 300'000) kill(child, SIGUSR1);
  }
  CHECK(end_of_apart(child) == 0);
  CHECK(got == text);
}

TEST_CASE("standard streams: a blocked reader of standard error is waited for only once") {
  OpenPipe pipe;
  REQUIRE(fcntl(pipe.ends[1], F_SETPIPE_SZ, 4096) >= 4096);
  const std::string page(4096, 'x');
  REQUIRE(write(pipe.ends[1], page.data(), page.size()) == 4096);
  CHECK(done_apart([&] {
          dup2(pipe.ends[1], STDERR_FILENO);
          drop_unwritable_output();
          const auto begun = std::chrono::steady_clock::now();
          for (int i = 0; i < 100; ++i) std::fputs("lost", stderr);
          const auto took = std::chrono::steady_clock::now() - begun;
          if (output_is_lost()) return 2;
          return took > std::chrono::seconds(10) ? 1 : 0;  // 0.2 s are meant, 20 s if each was waited for
        }) == 0);
  std::array<char, 5000> bytes{};
  CHECK(read(pipe.ends[0], bytes.data(), bytes.size()) == 4096);
}

TEST_CASE("signals: the first signal and the first other than Ctrl-C are recorded, and the old handlers are restored") {
  std::vector<int> numbers = {SIGINT,  SIGTERM, SIGHUP,    SIGQUIT, SIGUSR1, SIGUSR2,  SIGPWR,
                              SIGXCPU, SIGALRM, SIGVTALRM, SIGPROF, SIGIO,   SIGSTKFLT};
  for (int number = SIGRTMIN; number <= SIGRTMAX; ++number) numbers.push_back(number);
  CHECK(done_apart([&] {
          for (const int number : numbers) std::signal(number, SIG_DFL);
          for (const int number : numbers) {
            const StopRequest request;
            if (request.signal() != 0 || request.interrupts() != 0 || request.ending() != 0) return 1;
            std::raise(number);
            const bool interrupt = number == SIGINT;
            if (request.signal() != number) return 2;
            if (request.interrupts() != (interrupt ? 1 : 0) || request.ending() != (interrupt ? 0 : number)) return 3;
            std::raise(SIGINT);
            std::raise(number == SIGHUP ? SIGTERM : SIGHUP);
            if (request.signal() != number || request.interrupts() != (interrupt ? 2 : 1)) return 4;
            if (request.ending() != (interrupt ? SIGHUP : number)) return 5;
          }
          for (const int number : numbers) {
            struct sigaction now {};
            sigaction(number, nullptr, &now);
            if (now.sa_handler != SIG_DFL) return 6;
          }
          return 0;
        }) == 0);
}

TEST_CASE("signals: signals that the process ignores or handles are left alone, except SIGQUIT") {
  static int alarms = 0;
  const auto still_ignored = [](int number) {
    std::signal(number, SIG_IGN);
    const StopRequest request;
    std::raise(number);
    return request.signal() == 0;
  };
  CHECK(done_apart([&] { return still_ignored(SIGHUP) ? 0 : 1; }) == 0);
  CHECK(done_apart([&] { return still_ignored(SIGPROF) ? 0 : 1; }) == 0);
  CHECK(done_apart([&] { return still_ignored(SIGQUIT) ? 0 : 1; }) == 1);
  CHECK(done_apart([&] {
          std::signal(SIGALRM, [](int) { ++alarms; });
          const StopRequest request;
          std::raise(SIGALRM);
          return alarms == 1 && request.signal() == 0 ? 0 : 1;
        }) == 0);
  CHECK(done_apart([] {
          const StopRequest outer;
          std::raise(SIGINT);
          std::raise(SIGUSR1);
          {
            const StopRequest inner;  // knows of the same signals
            if (inner.signal() != SIGINT || inner.interrupts() != 1 || inner.ending() != SIGUSR1) return 1;
            std::raise(SIGINT);
          }
          return outer.interrupts() == 2 ? 0 : 2;
        }) == 0);
}

TEST_CASE("signals: after a failed or stopped run a late signal does not change the exit code") {
  CHECK(done_apart([] {
          {
            const StopRequest around;  // as of the demonstration
            const StopRequest stopped;
            std::raise(SIGQUIT);
            StopRequest::keep();
          }
          for (const int late : {SIGINT, SIGTERM, SIGALRM}) std::raise(late);
          const StopRequest next;
          if (next.signal() != 0) return 1;
          std::raise(SIGUSR1);
          return next.signal() == SIGUSR1 && next.interrupts() == 0 ? 7 : 2;
        }) == 7);
  CHECK(done_apart([] {
          std::signal(SIGTERM, SIG_DFL);
          { const StopRequest completed; }
          std::raise(SIGTERM);
          return 0;
        }) == 1000 + SIGTERM);
}

TEST_CASE("signals: each one has its own name") {
  CHECK(signal_text(SIGINT) == "Ctrl-C");
  CHECK_THAT(signal_text(SIGUSR2), Catch::Contains("12"));
  std::set<std::string> words;
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGUSR2}) words.insert(signal_text(number));
  CHECK(words.size() == 5);
}
