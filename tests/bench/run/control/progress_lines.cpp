// The progress line as it reaches standard error, in each mode, and which mode a process takes.
#include <fcntl.h>
#include <pty.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <functional>
#include <optional>
#include <string>

#include "bench/common/terminal.h"
#include "bench/run/control/control.h"
#include "bench/run/control/progress.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/support/variable.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;

namespace {

// Standard error goes elsewhere while this lives.
class StandardErrorTo {
 public:
  explicit StandardErrorTo(int descriptor) : before_(::dup(STDERR_FILENO)) {
    std::fflush(stderr);
    ::dup2(descriptor, STDERR_FILENO);
  }
  ~StandardErrorTo() {
    std::fflush(stderr);
    ::dup2(before_, STDERR_FILENO);
    ::close(before_);
  }
  StandardErrorTo(const StandardErrorTo&) = delete;
  StandardErrorTo& operator=(const StandardErrorTo&) = delete;

 private:
  int before_;
};

std::string said_by(const std::function<void()>& act) {
  Captured said(stderr);
  act();
  return said.text();
}

RunStatus status_with_estimate() {
  RunStatus status;
  status.label = "run";
  status.phase = "warming up";
  status.step = 1;
  status.steps = 4;
  status.left_s = 120.0;
  status.left_high_s = 150.0;
  status.rate = 2.0;
  return status;
}

}  // namespace

TEST_CASE("progress: a plain line, a line that is overwritten, or none in quiet mode") {
  const RunStatus status = status_with_estimate();
  const std::string plain = said_by([&] { Progress(Progress::Mode::kPlain).show(status); });
  CHECK(std::ranges::count(plain, '\n') == 1);
  CHECK_THAT(plain, Catch::Contains("25 %") && Catch::Contains("1:00") && Catch::EndsWith("warming up\n"));
  CHECK(said_by([&] { Progress(Progress::Mode::kQuiet).show(status); }).empty());
  const std::string renewed = said_by([&] {
    Progress progress(Progress::Mode::kTerminal);
    progress.show(status);
    progress.show(status);
    progress.note("look");
    progress.finish();
    progress.finish();
  });
  CHECK(std::ranges::count(renewed, '\r') == 2);
  CHECK(std::ranges::count(renewed, '\n') == 2);
  CHECK_THAT(renewed, Catch::EndsWith("\nlook\n"));  // a note stays
  for (const auto mode : {Progress::Mode::kQuiet, Progress::Mode::kPlain, Progress::Mode::kTerminal})
    CHECK(said_by([&] { Progress(mode).note("look"); }) == "look\n");
}

TEST_CASE("progress: without an estimate, or in virtual time, the time left follows from the pace only") {
  RunStatus status = status_with_estimate();
  status.step = 0;  // no pace yet
  const auto has_time = [&] {
    return said_by([&] { Progress(Progress::Mode::kPlain).show(status); }).find("1:00") != std::string::npos;
  };
  CHECK(has_time());
  status.left_high_s = 0.0;
  CHECK_FALSE(has_time());
  status.left_high_s = 150.0;
  status.rate = 0.0;
  CHECK_FALSE(has_time());
}

TEST_CASE("progress: the line has the fraction of steps, the time left, set-point and readings") {
  RunStatus status;
  status.phase = "travelling";
  const auto has = [&](double left_s, const std::string& part) {
    return progress_line(status, left_s).find(part) != std::string::npos;
  };
  CHECK((has(3661.9, "61:01") && has(0.0, "0:00") && has(59.99, "0:59") && has(60.0, "1:00")));
  CHECK_FALSE((has(-0.1, ":0") || has(-0.1, "%")));
  status.steps = 1;
  CHECK(has(-0.1, " 0 %"));
  status.step = 1;
  CHECK(has(-0.1, "100 %"));
  CHECK_FALSE(has(-0.1, "psi"));
  status.readings = RunReadings{1.0, 20.0, 19.0, 18.5, false, 9.6};
  CHECK((has(-0.1, "20.0 psi") && has(-0.1, "18.5")));
  status.target_n = 2.0;
  CHECK((has(-0.1, "2.0 N") && has(-0.1, "9.6")));
}

TEST_CASE("progress: after a line the next one is not due at once, even for another phase") {
  RunStatus status = status_with_estimate();
  said_by([&] {
    for (const auto mode : {Progress::Mode::kPlain, Progress::Mode::kTerminal}) {
      Progress progress(mode);
      CHECK(progress.due(status));
      const auto before = Pace::Clock::now();
      progress.show(status);
      RunStatus next = status;
      next.phase = "conditioning 1 of 6";
      const bool due = progress.due(next);
      if (Pace::Clock::now() - before < std::chrono::milliseconds(90)) CHECK_FALSE(due);
    }
  });
}

TEST_CASE("progress: the overwritten line is used only on terminals that support it, outside CI") {
  int terminal = -1, program = -1;
  REQUIRE(::openpty(&terminal, &program, nullptr, nullptr, nullptr) == 0);
  const auto mode_with = [](int error, const std::optional<std::string>& term, const std::optional<std::string>& ci,
                            bool quiet) {
    const Variable first("TERM", term), second("CI", ci);
    const StandardErrorTo elsewhere(error);
    return Progress::mode_for(quiet);
  };
  CHECK(mode_with(program, "xterm", std::nullopt, false) == Progress::Mode::kTerminal);
  CHECK(mode_with(program, "xterm", std::nullopt, true) == Progress::Mode::kQuiet);
  CHECK(mode_with(program, "dumb", std::nullopt, false) == Progress::Mode::kPlain);
  CHECK(mode_with(program, std::nullopt, std::nullopt, false) == Progress::Mode::kPlain);
  CHECK(mode_with(program, "xterm", "true", false) == Progress::Mode::kPlain);
  const int null = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  CHECK(mode_with(null, "xterm", std::nullopt, false) == Progress::Mode::kPlain);
  for (const int descriptor : {terminal, program, null}) ::close(descriptor);
}

TEST_CASE("status board: the last step is printed before it is due, an earlier step and a refresh are not") {
  Control control;
  const auto shown = [&](int step, bool done) {
    return said_by([&] {
      Progress progress(Progress::Mode::kPlain);
      StatusBoard board(control, progress);
      board.now() = status_with_estimate();
      board.now().rate = 0.0;
      board.now().step = step;
      board.publish();
      if (done)
        board.step_done();
      else
        board.refresh();
    });
  };
  said_by([] { tty::print(stderr, "\n"); });  // ends what another test left open
  CHECK(shown(3, true).empty());
  CHECK(shown(4, false).empty());
  CHECK_THAT(shown(4, true), Catch::Contains("100 %"));
}
