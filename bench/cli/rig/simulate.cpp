#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>

#include "analysis/json_fields.h"
#include "bench/cli/session.h"
#include "bench/common/output_file.h"
#include "bench/common/overrides.h"
#include "bench/common/stop_request.h"
#include "bench/simulation/simulated_rig.h"

namespace tactbench::bench {

namespace {

struct SimulateOptions {
  std::string bench, write_bench;
  std::vector<std::string> set;
  double rate = 1.0;
  double for_s = 0.0;
};

std::string quoted(const std::string& text) { return fmt::format("\"{}\"", text); }

// A bench file for clients of this rig: the one it was made from, with the addresses that the wires got.
std::string client_bench(const SimulateOptions& options, const BenchConfig& config, const SimulatedRig& rig) {
  sequences::TomlDocument document = sequences::TomlDocument::from_file(find_config(options.bench));
  for (const sequences::Override& override_value : split_overrides(options.set).bench) document.set(override_value);
  document.remove("simulation");
  document.set({"bench.simulator", quoted("external")});
  document.set({"bench.rate", fmt::format("{:.6f}", options.rate)});
  const auto set_endpoint = [&](const std::string& table, const devices::ModbusEndpoint& endpoint) {
    if (endpoint.serial_port.empty()) {
      document.set({table + ".host", quoted(endpoint.host)});
      document.set({table + ".port", fmt::format("{}", endpoint.port)});
    } else {
      document.set({table + ".serial_port", quoted(endpoint.serial_port)});
    }
  };
  if (config.module.present()) set_endpoint("module", config.module.endpoint);
  if (config.reference_gauge && config.reference_gauge->own_line) {
    set_endpoint("reference.gauge", config.reference_gauge->endpoint);
  }
  for (const sequences::Override& address : rig.addresses()) document.set(address);
  return fmt::format("# Written by `tactbench simulate`: a client of that process, while it lives.\n{}\n",
                     document.to_text());
}

void print_served(const SimulatedRig& rig, const Session& session, const SimulateOptions& options) {
  if (session.json) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const Served& served : rig.served()) list.push_back({JSON_FIELDS(served, what, where)});
    print_json("simulate", {{"rate", options.rate}, {"bench", options.write_bench}, {"served", list}});
    return;
  }
  tty::print("simulated rig, process time at {:g} x real time; simulated data only\n", options.rate);
  for (const Served& served : rig.served()) tty::print("  {:<50} {}\n", served.what, served.where);
  if (!options.write_bench.empty()) {
    tty::print(
        "connect:  tactbench devices check --bench {0}\n          tactbench run descending --bench {0} --sensor "
        "S --operator NAME\n",
        options.write_bench);
  } else {
    tty::print("--write-bench FILE writes a bench file that connects to these\n");
  }
  tty::print("Ctrl-C ends\n");
}

void simulate(const SimulateOptions& options, const Session& session) {
  BenchConfig config = read_bench(find_config(options.bench), split_overrides(options.set).bench);
  if (!config.in_process) {
    throw Error("TB-USAGE", "only a simulated bench can be simulated", options.bench,
                "give a bench file with origin = \"simulated\", such as simulated.toml");
  }
  const devices::SteadyClock clock(options.rate);
  const StopRequest stop;
  SimulatedRig rig(config, clock, true);
  if (!options.write_bench.empty())
    write_output(options.write_bench, client_bench(options, config, rig), session.replace);
  print_served(rig, session, options);
  std::fflush(stdout);
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(options.for_s);
  while (stop.signal() == 0 && (options.for_s == 0.0 || std::chrono::steady_clock::now() < end)) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
}

}  // namespace

void add_simulate(CLI::App& app, Session& session) {
  auto options = std::make_shared<SimulateOptions>();
  CLI::App* verb = app.add_subcommand("simulate", "serve the whole simulated rig on real connections, for any client");
  verb->add_option("--set", options->set, "override table.key=value, such as module.port=1502")->take_all();
  verb->add_option("--rate", options->rate, "ratio of process time to real time")
      ->check(CLI::Range(0.1, 100.0))
      ->capture_default_str();
  verb->add_option("--write-bench", options->write_bench, "write a bench file that connects to the served rig");
  add_replace(*verb, session);
  verb->add_option("--for", options->for_s, "end after this many seconds of real time; 0: at Ctrl-C")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  verb->callback([options, &session] {
    options->bench = session.bench_file(kShippedBench);
    simulate(*options, session);
  });
}

}  // namespace tactbench::bench
