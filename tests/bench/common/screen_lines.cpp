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
#include <utility>
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
  const std::string end = "\x1b[K\n\x1b[J";
  CHECK(painted({{{"a", 0}, {"c"}}}, 80, 0) == "\x1b[48;5;0ma\x1b[0mc" + end);
  CHECK_THAT(painted({{}, {{"a"}}}, 80, 2), Catch::StartsWith("\x1b[2F"));
  const auto line = [&](const std::vector<PaintedLine>& lines, std::size_t columns) {
    const std::string text = painted(lines, columns, 0);
    REQUIRE(text.ends_with(end));
    return text.substr(0, text.size() - end.size());
  };
  const PaintedLine both = {{"ab"}, {"cd"}};
  CHECK(line({both}, 5) == "abcd");
  CHECK(line({both}, 4) == "ab\u2026");
  CHECK(line({{{"测测"}, {"b"}}}, 6) == "测测b");
  for (const std::size_t columns : {0U, 1U, 2U}) CHECK(line({{{"a"}, {"b"}}}, columns) == "a");
  CHECK(line({{{"\x1b[31m"}}}, 80) == "\\x1b[31m");
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
  CHECK(shown(two, 81, 24) == anew + ab);
  CHECK(shown(one, 81, 25) == anew + c);
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
  const std::pair<unsigned short, std::size_t> widths[] = {{10, 9}, {1, 1}, {201, 200}, {202, 200}, {0, 79}};
  for (const auto& [columns, shown] : widths) CHECK(line(columns) == cut(shown));
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
  for (const auto& [first, shown] : {std::pair("look\n", away + "look\n"), {"\n", std::string("\n")}})
    CHECK(said_on_error([&] {
            tty::renew_line("12 %");
            tty::print(stderr, "{}", first);
            tty::print(stderr, "again\n");
          }) == "\r12 %\x1b[K" + shown + "again\n");
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
      _exit(error.code() == ExitCode::kUsage && error.id() == "TB-FILE-WRITE" ? 0 : 2);
    }
    _exit(1);
  }
  int status = 0;
  REQUIRE(waitpid(child, &status, 0) == child);
  CHECK((WIFEXITED(status) && WEXITSTATUS(status) == 0));
}
