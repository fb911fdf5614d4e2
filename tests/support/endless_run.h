// `tactbench run` of a recipe that does not end, on a bench simulated in its own process, with a unique bench id.
#pragma once

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "bench/run/control/control_client.h"
#include "tests/support/child_process.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"

namespace tactbench::tests {

inline bool comes_true(const std::function<bool()>& so, std::chrono::seconds longest = std::chrono::seconds(60)) {
  const auto end = std::chrono::steady_clock::now() + longest;
  while (!so()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
}

// Within a minute there is no such process, or one whose end nobody has asked for yet.
inline bool process_ends(const std::string& number) {
  return comes_true([&] {
    std::string line;
    std::getline(std::ifstream("/proc/" + number + "/stat"), line);
    const std::size_t at = line.rfind(')');
    return at == std::string::npos || line.at(at + 2) == 'Z';
  });
}

class EndlessRun {
 public:
  // `before`: shell words that the program is started behind, "setpriv --reuid=5 ".
  explicit EndlessRun(const std::string& bench_id, const std::string& before = {}) : bench_id_(bench_id) {
    write_file(folder.path("long.toml"),
               "schema = 1\nname = \"long\"\nunit = \"psi\"\nturning_points = [0, 60, 0]\nstep = 2\nrepeats = 1000\n");
    (void)run_program(program_path(), {"init"}, folder.path());
    (void)run_program(program_path(), {"sensors", "add", "S-1", "--type", "sensor.toml"}, folder.path());
    if (!before.empty()) (void)run_program("/bin/sh", {"-c", "chmod -R a+rwX ."}, folder.path());
    run_ = std::make_unique<ChildProcess>(std::vector<std::string>{
        "/bin/sh", "-c",
        fmt::format("cd '{}' && exec {}'{}' run long.toml --bench bench.toml --set 'bench.id=\"{}\"' --sensor S-1 "
                    "--operator t -q --no-seating >>log 2>&1",
                    folder.path(), before, program_path(), bench_id)});
  }
  // Waits until it runs; prints its log where it ended before.
  [[nodiscard]] bool lives() const {
    bool running = false;
    (void)comes_true([&] {
      const bench::RunReplies heard = say_to_it();
      running = !heard.answers.empty() && heard.answers[0].status.state == bench::RunState::kRunning;
      return running || run_->ended_within(std::chrono::milliseconds(0));
    });
    if (!running) WARN("the run ended before it ran: " << log());
    return running;
  }
  [[nodiscard]] bench::RunReplies say_to_it(bench::Command command = bench::Command::kStatus) const {
    bench::ListenOptions options;
    options.longest = std::chrono::seconds(1);
    return bench::send_to_runs(bench::run_names(bench_id_), command, options);
  }
  [[nodiscard]] ChildProcess& process() { return *run_; }
  [[nodiscard]] std::string log() const { return read_file(folder.path("log")); }

  const TemporaryFolder folder;

 private:
  std::string bench_id_;
  std::unique_ptr<ChildProcess> run_;
};

}  // namespace tactbench::tests
