#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "analysis/models/elam_pieces.h"
#include "bench/cli/models/fit_models.h"
#include "bench/cli/session.h"

namespace tactbench::bench {

namespace {

struct FitOptions {
  FitModelsOptions models;
  std::string model_list = "elam", fit_list, score_list, mode = "paper", way = "exact", check;
};

std::vector<std::string> models_of(const std::string& list) {
  const std::span<const char* const> known = analysis::model_names();
  if (list == "all") return {known.begin(), known.end()};
  std::vector<std::string> models = split_list(list);
  for (const std::string& model : models) {
    if (std::ranges::find(known, model) != known.end()) continue;
    throw Error(ExitCode::kUsage, "TB-USAGE", fmt::format("there is no model '{}'", model), "--model",
                fmt::format("all, or some of {}", fmt::join(known, ", ")));
  }
  if (models.empty()) throw Error(ExitCode::kUsage, "TB-USAGE", "no model is named", "--model", "e.g. --model all");
  return models;
}

void fit(FitOptions options, Session& session) {
  options.models.models = models_of(options.model_list);
  options.models.fit = split_list(options.fit_list);
  options.models.score = split_list(options.score_list);
  options.models.identify.free_run = options.mode == "free-run";
  options.models.identify.genetic = options.way == "ga";
  if (options.check.empty())
    fit_models(options.models, session);
  else
    check_model(options.check, options.models, session);
}

}  // namespace

void add_fit(CLI::App& app, Session& session) {
  auto options = std::make_shared<FitOptions>();
  CLI::App* verb = app.add_subcommand(
      "fit", "identify models for every taxel of a run or table, score them on what was not fitted, store");
  verb->add_option("source", options->models.source, "run number, or a table (see import)")->required();
  verb->add_option("--model", options->model_list,
                   "some of elam, gpi, mpi, poly, preisach, monotone with commas between, or all")
      ->capture_default_str();
  verb->add_option("--fit", options->fit_list, "fit these sequences alone (names with commas between)");
  verb->add_option("--score", options->score_list,
                   "score on these: sequences, runs or tables with commas between (default: what was not fitted)");
  verb->add_option("--mode", options->mode,
                   "paper: branches start at their measured turning points; free-run: at the model's own")
      ->check(CLI::IsMember({"paper", "free-run"}))
      ->capture_default_str();
  verb->add_option("--identify", options->way, "ELAM: exact, or ga, the paper's genetic algorithm, for comparison")
      ->check(CLI::IsMember({"exact", "ga"}))
      ->capture_default_str();
  verb->add_flag("--memory", options->models.identify.memory, "ELAM: return-point memory, inner loops close (ours)");
  verb->add_flag("--exact-outer", options->models.identify.exact_outer, "ELAM: external branches follow the patterns");
  verb->add_option("--splits", options->models.identify.splits, "ELAM: split points a branch (ours when more than 1)")
      ->check(CLI::Range(1, analysis::kMostSplits))
      ->capture_default_str();
  verb->add_option("--starts", options->models.identify.starts, "GPI: starts of its search")
      ->check(CLI::Range(1, 4096))
      ->capture_default_str();
  verb->add_flag("--mean-taxel", options->models.mean_taxel, "fit and score the mean taxel alone");
  verb->add_option("--mount", options->models.mount, "how the sensor is mounted: kept with the model");
  verb->add_option("--interface", options->models.interface_material, "material on the sensor: kept with the model");
  verb->add_option("-o,--output", options->models.output, "write the one model as a JSON document");
  add_replace(*verb, session);
  verb->add_option(
      "--check", options->check,
      "fit nothing: report whether this MODEL is still good on the source, or needs a new zero, gain or fit");
  add_table_options(*verb, options->models.table);
  verb->add_option("--held-out", options->models.held_out, "score these runs of the same sensor with the models, too")
      ->take_all();
  CLI::Option* limits = verb->add_option(
      "--limits", options->models.limits,
      "limits file: judge every held-out run and store the verdicts; the worst one counts. Without a held-out run "
      "nothing is judged: the run that the models come from is no evidence");
  verb->add_option(
          "--lab", options->models.lab,
          "laboratory file: a reference that is overdue by its dates makes verdicts inconclusive, as in a report")
      ->needs(limits);
  add_void_too(*verb, session);
  add_common(*verb, session);
  verb->callback([options, &session] { fit(*options, session); });
}

}  // namespace tactbench::bench
