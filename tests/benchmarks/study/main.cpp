// Studies on simulated sensors and random numbers, by name; each prints lines FIGURE <name> <value> <unit>.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "bench/common/private_files.h"
#include "tests/benchmarks/study/charts.h"
#include "tests/benchmarks/study/compensation_error.h"
#include "tests/benchmarks/study/coverage.h"
#include "tests/benchmarks/study/specimen.h"

using namespace tactbench::bench;

int main(int count, char** words) {
  CLI::App app("Studies on simulated sensors: prints lines FIGURE name value unit");
  app.require_subcommand(1);
  std::vector<unsigned> sensors = {11, 12, 13};
  bool all_models = false;
  int draws = 10000;
  CLI::App* error = app.add_subcommand("compensation-error", "corrected pressures against the reference, by condition");
  error->add_flag("--all-models", all_models, "also GPI, MPI, POLY and the other models");
  CLI::App* coverage = app.add_subcommand("coverage", "readings within the report's U of the truth, by use");
  for (CLI::App* const study : {error, coverage})
    study->add_option("--sensors", sensors, "sensor seeds")->delimiter(',');
  CLI::App* specimen = app.add_subcommand("specimen", "what the simulated sensors are like");
  const std::vector<std::string> all = specimen_words();
  std::vector<std::string> chosen = all;
  for (CLI::App* const study : {error, coverage, specimen})
    study->add_option("--specimens", chosen, "which simulated sensors (default: all)")
        ->delimiter(',')
        ->check(CLI::IsMember(all));
  CLI::App* charts = app.add_subcommand("charts", "false alarms and power of the charts of trend and nightly");
  charts->add_option("--draws", draws, "histories a case")->check(CLI::Range(100, 10000000))->capture_default_str();
  CLI11_PARSE(app, count, words);

  std::vector<SpecimenKind> specimens;
  for (const std::string& word : chosen)
    specimens.push_back(static_cast<SpecimenKind>(std::ranges::find(all, word) - all.begin()));
  const ScratchFolder folder("tactbench-study");
  const std::vector<Figure> figures =
      *error      ? benchmark_compensation_error(specimens, sensors, folder.path(), all_models)
      : *coverage ? benchmark_coverage({.sensor_seeds = sensors, .specimens = specimens}, folder.path())
      : *charts   ? benchmark_charts(draws)
                  : benchmark_specimen(specimens);
  for (const Figure& figure : figures) fmt::print("FIGURE {} {:.2f} {}\n", figure.name, figure.value, figure.unit);
}
