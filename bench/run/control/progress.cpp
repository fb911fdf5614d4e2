#include "bench/run/control/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "bench/common/for_people.h"

namespace tactbench::bench {

Progress::Mode Progress::mode_for(bool quiet) {
  if (quiet) return Mode::kQuiet;
  const char* terminal = std::getenv("TERM");
  const bool dumb = terminal == nullptr || std::string(terminal) == "dumb";
  return isatty(STDERR_FILENO) != 0 && std::getenv("CI") == nullptr && !dumb ? Mode::kTerminal : Mode::kPlain;
}

void Progress::step(const std::string& label, int done, int total, const sequences::Step& now_doing, double left_s) {
  if (mode_ == Mode::kQuiet) return;
  const auto now = Clock::now();
  const auto interval = mode_ == Mode::kTerminal ? std::chrono::milliseconds(100) : std::chrono::milliseconds(10000);
  if (shown_ == Clock::time_point{}) shown_ = mode_ == Mode::kTerminal ? now - interval : now;
  if (now - shown_ < interval && done != total) return;
  shown_ = now;
  const double elapsed = std::chrono::duration<double>(now - start_).count();
  const double by_pace = done > 0 ? elapsed * (total - done) / done : 0.0;
  const double left = left_s >= 0.0 ? left_s : by_pace;
  const bool presses = now_doing.force_to_n != now_doing.force_from_n;
  const std::string line =
      fmt::format("{}: step {}/{}  {:5.1f} {}  {:3.0f} %  {:.0f}:{:02.0f} left", label, done, total,
                  presses ? now_doing.force_n : now_doing.setpoint.value(), presses ? "N" : "psi", 100.0 * done / total,
                  std::floor(left / 60.0), std::floor(left - 60.0 * std::floor(left / 60.0)));
  if (mode_ == Mode::kTerminal) {
    tty::renew_line(line);
    std::fflush(stderr);
    open_ = true;
  } else {
    tty::print(stderr, "{}\n", line);
  }
}

void Progress::note(const std::string& text) {
  finish();
  tty::print(stderr, "{}\n", text);
}

void Progress::finish() {
  if (open_) tty::print(stderr, "\n");
  open_ = false;
}

}  // namespace tactbench::bench
