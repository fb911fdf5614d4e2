// Studies on simulated sensors and random numbers, by name. `compensation`, `coverage` and `fixed` print tables, the
// others lines FIGURE <name> <value> <unit>.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>

#include "bench/common/output_file.h"
#include "bench/common/private_files.h"
#include "tests/benchmarks/study/compensation.h"
#include "tests/benchmarks/study/control_charts.h"
#include "tests/benchmarks/study/coverage.h"
#include "tests/benchmarks/study/draw_seed.h"
#include "tests/benchmarks/study/fixed.h"
#include "tests/benchmarks/study/specimen.h"

using namespace tactbench::bench;

int main(int count, char** words) try {
  CLI::App app("Studies on simulated sensors");
  app.require_subcommand(1);
  int draws = 10000;
  CompensationOptions compensation;
  std::string json;
  bool many = false;
  CLI::App* errors = app.add_subcommand(
      "compensation", "compensated pressures against the truth, by route of calibration, model and kind of history");
  errors->add_option("--seed", compensation.seed, "hexadecimal; of the last commit to code where none is given");
  errors->add_option("--specimens", compensation.specimens, "of these alone")
      ->delimiter(',')
      ->check(CLI::IsMember(specimen_kind_names()));
  errors->add_option("--models", compensation.models, "dynamic, elam, gpi, ...")->delimiter(',')->capture_default_str();
  errors->add_option("--route", compensation.routes,
                     "NAME=RECIPE+RECIPE[:RATE[:CREEP]][,KEY=VALUE...]: beside the default in place of the other two; "
                     "recipes are files or names of shipped ones, the settings those of the first run");
  errors->add_flag("--long", many, "eight sensors of each specimen, every fourth taxel");
  errors->add_option("--sensor-seeds", compensation.sensor_seeds, "in place of those that are drawn")->delimiter(',');
  errors->add_option("--sensors", compensation.sensors, "of each specimen")->check(CLI::Range(1, 1000));
  errors->add_option("--every", compensation.every, "taxels")->check(CLI::Range(1, 256));
  errors->add_option("--json", json, "file for all figures");
  CoverageOptions covered;
  std::string coverage_seed;
  CLI::App* coverage =
      app.add_subcommand("coverage", "readings within the report's U of the truth, by kind of history");
  coverage->add_option("--seed", coverage_seed, "hexadecimal; of the last commit to code where none is given");
  coverage->add_option("--sensors", covered.sensors, "of each specimen")->check(CLI::Range(1, 1000));
  coverage->add_option("--further", covered.further, "runs that are held against U")->check(CLI::Range(1, 100));
  coverage->add_option("--recipe", covered.recipes, "of the run that models are made from")->delimiter(',');
  coverage->add_option("--held-out-recipe", covered.held_out, "of the run that U is counted on");
  CLI::App* specimen = app.add_subcommand("specimen", "what the simulated sensors are like");
  const std::vector<std::string> all = specimen_kind_names();
  std::vector<std::string> chosen = all;
  for (CLI::App* const study : {coverage, specimen})
    study->add_option("--specimens", chosen, "which simulated sensors (default: all)")
        ->delimiter(',')
        ->check(CLI::IsMember(all));
  FixedStudyOptions fixed;
  CLI::App* integers = app.add_subcommand("fixed", "a model in a device's integers against its stream in doubles");
  integers->add_option("--model", fixed.model, "a .json that fit -o wrote")->required();
  integers->add_option("--store", fixed.store)->required();
  integers->add_option("--run", fixed.run, "whose outputs are made a dense noisy stream")->required();
  integers->add_option("--rate", fixed.rate_hz, "frames a second")->capture_default_str();
  integers->add_option("--every", fixed.every, "taxels")->check(CLI::Range(1, 256));
  std::string fixed_seed;
  integers->add_option("--seed", fixed_seed,
                       "of the noise, hexadecimal; of the last commit to code where none is given");
  CLI::App* charts = app.add_subcommand("charts", "false alarms and power of the charts of trend and nightly");
  charts->add_option("--draws", draws, "histories a case")->check(CLI::Range(100, 10000000))->capture_default_str();
  CLI11_PARSE(app, count, words);

  std::vector<SpecimenKind> specimens;
  for (const std::string& word : chosen)
    specimens.push_back(static_cast<SpecimenKind>(std::ranges::find(all, word) - all.begin()));
  const ScratchFolder folder("tactbench-study");
  if (*errors) {
    if (many) compensation.sensors = 8, compensation.every = 4;
    const CompensationStudy study = study_compensation(compensation, folder.path());
    fmt::print("{}", markdown_of(study));
    if (!json.empty()) write_output(json, json_of(study), true);
    return 0;
  }
  if (*integers) {
    fixed.seed = draw_seed(fixed_seed).seed;
    fmt::print("{}", study_fixed(fixed));
    return 0;
  }
  if (*coverage) {
    const DrawSeed drawn = draw_seed(coverage_seed);
    covered.seed = drawn.seed;
    covered.specimens = specimens;
    fmt::print("seed {:016x}{}\n\n{}", drawn.seed, drawn.commit.empty() ? "" : ", of commit " + drawn.commit,
               markdown_of(study_coverage(covered, folder.path())));
    return 0;
  }
  const std::vector<Figure> figures = *charts ? benchmark_charts(draws) : benchmark_specimen(specimens);
  for (const Figure& figure : figures) fmt::print("FIGURE {} {:.2f} {}\n", figure.name, figure.value, figure.unit);
} catch (const std::exception& error) {  // a recipe that is not there, a model of no such name
  fmt::print(stderr, "{}\n", error.what());
  return 2;
}
