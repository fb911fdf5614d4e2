#include "bench/run/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace tactbench::bench {

Progress::Mode Progress::mode_for(bool quiet) {
  if (quiet) return Mode::kQuiet;
  const char* terminal = std::getenv("TERM");
  const bool dumb = terminal == nullptr || std::string(terminal) == "dumb";
  return isatty(STDERR_FILENO) != 0 && std::getenv("CI") == nullptr && !dumb ? Mode::kTerminal : Mode::kPlain;
}

void Progress::step(const std::string& label, int done, int total, double pressure_psi) {
  if (mode_ == Mode::kQuiet) return;
  const auto now = Clock::now();
  const auto interval = mode_ == Mode::kTerminal ? std::chrono::milliseconds(100) : std::chrono::milliseconds(10000);
  if (shown_ == Clock::time_point{}) shown_ = mode_ == Mode::kTerminal ? now - interval : now;
  if (now - shown_ < interval && done != total) return;
  shown_ = now;
  const double elapsed = std::chrono::duration<double>(now - start_).count();
  const double left = done > 0 ? elapsed * (total - done) / done : 0.0;
  const std::string line =
      fmt::format("{}: step {}/{}  {:5.1f} psi  {:3.0f} %  {:.0f}:{:02.0f} left", label, done, total, pressure_psi,
                  100.0 * done / total, std::floor(left / 60.0), std::floor(left - 60.0 * std::floor(left / 60.0)));
  if (mode_ == Mode::kTerminal) {
    fmt::print(stderr, "\r{}\x1b[K", line);
    std::fflush(stderr);
    open_ = true;
  } else {
    fmt::print(stderr, "{}\n", line);
  }
}

void Progress::finish() {
  if (open_) fmt::print(stderr, "\n");
  open_ = false;
}

}  // namespace tactbench::bench
