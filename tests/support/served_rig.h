// The simulated rig in a process of its own (`tactbench simulate`), whose plant outlives the sequencers that use it;
// programs on it, and a reading of its chamber over a connection of the test's own.
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "bench/config/config.h"
#include "devices/pressure/analog_module.h"
#include "devices/pressure/pressure_reference.h"
#include "tests/support/child_process.h"
#include "tests/support/generous_timeouts.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"

namespace tactbench::tests {

class ServedRig {
 public:
  // Times of the instruments run `rate` times as fast, those of the host do not.
  // `more`: further overrides of the bench file.
  explicit ServedRig(double rate, const std::vector<std::string>& more = {})
      : simulator_(words(rate, folder.path("bench.toml"), more)) {
    while (simulator_.line() != "Ctrl-C ends") {
    }
    (void)run({"init"});
    (void)run({"sensors", "add", "S-1", "--type", "sensor.toml"});
    const bench::BenchConfig config = bench::read_bench(folder.path("bench.toml"), {});
    bench_id = config.id;
    module_ = std::make_unique<devices::AnalogModule>(config.module.profile, config.module.endpoint,
                                                      devices::Nanoseconds(0), clock_, config.origin);
    reference_ = std::make_unique<devices::ModuleTransducer>(*module_, config.reference);
  }
  [[nodiscard]] Finished run(const std::vector<std::string>& arguments) const {
    return run_program(program_path(), arguments, folder.path());
  }
  // Runs next to the test; its output goes to the file `log`.
  [[nodiscard]] std::unique_ptr<ChildProcess> start(const std::vector<std::string>& arguments) const {
    std::string line = fmt::format("cd '{}' && exec env {} '{}'", folder.path(), environment, program_path());
    for (const std::string& argument : arguments) line += fmt::format(" '{}'", argument);
    return std::make_unique<ChildProcess>(std::vector<std::string>{"/bin/sh", "-c", line + " >>log 2>&1"});
  }
  [[nodiscard]] std::unique_ptr<ChildProcess> start_run(const std::string& recipe) const {
    return start({"run", recipe, "--bench", "bench.toml", "--sensor", "S-1", "--operator", "t", "-q", "--no-seating"});
  }
  [[nodiscard]] std::unique_ptr<ChildProcess> start_resume(std::int64_t number) const {
    return start({"resume", std::to_string(number), "--bench", "bench.toml", "-q"});
  }
  [[nodiscard]] std::string log() const {
    const std::string text = read_file(folder.path("log"));
    return text.substr(text.size() - std::min<std::size_t>(text.size(), 2000));
  }
  // By the transducer, read as any other client of the module would.
  [[nodiscard]] double psi() {
    (void)module_->read_all();
    return reference_->read().pressure.value();
  }
  // Seconds of real time until the chamber is so; `longest` when it does not get there.
  [[nodiscard]] double seconds_until(const std::function<bool(double psi)>& so, double longest) {
    const auto start = std::chrono::steady_clock::now();
    const auto passed = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); };
    while (!so(psi())) {
      if (passed() >= longest) return longest;
      usleep(5000);
    }
    return std::min(passed(), longest);
  }
  [[nodiscard]] double seconds_until_safe(double longest = 20.0) {
    return seconds_until([](double psi) { return psi < 1.0; }, longest);
  }

  TemporaryFolder folder;
  std::string bench_id;
  std::string environment;  // of what `start` starts: "NAME=value ..."

 private:
  static std::vector<std::string> words(double rate, const std::string& bench, const std::vector<std::string>& more) {
    std::vector<std::string> words = {program_path(),  "simulate",
                                      "--rate",        fmt::format("{}", rate),
                                      "--for",         "3000",
                                      "--write-bench", bench,
                                      "--set",         "limits.disagreement_s=30",
                                      "--set",         fmt::format("bench.id=\"served-{}\"", getpid())};
    for (const sequences::Override& one : roomy_times(rate)) {
      words.insert(words.end(), {"--set", one.key + "=" + one.value});
    }
    for (const std::string& one : more) words.insert(words.end(), {"--set", one});
    return words;
  }

  ChildProcess simulator_;
  devices::SteadyClock clock_{1.0};
  std::unique_ptr<devices::AnalogModule> module_;
  std::unique_ptr<devices::ModuleTransducer> reference_;
};

}  // namespace tactbench::tests
