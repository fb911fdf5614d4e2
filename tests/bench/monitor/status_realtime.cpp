// `status` and `watch` during a run in another process: while it conditions, measures, asks its operator and has ended;
// in a terminal and in a pipe; of a run that is stopped, and of one that was killed.
#include <catch2/catch.hpp>
#include <csignal>
#include <nlohmann/json.hpp>

#include "tests/support/endless_run.h"
#include "tests/support/in_terminal.h"
#include "tests/support/served_rig.h"

using namespace tactbench;
using namespace tactbench::tests;
using nlohmann::json;

namespace {

constexpr double kStatusRate = 10.0;

const std::vector<std::string> kRun = {"--bench", "bench.toml", "--sensor", "S-1", "--operator", "t", "--no-seating"};

struct StatusRig : ServedRig {
  StatusRig() : ServedRig(kStatusRate) {
    const std::string begin = "schema = 1\nunit = \"psi\"\nturning_points = [0, 8, 0]\nstep = 4\ndwell_s = 4\n";
    // Conditioning takes 8 s of real time, so that programs started on a busy machine still see it.
    write_file(
        folder.path("small.toml"),
        begin + "name = \"small\"\nrepeats = 2\n[dwell]\ntolerance_s = 30\n[conditioning]\ncycles = 10\npeak = 8\n");
    write_file(folder.path("asked.toml"), begin +
                                              "name = \"asked\"\n[dwell]\ntolerance_s = 30\n[prompt]\nbefore = "
                                              "\"Point indenter mounted?\"\n");
    write_file(folder.path("long.toml"), begin + "name = \"long\"\nrepeats = 1000\n[dwell]\ntolerance_s = 30\n");
  }
  [[nodiscard]] std::unique_ptr<ChildProcess> start_run_of(const std::vector<std::string>& recipes) const {
    std::vector<std::string> words = {"run"};
    words.insert(words.end(), recipes.begin(), recipes.end());
    words.insert(words.end(), kRun.begin(), kRun.end());
    return start(words);
  }
  [[nodiscard]] json status() const {
    const Finished printed = run({"status", "--json"});
    INFO(printed.err);
    REQUIRE(printed.code == 0);
    return json::parse(printed.out);
  }
  // The first live run once `so`; null when that never comes.
  [[nodiscard]] json live_when(const std::function<bool(const json&)>& so) const {
    json found;
    (void)comes_true([&] {
      const json printed = status();
      if (printed["live"] != true || !so(printed["runs"][0])) return false;
      found = printed["runs"][0];
      return true;
    });
    return found;
  }
};

bool begins(const json& run, const char* phase) { return run["phase"].get<std::string>().starts_with(phase); }

}  // namespace

TEST_CASE("status: reports conditioning, measuring and a question of a live run, and how the run ended") {
  const StatusRig rig;
  const Finished before = rig.run({"status"});
  CHECK(before.code == 0);
  const auto run = rig.start_run_of({"small.toml", "asked.toml"});

  const json conditioning = rig.live_when([](const json& one) { return begins(one, "conditioning"); });
  INFO(rig.log());
  REQUIRE(conditioning.is_object());
  const auto watching = rig.start({"status", "--watch"});  // into the log
  CHECK_THAT(conditioning["phase"].get<std::string>(), Catch::EndsWith(" of 10"));
  CHECK(conditioning["run"] == 1);
  CHECK(conditioning["bench"] == rig.bench_id);
  CHECK(conditioning["frames"] == 0);
  CHECK(conditioning["frames_planned"] == 15);
  CHECK(conditioning["rate"] == kStatusRate);
  CHECK(conditioning["prompts_left"] == 1);

  const json measuring =
      rig.live_when([](const json& one) { return begins(one, "small, step ") && one["frames"] > 1; });
  REQUIRE(measuring.is_object());
  CHECK_THAT(measuring["phase"].get<std::string>(), Catch::Contains(" of 36, repeat ") && Catch::EndsWith("loading"));
  CHECK(measuring["readings"]["time_s"] > conditioning["readings"]["time_s"]);
  CHECK(measuring["left_s"] < conditioning["left_s"]);

  const json asking = rig.live_when([](const json& one) { return one["state"] == "paused"; });
  REQUIRE(asking.is_object());
  CHECK(asking["question"] == "Point indenter mounted?");
  CHECK_THAT(asking["phase"].get<std::string>(), Catch::EndsWith("Point indenter mounted?"));
  CHECK(asking["frames"] == 10);
  CHECK(asking["readings"]["reference_psi"] < 1.0);
  REQUIRE(comes_true([&] { return read_file(rig.folder.path("log")).find("run 1 paused: ") != std::string::npos; }));

  CHECK(rig.run({"resume"}).code == 0);
  CHECK(run->wait() == 0);
  CHECK(watching->wait() == 0);
  const json after = rig.status();
  CHECK(after["live"] == false);
  CHECK(after["runs"].empty());
  CHECK(after["last_run"]["outcome"] == "completed");
  CHECK(after["last_run"]["frames"] == 15);
  CHECK(rig.run({"status"}).code == 0);
  CHECK(rig.run({"status", "--watch", "1"}).code == 0);
  CHECK(rig.run({"status", "--watch"}).code == 2);
  CHECK(rig.run({"status", "9"}).code == 2);
}

TEST_CASE("watch: the array is repainted in place, Ctrl-C ends only the watch, a stop ends run and watch") {
  const StatusRig rig;
  const auto run = rig.start_run_of({"long.toml"});
  REQUIRE(rig.live_when([](const json& one) { return one["frames"] > 0; }).is_object());
  {
    InTerminal watch(rig.folder.path(), {"status", "--watch"}, 80, 24, "");
    CHECK(watch.shows("\x1b[48;5;"));  // the array in colours
    CHECK(watch.shows("\x1b[23F"));    // 6 lines and 17 of the map, painted over
    CHECK_THAT(watch.shown(), Catch::Contains("\x1b[48;5;") && Catch::Contains("hottest row "));
    watch.type("\x03");
    CHECK(watch.wait() == 0);
    CHECK_THAT(watch.shown(), Catch::Contains("tactbench stop 1"));
  }
  CHECK(rig.status()["runs"][0]["state"] == "running");
  InTerminal plain(rig.folder.path(), {"status", "--watch", "1"}, 100, 40, "1");
  CHECK(plain.shows("run 1"));
  CHECK(plain.shown().find("\x1b[48") == std::string::npos);
  CHECK(rig.run({"stop"}).code == 0);
  CHECK(plain.wait() == 4);
  CHECK(run->wait() == 4);
  CHECK(rig.run({"status", "--watch", "1"}).code == 4);
}

TEST_CASE("status: a stopped process is named, a killed one leaves its run, and watch ends with it") {
  EndlessRun run("watched");
  REQUIRE(run.lives());
  const std::string folder = run.folder.path();
  write_file(run.folder.path("seen"), "");
  ChildProcess watching(
      {"/bin/sh", "-c", fmt::format("cd '{}' && exec '{}' status --watch >seen 2>&1", folder, program_path())});
  const auto seen = [&](const char* text) {
    return comes_true([&] { return read_file(run.folder.path("seen")).find(text) != std::string::npos; });
  };
  REQUIRE(seen("simulated clock"));
  run.process().signal(SIGSTOP);
  const Finished silent = run_program(program_path(), {"status", "--bench", "watched"}, folder);
  CHECK(silent.code == 0);
  const json printed = json::parse(run_program(program_path(), {"status", "--json"}, folder).out);
  CHECK(printed["live"] == false);
  CHECK(printed["silent"][0]["run"] == 1);
  CHECK(printed["last_run"]["lives"] == true);
  run.process().signal(SIGKILL);
  CHECK(run.process().wait() == -SIGKILL);
  CHECK(watching.wait() == 3);
}
