// Commands, locks and runs between processes: a stopped process, separate logins, two processes that want the same run.
#include <signal.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <nlohmann/json.hpp>
#include <optional>

#include "bench/run/control/machine_name.h"
#include "tests/support/endless_run.h"
#include "tests/support/served_rig.h"

using namespace tactbench;
using namespace tactbench::tests;
using bench::Command;

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

TEST_CASE("commands: another login finds the run of a rig, and is refused the rig") {
  ServedRig rig(10.0);
  write_file(rig.folder.path("long.toml"),
             "schema = 1\nname = \"long\"\nunit = \"psi\"\nturning_points = [0, 8, 0]\nstep = 2\nrepeats = 1000\n");
  write_file(rig.folder.path("short.toml"),
             "schema = 1\nname = \"short\"\nunit = \"psi\"\nturning_points = [0, 8, 0]\nstep = 4\n");
  // As sudo, cron, su and a second seat differ, on the machine's own names.
  const auto login = [&](const std::string& name, const std::string& words) {
    return fmt::format(
        "cd '{0}' && mkdir -p -m 0700 {1} && exec env -u TACTBENCH_RUNTIME_DIR HOME='{0}/{1}' XDG_STATE_HOME='{0}/{1}' "
        "XDG_RUNTIME_DIR='{0}/{1}' TMPDIR='{0}/{1}' '{2}' {3}",
        rig.folder.path(), name, program_path(), words);
  };
  const std::string start = "run long.toml --bench bench.toml --sensor S-1 --operator t -q --no-seating";
  ChildProcess first({"/bin/sh", "-c", login("a", start + " >>log 2>&1")});
  const auto as_other = [&](const std::string& words) {
    return run_program("/bin/sh", {"-c", login("b", words)}, rig.folder.path());
  };
  REQUIRE(
      comes_true([&] { return as_other("resume --bench bench.toml").err.find("TB-RUN-WORD") != std::string::npos; }));
  const Finished refused = as_other(start + " --db other.db");
  CHECK(refused.code == 2);
  CHECK_THAT(refused.err, Catch::Contains("TB-BENCH-LOCKED") && Catch::Contains("run 1 of "));
  const Finished same_store =
      as_other("run short.toml --bench simulated.toml --sensor S-1 --operator t -q --no-seating");
  INFO(same_store.err);
  CHECK(same_store.code == 0);
  CHECK(as_other("stop --bench " + rig.bench_id).code == 0);
  CHECK(first.wait() == 4);
  const auto row = [&](const char* number) {
    return nlohmann::json::parse(rig.run({"runs", "show", number, "--json"}).out)["outcome"];
  };
  CHECK(row("1") == "stopped");  // and not interrupted by the start of run 2
  CHECK(row("2") == "completed");
  CHECK(rig.run({"verify", "1"}).code == 0);
}

TEST_CASE("resume: of two at once one continues, the other is refused, and the record is intact") {
  for (int turn = 0; turn < 3; ++turn) {
    EndlessRun run("resumed");
    REQUIRE(run.lives());
    run.process().signal(SIGKILL);
    (void)run.process().wait();
    std::vector<std::unique_ptr<ChildProcess>> both;
    for (int i = 0; i < 2; ++i) {
      both.push_back(std::make_unique<ChildProcess>(std::vector<std::string>{
          "/bin/sh", "-c",
          fmt::format("cd '{}' && exec '{}' resume 1 -q >>resumed-{} 2>&1", run.folder.path(), program_path(), i)}));
    }
    std::optional<int> codes[2];
    REQUIRE(comes_true([&] {
      for (int i = 0; i < 2; ++i)
        if (!codes[i]) codes[i] = both[i]->ended_within(std::chrono::milliseconds(1));
      return codes[0] || codes[1];
    }));
    const int refused = codes[0] ? 0 : 1;
    CHECK(codes[refused] == 2);
    CHECK_THAT(read_file(run.folder.path(fmt::format("resumed-{}", refused))),
               Catch::Contains("TB-RUN-LIVE") || Catch::Contains("TB-RUN-WORD"));
    REQUIRE(comes_true([&] { return !run.say_to_it().answers.empty(); }));
    CHECK(run.say_to_it(Command::kStop).answers.size() == 1);
    CHECK(both[1 - refused]->wait() == 4);
    const Finished verified = run_program(program_path(), {"verify", "1"}, run.folder.path());
    INFO(verified.out << verified.err);
    CHECK(verified.code == 0);
  }
}
