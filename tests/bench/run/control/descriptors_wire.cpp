// Talks with runs leave nothing open, at either end.
#include <catch2/catch.hpp>
#include <filesystem>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "bench/common/error.h"
#include "bench/run/control/client_words.h"
#include "bench/run/control/control_socket.h"
#include "bench/run/control/machine_name.h"
#include "bench/run/control/run_connection.h"
#include "tests/devices/few_descriptors.h"
#include "tests/support/endless_run.h"

using namespace tactbench::bench;
using namespace tactbench::tests;

namespace {

std::ptrdiff_t open_descriptors() {
  const std::filesystem::directory_iterator all("/proc/self/fd");
  return std::distance(begin(all), end(all));
}

// What a live run of bench "thrifty" answers from.
struct ThriftyRun {
  ThriftyRun() {
    config.id = "thrifty";
    RunStatus status;
    status.run = 3;
    status.state = RunState::kRunning;
    control.publish(status);
  }
  BenchConfig config;
  Control control;
};

}  // namespace

TEST_CASE("descriptors: asking, commanding, following and answering a run leave none open") {
  ThriftyRun run;
  const auto before_run = open_descriptors();
  {
    const ControlSocket socket(run.config, run.control, 3);
    REQUIRE(send_command("thrifty", Command::kStatus));
    std::ptrdiff_t before = 0;
    CHECK(comes_true(
        [&] { return (before = open_descriptors()) == before_run + 4; }));  // two names, the word to stop, the spare
    for (int i = 0; i < 5; ++i) {
      CHECK(send_command("thrifty", Command::kStatus));
      CHECK(send_command("thrifty", Command::kPause));
      CHECK(send_command("thrifty", Command::kResume));
      CHECK_FALSE(send_command("not-there", Command::kStatus));
      RunConnection follower("thrifty", "follow");
      CHECK(comes_true([&] { return follower.newest().has_value(); }));
      RunConnection answering("thrifty", answer_words(1, "yes", ""));
      CHECK(comes_true([&] { return answering.newest().has_value(); }));
      CHECK(MachineName("thrifty").owner() != "");
      CHECK_FALSE(MachineName("thrifty").held());
    }
    CHECK(comes_true([&] { return open_descriptors() == before; }));
  }
  CHECK(open_descriptors() == before_run);
}

TEST_CASE("descriptors: a run whose process may open no more still hears commands, one after the other") {
  ThriftyRun run;
  const ControlSocket socket(run.config, run.control, 3);
  REQUIRE(send_command("thrifty", Command::kStatus));
  std::vector<bool> taken;
  {
    const FewDescriptors for_the_client(1);
    for (const Command command :
         {Command::kPause, Command::kResume, Command::kPause, Command::kStop, Command::kPanic}) {
      const auto answer = send_command("thrifty", command);
      taken.push_back(answer && answer->taken);
    }
  }
  CHECK(taken == std::vector<bool>(5, true));
}

TEST_CASE("descriptors: a run that finds too few to be commanded says so, and ends") {
  BenchConfig config;
  config.id = "starved";
  Control control;
  for (int left = 0; left < 6; ++left) {
    std::string id = "none";
    try {
      const FewDescriptors few(left);
      const ControlSocket socket(config, control, 3);
    } catch (const Error& error) {
      id = error.id();
    }
    INFO(left << " descriptors left: " << id);
    CHECK((id == "none" || id == "TB-SYSTEM-LIMIT" || id == "TB-BENCH-NAME"));
    CHECK((id == "none") == (left >= 3));
  }
}
