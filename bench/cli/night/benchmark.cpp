#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "bench/benchmarks/array.h"
#include "bench/benchmarks/charts.h"
#include "bench/benchmarks/compensate.h"
#include "bench/benchmarks/compensate_dynamic.h"
#include "bench/benchmarks/compensation_error.h"
#include "bench/benchmarks/coverage.h"
#include "bench/benchmarks/fleet.h"
#include "bench/benchmarks/identify.h"
#include "bench/benchmarks/large_store.h"
#include "bench/benchmarks/many_rigs.h"
#include "bench/benchmarks/page.h"
#include "bench/benchmarks/report.h"
#include "bench/benchmarks/sequence.h"
#include "bench/benchmarks/specimen.h"
#include "bench/benchmarks/store.h"
#include "bench/benchmarks/wires.h"
#include "bench/cli/session.h"
#include "bench/common/private_files.h"

namespace tactbench::bench {

namespace {

struct BenchmarkOptions {
  std::string name;
  int exchanges = 500, rounds = 5, draws = 10000;
  std::vector<unsigned> sensors = {11, 12, 13};
  bool all_models = false;
  std::string to;
  std::vector<int> runs = {2000, 20000};
};

constexpr const char* kScratch = "tactbench-benchmark";  // folder of the benchmarks that write files

using Measure = std::vector<Figure> (*)(const BenchmarkOptions&);
const std::map<std::string, Measure> measures = {
    {"wires", [](const BenchmarkOptions& o) { return benchmark_wires(o.exchanges); }},
    {"compensate", [](const BenchmarkOptions& o) { return benchmark_compensate(o.rounds); }},
    {"compensate-dynamic", [](const BenchmarkOptions& o) { return benchmark_compensate_dynamic(o.rounds); }},
    {"compensation-error",
     [](const BenchmarkOptions& o) {
       return benchmark_compensation_error(o.sensors, ScratchFolder(kScratch).path(), o.all_models);
     }},
    {"charts", [](const BenchmarkOptions& o) { return benchmark_charts(o.draws); }},
    {"coverage",
     [](const BenchmarkOptions& o) {
       return benchmark_coverage({.sensor_seeds = o.sensors}, ScratchFolder(kScratch).path());
     }},
    {"array", [](const BenchmarkOptions& o) { return benchmark_array(o.rounds); }},
    {"specimen", [](const BenchmarkOptions&) { return benchmark_specimen(); }},
    {"sequence",
     [](const BenchmarkOptions& o) { return benchmark_sequence(o.rounds, ScratchFolder(kScratch).path()); }},
    {"fleet",
     [](const BenchmarkOptions& o) { return benchmark_fleet(o.rounds, o.to, ScratchFolder(kScratch).path()); }},
    {"identify",
     [](const BenchmarkOptions& o) { return benchmark_identify(o.rounds, ScratchFolder(kScratch).path()); }},
    {"large-store",
     [](const BenchmarkOptions& o) { return benchmark_large_store(o.runs, o.rounds, ScratchFolder(kScratch).path()); }},
    {"many-rigs",
     [](const BenchmarkOptions& o) { return benchmark_many_rigs(o.rounds, ScratchFolder(kScratch).path()); }},
    {"store", [](const BenchmarkOptions& o) { return benchmark_store(o.rounds, ScratchFolder(kScratch).path()); }},
    {"page", [](const BenchmarkOptions& o) { return benchmark_page(o.rounds, ScratchFolder(kScratch).path()); }},
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
          "wires: time per exchange over each wire of the simulated rig; sequence: a run's steps against their bare "
          "exchanges and the bare store; compensate: frames of 256 taxels against plain scalar code and mere scaling; "
          "compensate-dynamic: the dynamic compensator's against ELAM's; compensation-error: pressures against the "
          "truth "
          "on simulated sensors, the dynamic compensator compared with ELAM's; coverage: readings within the report's "
          "U of "
          "the truth, by condition of use; "
          "fleet: frames pushed to --to against psql's \\copy of the same rows; identify: taxels against one plain J "
          "each, the other models, threads, growth; store: frames against a plain "
          "file and bare SQLite; report: rendering against writing the bytes; array: simulated frames against their "
          "wire; page: the page's process with 8 viewers, and a run beside it; specimen: what the simulated sensors "
          "are like, paper and harsh; charts: false alarms and power of the "
          "charts of trend and nightly; large-store: verbs on stores of thousands of runs; many-rigs: what a million "
          "simulated characterizations would take")
      ->required()
      ->check(CLI::IsMember(measures));
  verb->add_option("--exchanges", options->exchanges, "number of exchanges; the median counts")
      ->check(CLI::Range(10, 100000))
      ->capture_default_str();
  verb->add_option("--rounds", options->rounds, "number of rounds; the best one counts")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  verb->add_option("--draws", options->draws, "charts: histories a case")
      ->check(CLI::Range(100, 10000000))
      ->capture_default_str();
  verb->add_option("--sensors", options->sensors, "compensation-error, coverage: sensor seeds")->delimiter(',');
  verb->add_option("--to", options->to, "fleet: how to connect to a fleet without runs, made for this alone");
  verb->add_option("--runs", options->runs, "large-store: numbers of runs in its stores")->delimiter(',');
  verb->add_flag("--all-models", options->all_models, "compensation-error: also GPI, MPI, POLY and the other models");
  verb->add_flag("--json", session.json, "one JSON document on standard output");
  verb->callback([options, &session] { benchmark(*options, session); });
}

}  // namespace tactbench::bench
