// Commands that are told of a run's events.
#include "bench/run/control/notify.h"

#include <catch2/catch.hpp>
#include <chrono>
#include <filesystem>
#include <string>
#include <thread>

#include "tests/support/process.h"
#include "tests/support/variable.h"

using namespace tactbench::bench;
using namespace tactbench::tests;

namespace {

bool appears(const std::string& path, const std::string& text) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (std::chrono::steady_clock::now() < end) {
    if (std::filesystem::exists(path) && read_file(path) == text) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return false;
}

}  // namespace

TEST_CASE("notify: a command is told event, run and reason, in a shell of its own, whatever the environment says") {
  const TemporaryFolder folder;
  const std::string told = folder.path("told");
  const Variable own("TACTBENCH_EVENT", "of an outer run");
  const Notify notify("printf '%s|%s|%s' \"$TACTBENCH_EVENT\" \"$TACTBENCH_RUN\" \"$TACTBENCH_REASON\" >'" +
                      folder.path("new") + "'; mv '" + folder.path("new") + "' '" + told + "' # a comment");
  notify.tell("done", 17, "all steps 'done'; \"really\"");
  CHECK(appears(told, "done|17|all steps 'done'; \"really\""));
  std::filesystem::remove(told);
  Notify("").tell("done", 17, "x");
  notify.tell("waiting", -1, "");
  CHECK(appears(told, "waiting|-1|"));
}
