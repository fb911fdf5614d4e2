// What reaches a terminal: painted blocks, the line that is written over, and the words of long work.
#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <sys/ioctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdio>
#include <string>
#include <vector>

#include "bench/common/error.h"
#include "bench/common/for_people.h"
#include "bench/common/long_work.h"
#include "bench/common/renewed_line.h"
#include "bench/common/screen.h"
#include "tests/bench/cli/verb_here.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;

namespace {

// A pseudo-terminal of that size; the program's end of it.
struct SizedTerminal {
  SizedTerminal(unsigned short columns, unsigned short rows) {
    const winsize size{rows, columns, 0, 0};
    REQUIRE(openpty(&terminal, &program, nullptr, nullptr, &size) == 0);
  }
  ~SizedTerminal() {
    close(terminal);
    close(program);
  }
  SizedTerminal(const SizedTerminal&) = delete;
  SizedTerminal& operator=(const SizedTerminal&) = delete;
  // What `print` writes to standard error when that is this terminal, up to a line's end.
  template <class Print>
  std::string shown_by(const Print& print) const {
    const int before = dup(STDERR_FILENO);
    dup2(program, STDERR_FILENO);
    print();
    dup2(before, STDERR_FILENO);
    close(before);
    std::string text;  // a terminal may pass it on in pieces
    for (pollfd ready{terminal, POLLIN, 0}; !text.ends_with('\n') && poll(&ready, 1, 20'000) == 1;) {
      char c = 0;
      if (read(terminal, &c, 1) != 1) break;
      text += c;
    }
    return text;
  }
  int terminal = -1, program = -1;
};

template <class Print>
std::string said_on_error(const Print& print) {
  Captured err(stderr);
  print();
  return err.text();
}

}  // namespace

TEST_CASE("screen: the size of a terminal, and 80 x 24 where a terminal tells none") {
  const auto size_with = [](unsigned short columns, unsigned short rows) {
    const SizedTerminal terminal(columns, rows);
    const ScreenSize size = screen_size(terminal.program);
    return std::pair(size.columns, size.rows);
  };
  using Size = std::pair<std::size_t, std::size_t>;
  CHECK(size_with(132, 50) == Size(132, 50));
  CHECK(size_with(1, 1) == Size(1, 1));
  CHECK(size_with(0, 50) == Size(80, 24));
  CHECK(size_with(132, 0) == Size(80, 24));
}

TEST_CASE("screen: a block's spans, each in its colour, up to the last column but one") {
  CHECK(painted({}, 80, 0) == "\x1b[J");
  CHECK(painted({}, 80, 1) == "\x1b[1F\x1b[J");
  CHECK(painted({{}, {{"a"}}}, 80, 2) == "\x1b[2F\x1b[K\na\x1b[K\n\x1b[J");
  CHECK(painted({{{"a", 0}, {"b", 255}, {"c"}}}, 80, 0) == "\x1b[48;5;0ma\x1b[0m\x1b[48;5;255mb\x1b[0mc\x1b[K\n\x1b[J");
  CHECK(painted({{{"ab"}, {"cd"}, {"e", 7}}}, 6, 0) == "abcd\x1b[48;5;7me\x1b[0m\x1b[K\n\x1b[J");
  CHECK(painted({{{"ab"}, {"cd"}, {"e", 7}}}, 5, 0) == "abcd\x1b[K\n\x1b[J");
  CHECK(painted({{{"ab"}, {"cd"}}}, 4, 0) == "ab\u2026\x1b[K\n\x1b[J");
  CHECK(painted({{{"测测"}, {"b"}}}, 6, 0) == "测测b\x1b[K\n\x1b[J");
  for (const std::size_t columns : {0U, 1U, 2U}) CHECK(painted({{{"a"}, {"b"}}}, columns, 0) == "a\x1b[K\n\x1b[J");
  CHECK(painted({{{"\x1b[31m"}}}, 80, 0) == "\\x1b[31m\x1b[K\n\x1b[J");
}

TEST_CASE("screen: a block is painted over in place, and anew when the screen has another size") {
  ScreenBlock block;
  const std::vector<PaintedLine> two = {{{"a"}}, {{"b"}}}, one = {{{"c"}}};
  const auto shown = [&](const std::vector<PaintedLine>& lines, std::size_t columns, std::size_t rows) {
    return printed_by([&] { block.paint(lines, {columns, rows}); });
  };
  const std::string anew = "\x1b[H\x1b[2J", ab = "a\x1b[K\nb\x1b[K\n\x1b[J", c = "c\x1b[K\n\x1b[J";
  CHECK(shown(two, 80, 24) == ab);
  CHECK(shown(two, 80, 24) == "\x1b[2F" + ab);
  CHECK(shown(one, 80, 24) == "\x1b[2F" + c);
  CHECK(shown(two, 80, 24) == "\x1b[1F" + ab);
  CHECK(shown(two, 81, 24) == anew + ab);
  CHECK(shown(two, 81, 24) == "\x1b[2F" + ab);
  CHECK(shown(one, 81, 25) == anew + c);
  CHECK(shown({}, 81, 25) == "\x1b[1F\x1b[J");
  CHECK(shown(one, 60, 20) == c);  // nothing stood there
}

TEST_CASE("the line that is written over: as wide as the terminal but one, at most 200 columns") {
  const std::string text(300, 'x');
  const auto line = [&](unsigned short columns) {
    const SizedTerminal terminal(columns, 24);
    return terminal.shown_by([&] {
      tty::renew_line(text);
      tty::print(stderr, "\n");
    });
  };
  const auto cut = [](std::size_t columns) { return "\r" + std::string(columns - 1, 'x') + "\u2026" + "\x1b[K\r\n"; };
  CHECK(line(10) == cut(9));
  CHECK(line(2) == cut(1));
  CHECK(line(1) == cut(1));
  CHECK(line(201) == cut(200));
  CHECK(line(202) == cut(200));
  CHECK(line(500) == cut(200));
  CHECK(line(0) == cut(79));
}

TEST_CASE("the line that is written over: what is printed takes it away, a line end alone leaves it") {
  const std::string away = "\r\x1b[K";
  CHECK(said_on_error([] { tty::erase_line(); }).empty());
  CHECK(said_on_error([] {
          tty::renew_line("12 %");
          tty::renew_line("13 %");
          tty::erase_line();
          tty::erase_line();
        }) == "\r12 %\x1b[K\r13 %\x1b[K" + away);
  CHECK(said_on_error([] {
          tty::renew_line("12 %");
          tty::print(stderr, "look\n");
          tty::print(stderr, "again\n");
        }) == "\r12 %\x1b[K" + away + "look\nagain\n");
  CHECK(said_on_error([] {
          tty::renew_line("12 %");
          tty::print(stderr, "\n");
          tty::print(stderr, "look\n");
        }) == "\r12 %\x1b[K\nlook\n");
  std::string out;
  CHECK(said_on_error([&] {
          tty::renew_line("12 %");
          out = printed_by([] { tty::print("\n"); });
        }) == "\r12 %\x1b[K" + away);
  CHECK(out == "\n");
}

TEST_CASE("standard output that cannot be written is an error, standard error that cannot is none") {
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    const int full = open("/dev/full", O_WRONLY | O_CLOEXEC);
    dup2(full, STDERR_FILENO);
    std::setvbuf(stderr, nullptr, _IONBF, 0);
    tty::print(stderr, "lost\n");
    dup2(full, STDOUT_FILENO);
    try {
      tty::print("{}\n", std::string(100'000, 'x'));
    } catch (const Error& error) {
      const bool told = error.code() == ExitCode::kUsage && error.id() == "TB-FILE-WRITE" &&
                        error.what() == std::string("the result cannot be written: No space left on device") &&
                        error.where() == "standard output" &&
                        error.remedy() == "check space and permissions of the file, or the reader of the pipe";
      _exit(told ? 0 : 2);
    }
    _exit(1);
  }
  int status = 0;
  REQUIRE(waitpid(child, &status, 0) == child);
  CHECK((WIFEXITED(status) && WEXITSTATUS(status) == 0));
}

TEST_CASE("a guessed part: of the stages before, whatever comes later, and none without a time or a share") {
  const std::vector<WorkStage> stages = {{"a", 1.0}, {"b", 3.0}, {"c", 2.0, false}, {"d", 7.0}};
  CHECK(guessed_part(stages, 2, 8.0, 1.0) == Approx(0.25));  // 8 s for 4 shares: 4 s for two
  CHECK(guessed_part(stages, 2, 8.0, 3.79) == Approx(0.9475));
  CHECK(guessed_part(stages, 2, 8.0, 3.81) == Approx(0.95));
  CHECK(guessed_part(stages, 2, 0.0, 1.0) == 0.0);
  CHECK(guessed_part({{"a", 0.0}, {"b", 1.0}}, 1, 8.0, 1.0) == 0.0);
  CHECK(guessed_part({{"a", 1.0}, {"b", 0.0}}, 1, 8.0, 1.0) == 0.0);
}
