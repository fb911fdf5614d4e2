// A simulated rig in the test's own process, in real time, and the bench file with which another process (or a Rig of
// this one) is its client; the test can read the plant's truth.
#pragma once

#include <fmt/format.h>
#include <catch2/catch.hpp>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "bench/guard/trip.h"
#include "bench/simulation/simulated_rig.h"
#include "tests/support/child_process.h"
#include "tests/support/generous_timeouts.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"
#include "tests/support/text.h"

namespace tactbench::tests {

class HostedRig {
 public:
  // A shipped simulated bench, without the lines that begin with one of `left_out`.
  explicit HostedRig(const std::vector<sequences::Override>& overrides = {},
                     const std::vector<std::string>& left_out = {}, const std::string& shipped = "simulated.toml")
      : text_(text_without(left_out, shipped)),
        config_(bench::parse_bench(text_, "simulated.toml", with_room(overrides, shipped))),
        rig_(config_, clock_, true) {
    const bench::TripFile trip(config_.id);  // of the test before
    std::filesystem::remove(trip.path());
    std::filesystem::remove(trip.dead_man_path());
    auto document = sequences::TomlDocument::from_text(text_, "simulated.toml");
    for (const sequences::Override& one : with_room(overrides, shipped)) {
      if (!one.key.starts_with("simulation.")) document.set(one);
    }
    const auto quoted = [](const std::string& text) { return fmt::format("\"{}\"", text); };
    document.remove("simulation");
    document.set({"bench.simulator", quoted("external")});
    if (config_.regulator_kind == bench::RegulatorKind::kSerial) {
      document.set({"reference.gauge.port", fmt::format("{}", config_.reference_gauge->endpoint.port)});
    } else if (const auto& endpoint = config_.module.endpoint; endpoint.serial_port.empty()) {
      document.set({"module.port", fmt::format("{}", endpoint.port)});
    } else {
      document.set({"module.serial_port", quoted(endpoint.serial_port)});
    }
    for (const sequences::Override& address : rig_.addresses()) document.set(address);
    write_file(folder.path("bench.toml"), document.to_text());
  }
  HostedRig(const HostedRig&) = delete;
  HostedRig& operator=(const HostedRig&) = delete;

  [[nodiscard]] bench::BenchConfig client() const {
    bench::BenchConfig config = bench::read_bench(folder.path("bench.toml"), {});
    config.dead_man.program = program_path();
    return config;
  }
  [[nodiscard]] double psi() { return rig_.plant().true_pressure().value(); }
  [[nodiscard]] double force_n() { return -rig_.plant().wrench().force_n[2]; }

  // `tactbench run` in a process of its own, of a recipe in psi that begins with `levels` and is called hold.toml.
  [[nodiscard]] std::unique_ptr<ChildProcess> begin_run(const std::string& levels) const {
    write_file(folder.path("hold.toml"), "schema = 1\nname = \"hold\"\nunit = \"psi\"\nturning_points = " + levels);
    const std::string type = bench::find_config("sensor.toml"), db = folder.path("runs.db");
    REQUIRE(call(folder, {"sensors", "add", "S-1", "--type", type, "--db", db}).code == 0);
    return std::make_unique<ChildProcess>(
        std::vector<std::string>{program_path(), "run", folder.path("hold.toml"), "--no-seating", "--bench",
                                 folder.path("bench.toml"), "--sensor", "S-1", "--operator", "t", "-q", "--db", db});
  }

  // Seconds until `done`; gives up after `longest`.
  static double seconds_until(const std::function<bool()>& done, double longest) {
    const auto start = std::chrono::steady_clock::now();
    const auto passed = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); };
    while (!done() && passed() < longest) std::this_thread::sleep_for(std::chrono::milliseconds(2));
    return passed();
  }

  TemporaryFolder folder;

 private:
  static std::vector<sequences::Override> with_room(const std::vector<sequences::Override>& overrides,
                                                    const std::string& shipped) {
    std::vector<sequences::Override> all = roomy_times(1.0, shipped == "simulated-serial.toml");
    all.insert(all.end(), overrides.begin(), overrides.end());
    return all;
  }
  static std::string text_without(const std::vector<std::string>& left_out, const std::string& shipped) {
    std::string text;
    for (const std::string& line : lines_of(read_file(bench::find_config(shipped)))) {
      const bool out =
          std::any_of(left_out.begin(), left_out.end(), [&](const auto& one) { return line.starts_with(one); });
      if (!out) text += line + "\n";
    }
    return text;
  }
  const devices::SteadyClock clock_{1.0};
  const std::string text_;
  bench::BenchConfig config_;
  bench::SimulatedRig rig_;
};

}  // namespace tactbench::tests
