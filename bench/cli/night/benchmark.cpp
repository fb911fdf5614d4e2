#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "bench/benchmarks/array.h"
#include "bench/benchmarks/compensate.h"
#include "bench/benchmarks/identify.h"
#include "bench/benchmarks/report.h"
#include "bench/benchmarks/sequence.h"
#include "bench/benchmarks/store.h"
#include "bench/benchmarks/wires.h"
#include "bench/cli/session.h"
#include "bench/common/private_files.h"

namespace tactbench::bench {

namespace {

struct BenchmarkOptions {
  std::string name;
  int exchanges = 500, rounds = 5;
};

constexpr const char* kScratch = "tactbench-benchmark";  // of those that write files

using Measure = std::vector<Figure> (*)(const BenchmarkOptions&);
const std::map<std::string, Measure> measures = {
    {"wires", [](const BenchmarkOptions& o) { return benchmark_wires(o.exchanges); }},
    {"compensate", [](const BenchmarkOptions& o) { return benchmark_compensate(o.rounds); }},
    {"array", [](const BenchmarkOptions& o) { return benchmark_array(o.rounds); }},
    {"sequence",
     [](const BenchmarkOptions& o) { return benchmark_sequence(o.rounds, ScratchFolder(kScratch).path()); }},
    {"identify",
     [](const BenchmarkOptions& o) { return benchmark_identify(o.rounds, ScratchFolder(kScratch).path()); }},
    {"store", [](const BenchmarkOptions& o) { return benchmark_store(o.rounds, ScratchFolder(kScratch).path()); }},
    {"report", [](const BenchmarkOptions& o) { return benchmark_report(o.rounds, ScratchFolder(kScratch).path()); }}};

void benchmark(const BenchmarkOptions& options, const Session& session) {
  const std::vector<Figure> figures = measures.at(options.name)(options);
  if (session.json) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const Figure& figure : figures) {
      list.push_back({{"name", figure.name}, {"value", figure.value}, {"unit", figure.unit}});
    }
    print_json("benchmark", {{"benchmark", options.name}, {"figures", list}});
    return;
  }
  for (const Figure& figure : figures) tty::print("FIGURE {} {:.2f} {}\n", figure.name, figure.value, figure.unit);
}

}  // namespace

void add_benchmark(CLI::App& app, Session& session) {
  auto options = std::make_shared<BenchmarkOptions>();
  CLI::App* verb = app.add_subcommand("benchmark", "measure on this machine; prints lines FIGURE name value unit");
  verb->add_option(
          "name", options->name,
          "wires: time per exchange over each wire of the simulated rig; sequence: a run's steps beside their bare "
          "exchanges and the bare store; compensate: frames of 256 taxels beside plain scalar code and a mere scaling; "
          "identify: taxels beside one plain J each, the other models, threads, growth; store: frames beside a plain "
          "file and bare SQLite; report: its file beside writing the bytes; array: simulated frames beside their wire")
      ->required()
      ->check(CLI::IsMember(measures));
  verb->add_option("--exchanges", options->exchanges, "of which the median is taken")
      ->check(CLI::Range(10, 100000))
      ->capture_default_str();
  verb->add_option("--rounds", options->rounds, "of which the best is taken")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  verb->add_flag("--json", session.json, "one JSON document on standard output");
  verb->callback([options, &session] { benchmark(*options, session); });
}

}  // namespace tactbench::bench
