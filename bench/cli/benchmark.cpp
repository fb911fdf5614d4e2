#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "bench/benchmarks/wires.h"
#include "bench/cli/session.h"

namespace tactbench::bench {

namespace {

struct Options {
  std::string name;
  int exchanges = 500;
};

void benchmark(const Options& options, const Session& session) {
  const std::vector<Figure> figures = benchmark_wires(options.exchanges);
  if (session.json) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const Figure& figure : figures) {
      list.push_back({{"name", figure.name}, {"value", figure.value}, {"unit", figure.unit}});
    }
    print_json("benchmark", {{"benchmark", options.name}, {"figures", list}});
    return;
  }
  for (const Figure& figure : figures) fmt::print("FIGURE {} {:.2f} {}\n", figure.name, figure.value, figure.unit);
}

}  // namespace

void add_benchmark(CLI::App& app, Session& session) {
  auto options = std::make_shared<Options>();
  CLI::App* verb = app.add_subcommand("benchmark", "measure on this machine; prints lines FIGURE name value unit");
  verb->add_option("name", options->name, "wires: time per exchange over each wire of the simulated rig")
      ->required()
      ->check(CLI::IsMember({"wires"}));
  verb->add_option("--exchanges", options->exchanges, "of which the median is taken")
      ->check(CLI::Range(10, 100000))
      ->capture_default_str();
  verb->add_flag("--json", session.json, "one JSON document on standard output");
  verb->callback([options, &session] { benchmark(*options, session); });
}

}  // namespace tactbench::bench
