// Output on a terminal: painted blocks, the line that is written over, and the words of long work.

#include <fcntl.h>
#include <poll.h>
#include <pty.h>
#include <sys/ioctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <catch2/catch.hpp>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <ios>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "analysis/workers.h"
#include "bench/common/error.h"
#include "bench/common/private_files.h"
#include "bench/common/standard_streams.h"
#include "bench/common/stop_request.h"
#include "bench/common/terminal.h"
#include "bench/common/work_progress.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/support/process.h"

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

TEST_CASE("screen: size of the terminal, or 80 x 24 if the terminal reports none") {
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

TEST_CASE("screen: the spans of a block keep their colour, up to the last column but one") {
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

TEST_CASE("screen: a block is repainted in place, and on a cleared screen if the screen size has changed") {
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

TEST_CASE("status line: is one column narrower than the terminal, at most 200 columns") {
  const std::string text(300, 'x');
  const auto line = [&](unsigned short columns) {
    const SizedTerminal terminal(columns, 24);
    return terminal.shown_by([&] {
      tty::update_status_line(text);
      tty::print(stderr, "\n");
    });
  };
  const auto cut = [](std::size_t columns) { return "\r" + std::string(columns - 1, 'x') + "\u2026" + "\x1b[K\r\n"; };
  const std::pair<unsigned short, std::size_t> widths[] = {{10, 9}, {1, 1}, {201, 200}, {202, 200}, {0, 79}};
  for (const auto& [columns, shown] : widths) CHECK(line(columns) == cut(shown));
}

TEST_CASE("status line: printed text erases it, a line end alone keeps it") {
  const std::string away = "\r\x1b[K";
  CHECK(said_on_error([] { tty::erase_status_line(); }).empty());
  CHECK(said_on_error([] {
          tty::update_status_line("12 %");
          tty::update_status_line("13 %");
          tty::erase_status_line();
          tty::erase_status_line();
        }) == "\r12 %\x1b[K\r13 %\x1b[K" + away);
  for (const auto& [first, shown] : {std::pair("look\n", away + "look\n"), {"\n", std::string("\n")}})
    CHECK(said_on_error([&] {
            tty::update_status_line("12 %");
            tty::print(stderr, "{}", first);
            tty::print(stderr, "again\n");
          }) == "\r12 %\x1b[K" + shown + "again\n");
  std::string out;
  CHECK(said_on_error([&] {
          tty::update_status_line("12 %");
          out = printed_by([] { tty::print("\n"); });
        }) == "\r12 %\x1b[K" + away);
  CHECK(out == "\n");
}

TEST_CASE("printing: an unwritable standard output is an error, an unwritable standard error is not") {
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

namespace {

// Whether a terminal may be sent this: lines, tabs, and what a person reads.
bool harmless(const std::string& text) {
  for (const char c : text)
    if ((static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t') || c == 0x7F) return false;
  return text.find("\u009b") == std::string::npos && text.find("\u202e") == std::string::npos;
}

}  // namespace

TEST_CASE("printable text: control characters are escaped, ordinary text is unchanged") {
  CHECK(terminal_safe("\x1b[31mred\x1b[0m") == "\\x1b[31mred\\x1b[0m");
  CHECK(terminal_safe("title\x1b]0;t\x07\r\b\x7f") == "title\\x1b]0;t\\x07\\x0d\\x08\\u007f");
  CHECK(terminal_safe(std::string("a\0b", 3)) == "a\\x00b");
  CHECK(terminal_safe("C1: \u009b31m \u0085") == "C1: \\u009b31m \\u0085");
  CHECK(terminal_safe("a\u200bb\u200ec\u2028d\u061c\u2060\ufeff") == "a\\u200bb\\u200ec\\u2028d\\u061c\\u2060\\ufeff");
  CHECK(terminal_safe("\u202egnp.exe\u202c \u2066x\u2069") == "\\u202egnp.exe\\u202c \\u2066x\\u2069");
  CHECK(terminal_safe("\xff\xc0\xaf\xed\xa0\x80") == "\\xff\\xc0\\xaf\\xed\\xa0\\x80");
  CHECK(terminal_safe("cut \xe2\x82") == "cut \\xe2\\x82");
  for (const char* good : {"", "plain", "two\nlines\tand a tab", "Größe ±5 µm, 测试, ✓, 🙂, e\u0301", "C:\\x1b"})
    CHECK(terminal_safe(good) == good);
}

TEST_CASE("printable text: one line has no line breaks and is cut to its number of columns") {
  CHECK(one_line("a\nb\tc") == "a\\x0ab\\x09c");
  CHECK(one_line("abcdef", 6) == "abcdef");
  CHECK(one_line("abcdefg", 6) == "abcde\u2026");
  CHECK(one_line("测试测试", 6) == "测试\u2026");
  CHECK(one_line("测试", 2) == "\u2026");
  CHECK(display_width("测试") == 4);
  CHECK(display_width("e\u0301a") == 2);
  CHECK(display_width("✓") == 1);
  CHECK(display_width(one_line(std::string(100'000, '\x1b'), 50)) <= 50);
  std::string marks = "a";
  for (int i = 0; i < 5000; ++i) marks += "\u0301";
  CHECK(one_line(marks, 50).size() < 300);
  CHECK(one_line(marks, 50).ends_with("\u2026"));
}

TEST_CASE("printable text: an error has no control characters and a bounded length") {
  const std::string evil = "x\x1b]0;t\x07\r\u009b\u202e\xff\ny";
  const std::string text = error_text(Error("TB-USAGE", evil, evil, evil, evil));
  CHECK(harmless(text));
  CHECK(std::count(text.begin(), text.end(), '\n') == 4);
  const std::string longest = error_text(Error("TB-USAGE", std::string(1'000'000, 'm'), ""));
  CHECK(longest.size() < 3000);
}

TEST_CASE("printable text: hidden characters and column widths are right at the limits of the Unicode blocks") {
  const auto utf8 = [](std::uint32_t c) {
    std::string text;
    if (c < 0x80) return std::string(1, static_cast<char>(c));
    const int more = c < 0x800 ? 1 : c < 0x10000 ? 2 : 3;
    text += static_cast<char>((more == 1 ? 0xC0U : more == 2 ? 0xE0U : 0xF0U) | (c >> (6 * more)));
    for (int i = more - 1; i >= 0; --i) text += static_cast<char>(0x80U | ((c >> (6 * i)) & 0x3FU));
    return text;
  };
  const std::vector<std::pair<std::uint32_t, std::uint32_t>> hidden = {
      {0x00, 0x08},     {0x0B, 0x1F},     {0x7F, 0x9F},     {0x61C, 0x61C},   {0x200B, 0x200B},
      {0x200E, 0x200F}, {0x2028, 0x202E}, {0x2060, 0x2069}, {0xFEFF, 0xFEFF},
  };
  const auto is_shown = [&](std::uint32_t c) { return terminal_safe(utf8(c)) == utf8(c); };
  for (const auto& [first, last] : hidden) {
    INFO("U+" << std::hex << first << " to U+" << last);
    CHECK_FALSE(is_shown(first));
    CHECK_FALSE(is_shown(last));
    CHECK(is_shown(last + 1));
    if (first > 0) CHECK(is_shown(first - 1));
  }
  for (const std::uint32_t none : {0x0300U, 0x036FU, 0xFE0FU, 0xFEFFU}) CHECK(display_width(utf8(none)) == 0);
  for (const std::uint32_t two : {0x1100U, 0x3041U, 0xD7A3U, 0xFF60U, 0x1F600U}) CHECK(display_width(utf8(two)) == 2);
  CHECK(display_width("aé") == 2);
  CHECK(one_line("\U00010330\U00010331", 2) == "\U00010330\U00010331");  // four bytes each, one column
}

TEST_CASE("clock text: a time is rounded to the nearest second") {
  CHECK(clock_text(0.49) == "0:00:00");
  CHECK(clock_text(59.5) == "0:01:00");
  CHECK(clock_text(3661.0) == "1:01:01");
  CHECK(clock_text(100 * 3600.0 + 62.0) == "100:01:02");
}

// The progress line of verbs that compute: what it says at each moment, and where it keeps silent.

TEST_CASE("progress: a stage without a count is estimated from its share and the pace so far") {
  const std::vector<WorkStage> stages = {{"models", 4.0}, {"uncertainty", 2.0, false}};
  CHECK(estimated_fraction(stages, 1, 8.0, 1.0) == Approx(0.25));  // it should take 4 s
  CHECK(estimated_fraction(stages, 1, 8.0, 3.0) == Approx(0.75));
  CHECK(estimated_fraction(stages, 1, 8.0, 300.0) == Approx(0.95));  // late, but not done
  CHECK(estimated_fraction(stages, 0, 0.0, 300.0) == 0.0);           // nothing came before
}

TEST_CASE("progress: work counts its items, nested work does not count") {
  const std::size_t before = analysis::work_now().works;
  {
    analysis::Work outer(10);
    outer.add(3);
    {
      analysis::Work inner(99);
      inner.add(50);
      CHECK(analysis::work_now().count == 10);
      CHECK(analysis::work_now().done == 3);
    }
    outer.add();
    CHECK(analysis::work_now().done == 4);
    CHECK(analysis::work_now().works == before + 1);
  }
  CHECK(analysis::work_now().count == 0);
  analysis::Work next(2);
  CHECK(analysis::work_now().done == 0);
  CHECK(analysis::work_now().works == before + 2);
}

TEST_CASE("progress: without a running verb its calls have no effect, without a terminal there is no line") {
  CHECK_NOTHROW(begin_stage("reading"));
  CHECK_NOTHROW(pause_progress());
  WorkProgress work("fit", false, {{"reading", 1.0}});  // a test has no terminal
  CHECK_FALSE(work.shows());
  work.begin("reading");
  work.end();
}

// A file that is not there has no text; one that cannot be read to its end is an error, not half a text.

TEST_CASE("file text: all bytes are read, a missing file is empty, and a read failure is an error") {
  const TemporaryFolder folder;
  std::string bytes;
  for (int i = 0; i < 40000; ++i) bytes += static_cast<char>(i * i);
  write_file(folder.path("bytes"), bytes);
  write_file(folder.path("empty"), "");
  CHECK(file_text(folder.path("bytes")) == bytes);
  CHECK(file_text(folder.path("empty")).empty());
  CHECK(file_text(folder.path("missing")).empty());
  CHECK_THROWS_AS(file_text(folder.path(".")), std::ios_base::failure);
}

// Standard streams that cannot be written, streams that are closed, and each signal that asks for the end. What changes
// the whole process is carried out in a process of its own.

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
