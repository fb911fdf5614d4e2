// Commands to runs in other processes, one of which is stopped.
#include <signal.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <optional>

#include "bench/run/control/machine_name.h"
#include "tests/support/endless_run.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

// With its real time, that of starting the program included.
struct Timed {
  Finished finished;
  double seconds = 0.0;
};

Timed timed(const std::vector<std::string>& words, const std::string& folder) {
  const auto begun = std::chrono::steady_clock::now();
  Timed done{run_program(program_path(), words, folder), 0.0};
  done.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  return done;
}

}  // namespace

TEST_CASE("commands: a stopped run with a full queue is named, and commands to another run are answered") {
  struct Row {
    bool full;
    std::vector<std::string> words;
  };
  const Row row = GENERATE(
      values<Row>({{false, {"panic"}}, {true, {"panic", "--db", "runs.db"}}, {true, {"stop", "--bench", "two"}}}));
  EndlessRun frozen("one"), healthy("two");
  REQUIRE(frozen.lives());
  REQUIRE(healthy.lives());
  frozen.process().signal(SIGSTOP);
  const std::string name = bench::run_names("one").at(0);
  std::vector<int> waiting;
  for (int one = row.full ? bench::connect_to_name(name) : -1; one >= 0; one = bench::connect_to_name(name))
    waiting.push_back(one);
  CHECK(waiting.empty() == !row.full);
  const std::string folder = healthy.folder.path();
  const Timed unnamed = timed({"stop"}, folder);
  CHECK(unnamed.finished.code == 2);
  CHECK_THAT(unnamed.finished.err,
             Catch::Contains("TB-RUN-AMBIGUOUS") && Catch::Contains("'one'") && Catch::Contains("'two'"));
  const Timed silent = timed({"panic", "--bench", "one"}, folder);
  CHECK(silent.finished.code == 2);
  CHECK_THAT(silent.finished.err, Catch::Contains("TB-RUN-SILENT") && Catch::Contains("'one'"));
  const Timed heard = timed(row.words, folder);
  INFO(heard.finished.err);
  CHECK(heard.finished.code == 0);
  WARN(fmt::format("FIGURE answer_beside_a_stopped_run {:.3f} s", heard.seconds));
  for (const Timed* each : {&unnamed, &silent, &heard}) CHECK(each->seconds < 20.0);  // 2 s are meant
  CHECK(healthy.process().wait() == 4);
  for (const int one : waiting) close(one);
  frozen.process().signal(SIGCONT);  // it may still find the panic
  std::optional<int> code;
  REQUIRE(comes_true([&] {
    (void)timed({"stop", "--bench", "one"}, folder);
    return (code = frozen.process().ended_within(std::chrono::milliseconds(50))).has_value();
  }));
  CHECK(code == 4);
}
