// Commands that are told of a run's events.
#include "bench/run/control/progress.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <string>

#include "tests/support/endless_run.h"
#include "tests/support/process.h"
#include "tests/support/variable.h"

using namespace tactbench::bench;
using namespace tactbench::tests;

TEST_CASE("notify: the command gets event, run and reason in its environment, in its own shell") {
  const TemporaryFolder folder;
  const std::string told = folder.path("told");
  const auto appears = [&](const std::string& text) {
    return comes_true([&] { return std::filesystem::exists(told) && read_file(told) == text; });
  };
  const Variable own("TACTBENCH_EVENT", "of an outer run");
  const Notify notify("printf '%s|%s|%s' \"$TACTBENCH_EVENT\" \"$TACTBENCH_RUN\" \"$TACTBENCH_REASON\" >'" +
                      folder.path("new") + "'; mv '" + folder.path("new") + "' '" + told + "' # a comment");
  notify.run_command("done", 17, "all steps 'done'; \"really\"");
  CHECK(appears("done|17|all steps 'done'; \"really\""));
  std::filesystem::remove(told);
  Notify("").run_command("done", 17, "x");
  notify.run_command("waiting", -1, "");
  CHECK(appears("waiting|-1|"));
}
