#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>

#include "analysis/identify/dynamic/dynamic_fit.h"
#include "analysis/models/elam.h"
#include "bench/cli/models/fit_many.h"
#include "bench/cli/session.h"

namespace tactbench::bench {

namespace {

struct FitOptions {
  FitModelsOptions models;
  std::string model_list, fit_list, score_list, mode = "paper", way = "exact", check;
  bool for_others = false;  // an option of a model that is not the dynamic one is given, if only its default
};

std::vector<std::string> models_of(const std::string& list) {
  const std::span<const char* const> known = analysis::model_names();
  if (list == "all") return {known.begin(), known.end()};
  std::vector<std::string> models = split_list(list);
  for (const std::string& model : models) {
    if (std::ranges::find(known, model) != known.end() || model == analysis::kDynamicModel) continue;
    throw Error("TB-USAGE", fmt::format("there is no model '{}'", model), "--model",
                fmt::format("all, or some of {}; or {} alone", fmt::join(known, ", "), analysis::kDynamicModel));
  }
  if (models.empty()) throw Error("TB-USAGE", "no model is named", "--model", "e.g. --model all");
  return models;
}

// The dynamic model is of a run's whole array and all its sequences, and has options of its own.
void check_dynamic(const FitOptions& options) {
  const FitModelsOptions& models = options.models;
  const auto refuse = [](const std::string& what, const std::string& remedy) {
    throw Error("TB-USAGE", what, "fit", remedy);
  };
  const bool dynamic = std::ranges::find(models.models, analysis::kDynamicModel) != models.models.end();
  if (!dynamic && (models.rate_run != 0 || models.creep_run != 0))
    refuse("--rate and --creep are of the dynamic model, and another is named",
           "add --model dynamic, or leave them out");
  if (!dynamic) return;
  if (!options.check.empty())
    refuse("--check fits nothing, and the dynamic model is named to be fitted",
           "leave out --model, --rate and --creep to check a model, or --check to fit");
  if (models.models.size() != 1)
    refuse("the dynamic model is fitted alone, and several models are named", "--model dynamic --rate RUN --creep RUN");
  if ((models.rate_run == 0) != (models.creep_run == 0))
    refuse(
        "lag and creep come from two further runs of the sensor, one of recipe rate and one of creep-levels, and one "
        "alone is named",
        "measure the other (tactbench run rate creep-levels) and name both, --rate RUN --creep RUN; or name none, and "
        "both are left in");
  if (!names_run(models.source) && models.rate_run != 0)
    refuse("lag and creep of a table are found in the table, and runs of them are named",
           "leave out --rate and --creep, or fit a run");
  if (options.for_others || !models.fit.empty() || models.mean_taxel)
    refuse("the dynamic model is of all sequences and of the whole array, always on the linearised output",
           "leave out --fit, --mean-taxel and the options of other models");
}

// The profile's limits count where there is something to judge: held-out runs, and one model of the whole array; its
// laboratory file where something is judged.
void judge_by_profile(FitModelsOptions& models, Session& session) {
  const OperatorProfile& profile = session.profile.values();
  const auto limits = profile.find(ProfileKey::kLimits), lab = profile.find(ProfileKey::kLab);
  if (models.limits.empty() && !models.held_out.empty() && models.models.size() < 2 && limits != profile.end()) {
    models.limits = limits->second.values.front();
    if (!session.quiet && !session.json)
      tty::print(stderr, "judged by {} ({})\n", one_line(models.limits), limits->second.origin);
  }
  if (models.lab.empty() && !models.limits.empty() && lab != profile.end()) models.lab = lab->second.values.front();
}

// Where none is named: fit_models() looks at the data, unless ELAM alone can do what is asked.
void choose_model(const FitOptions& options, FitModelsOptions& models) {
  if (!options.model_list.empty())
    models.models = models_of(options.model_list);
  else if (models.rate_run != 0 || models.creep_run != 0)
    models.models = {analysis::kDynamicModel};
  else if (options.for_others)
    models.elam_since = "options of other models are given";
  else if (!models.fit.empty() || models.mean_taxel)
    models.elam_since = "that is of all sequences and of the whole array";
}

void fit(FitOptions options, Session& session) {
  options.models.fit = split_list(options.fit_list);
  choose_model(options, options.models);
  options.models.score = split_list(options.score_list);
  options.models.identify.free_run = options.mode == "free-run";
  options.models.identify.genetic = options.way == "ga";
  check_dynamic(options);
  if (options.check.empty() && names_runs(options.models.source)) return fit_many(options.models, session);
  judge_by_profile(options.models, session);
  if (!options.models.lab.empty() && options.models.limits.empty())
    throw Error("TB-USAGE", "--lab is for judging, and there are no limits", "--lab",
                "add --limits FILE, or leave --lab out");
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
  verb->add_option("source", options->models.source, "run number, several (1-400,412), or a table (see import)")
      ->required();
  verb->add_option("--model", options->model_list,
                   "some of elam, gpi, mpi, poly, preisach, monotone with commas between, or all; or dynamic: Preisach "
                   "on the linearised output, with the fitted run's creep undone, and lag where --rate and --creep "
                   "name runs, or both as a table with time_s "
                   "tells them (ours) "
                   "[dynamic; elam of tables and of what the dynamic model does not take]");
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
  verb->add_option("--rate", options->models.rate_run, "dynamic: run of recipe rate, which the lag is taken from")
      ->check(CLI::PositiveNumber);
  verb->add_option("--creep", options->models.creep_run,
                   "dynamic: run of recipe creep-levels, which the creep is taken from; may be the same run")
      ->check(CLI::PositiveNumber);
  verb->add_flag(
      "--linearise", options->models.identify.linearise,
      "undo the readout divider of each taxel, one number c, where a test on inner branches finds that it helps "
      "(ours)");
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
  verb->add_option(
      "--limits", options->models.limits,
      "limits file: judge every held-out run and store the verdicts; the worst one counts. Without a held-out run "
      "nothing is judged: the run that the models come from is no evidence. Without this option, held-out runs are "
      "judged by the limits of tactbench.toml, if it names any");
  verb->add_option(
      "--lab", options->models.lab,
      "laboratory file: a reference that is overdue by its dates makes verdicts inconclusive, as in a report. Without "
      "this option that of tactbench.toml, if it names any");
  add_units(*verb, session);
  add_void_too(*verb, session);
  add_common(*verb, session);
  verb->callback([options, verb, &session] {
    for (const char* const name :
         {"--mode", "--identify", "--linearise", "--memory", "--exact-outer", "--splits", "--starts"})
      options->for_others = options->for_others || verb->count(name) > 0;
    fit(*options, session);
  });
}

}  // namespace tactbench::bench
