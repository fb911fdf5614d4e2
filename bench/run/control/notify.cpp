#include "bench/run/control/notify.h"

#include <fmt/format.h>

#include <cstdio>
#include <system_error>
#include <utility>

#include "bench/common/child_process.h"
#include "bench/common/terminal_safe.h"

namespace tactbench::bench {

void Notify::tell(const std::string& event, std::int64_t run, const std::string& reason) const {
  if (command_.empty()) return;
  ChildStart shell;
  // In the background of a separate shell, which ends immediately: the command may take any time and leaves no child
  // process behind.
  shell.words = {"/bin/sh", "-c", "(" + command_ + "\n) </dev/null >&2 &"};
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
