#include "bench/run/control/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <system_error>
#include <utility>

#include "bench/common/child_process.h"
#include "bench/common/terminal.h"

namespace tactbench::bench {

// What matters most comes first: a narrow terminal cuts the end.
std::string progress_line(const RunStatus& status, double left_s, analysis::PressureUnit unit) {
  std::string line = status.label + ": ";
  if (status.steps > 0) line += fmt::format("{:3.0f} %  ", 100.0 * status.step / status.steps);
  if (left_s >= 0.0) {
    const double minutes = std::floor(left_s / 60.0);
    line += fmt::format("{:.0f}:{:02.0f} left  ", minutes, std::floor(left_s - 60.0 * minutes));
  }
  line += status.phase;
  if (const auto& now = status.readings) {
    line += status.target_n ? fmt::format("  {:.1f} N (force {:.1f})", *status.target_n, now->force_n.value_or(0.0))
                            : fmt::format("  {} (reference {})", unit.text(now->setpoint_psi, 1),
                                          unit.fixed(now->reference_psi, 1));
  }
  return line;
}

double Pace::left_s(Clock::time_point now, int step, int steps) {
  constexpr auto kRested = std::chrono::minutes(1);  // the line is renewed every 10 s at least, but not in a pause
  if (step < seen_step_ || now - seen_ > kRested) {
    since_ = now;
    from_step_ = step;
  }
  seen_ = now;
  seen_step_ = step;
  if (step <= from_step_) return -1.0;
  return std::chrono::duration<double>(now - since_).count() * (steps - step) / (step - from_step_);
}

Progress::Mode Progress::mode_for(bool quiet) {
  if (quiet) return Mode::kQuiet;
  const char* terminal = std::getenv("TERM");
  const bool dumb = terminal == nullptr || std::string(terminal) == "dumb";
  return isatty(STDERR_FILENO) != 0 && std::getenv("CI") == nullptr && !dumb ? Mode::kTerminal : Mode::kPlain;
}

bool Progress::due(const RunStatus& status) const {
  if (mode_ == Mode::kQuiet) return false;
  const auto passed = Clock::now() - shown_;
  const bool in_real_time = status.rate > 0.0;
  const bool first = phase_.empty() && in_real_time;
  if (mode_ == Mode::kTerminal) return first || passed >= std::chrono::milliseconds(100);
  return first || passed >= std::chrono::seconds(10) ||
         (in_real_time && stage_of(status.phase) != stage_of(phase_) && passed >= std::chrono::seconds(1));
}

void Progress::show(const RunStatus& status) {
  if (mode_ == Mode::kQuiet) return;
  shown_ = Clock::now();
  phase_ = status.phase;
  const double by_pace = pace_.left_s(shown_, status.step, status.steps);
  const bool estimated = status.left_high_s > 0.0 && status.rate > 0.0;
  const std::string line = progress_line(status, estimated ? status.left_s / status.rate : by_pace, unit_);
  if (mode_ == Mode::kTerminal) {
    tty::update_status_line(line);
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

void Notify::run_command(const std::string& event, std::int64_t run, const std::string& reason) const {
  if (command_.empty()) return;
  ChildStart shell;
  // In the background of a separate shell, which ends immediately: the command may take any time and leaves no child
  // process behind.
  shell.arguments = {"/bin/sh", "-c", "(" + command_ + "\n) </dev/null >&2 &"};
  // Replaces those of a run that started this program.
  shell.environment = environment_with(
      {"TACTBENCH_EVENT=" + event, fmt::format("TACTBENCH_RUN={}", run), "TACTBENCH_REASON=" + reason});
  try {
    (void)ChildProgram(std::move(shell)).wait();
  } catch (const std::system_error& error) {
    tty::print(stderr, "warning: --on-event could not be started: {}\n", error.code().message());
  }
}

}  // namespace tactbench::bench
