#include "bench/cli/models/fit.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "analysis/counted.h"
#include "analysis/identify/dynamic/dynamic_fit.h"
#include "analysis/identify/stored/model_document.h"
#include "analysis/models/elam.h"
#include "bench/cli/session.h"
#include "db/run_store.h"

namespace tactbench::bench {

namespace {

struct FitOptions {
  FitModelsOptions models;
  std::string model_list, fit_list, score_list, mode = "paper", way = "exact";
  bool for_others = false;  // an option of a model that is not the dynamic one is given, if only its default
};

std::vector<std::string> models_of(const std::string& list) {
  const std::vector<std::string> known = analysis::model_names();
  if (list == "all") return known;
  std::vector<std::string> models = split_list(list);
  for (const std::string& model : models) {
    if (std::ranges::find(known, model) != known.end() || model == analysis::kDynamicModel) continue;
    throw Error("TB-USAGE", fmt::format("there is no model '{}'", model), "--model",
                fmt::format("{}, or {}", fmt::join(known, ", "), analysis::kDynamicModel));
  }
  if (models.empty()) throw Error("TB-USAGE", "no model is named", "--model", "e.g. --model elam");
  return models;
}

// The dynamic model is made for a run's whole array and all its sequences, and has its own options.
void check_dynamic(const FitOptions& options) {
  const FitModelsOptions& models = options.models;
  const auto refuse = [](const std::string& what, const std::string& remedy) {
    throw Error("TB-USAGE", what, "fit", remedy);
  };
  const bool dynamic = std::ranges::find(models.models, analysis::kDynamicModel) != models.models.end();
  if (!dynamic && (models.rate_run != 0 || models.creep_run != 0))
    refuse("--rate and --creep belong to the dynamic model, but another model is named",
           "add --model dynamic, or leave them out");
  if (!dynamic) return;
  if (models.models.size() != 1)
    refuse("the dynamic model is fitted alone, but several models are named",
           "tactbench fit RUN; a report's annex of models shows its error together with that of the others");
  if ((models.rate_run == 0) != (models.creep_run == 0))
    refuse(
        "lag and creep need two further runs of the sensor, one of recipe rate and one of creep-levels, but only one "
        "is named",
        "measure the other (tactbench run rate creep-levels) and name both, --rate RUN --creep RUN; or name none: lag "
        "and creep are then not compensated");
  if (!is_run_number(models.source) && models.rate_run != 0)
    refuse("for a table, lag and creep are found in the table, but --rate or --creep name runs",
           "leave out --rate and --creep, or fit a run");
  if (options.for_others || !models.fit.empty() || models.mean_taxel)
    refuse("the dynamic model is always made for all sequences and the whole array, on the linearised output",
           "leave out --fit, --mean-taxel and the options of other models");
}

// If no model is named, fit_models() decides by the data, unless only ELAM supports the options.
void choose_model(const FitOptions& options, FitModelsOptions& models) {
  if (!options.model_list.empty())
    models.models = models_of(options.model_list);
  else if (models.rate_run != 0 || models.creep_run != 0)
    models.models = {analysis::kDynamicModel};
  else if (options.for_others)
    models.elam_reason = "the options belong to other models than dynamic";
  else if (!models.fit.empty() || models.mean_taxel)
    models.elam_reason = "dynamic is made for all sequences and the whole array";
}

std::vector<std::int64_t> chosen_runs(const std::string& source, const db::RunReader& store, bool void_too) {
  const std::vector<RunRange> ranges = run_ranges(source);
  std::vector<std::int64_t> chosen;
  for (const db::RunRecord& run : store.runs()) {
    const auto inside = [&](const RunRange& range) { return range.holds(run.run); };
    if (std::ranges::none_of(ranges, inside) || run.outcome == db::Outcome::kIncomplete) continue;
    if ((run.is_void() && !void_too) || store.pruned(run.run) || store.frame_count(run.run) == 0) continue;
    chosen.push_back(run.run);
  }
  if (!chosen.empty()) return chosen;
  throw Error("TB-FIT-NONE", fmt::format("none of the runs {} can be fitted", source), store.path(),
              "tactbench runs list shows the runs; --void-too includes void runs");
}

// Fits the runs of `options.source` that are in the store, have ended, are not void (unless void runs are included) and
// have frames. Runs that cannot be fitted are reported, and the exit code is then 6.
void fit_many(const FitModelsOptions& options, Session& session) {
  if (!options.output.empty() || !options.plot.empty() || !options.score.empty() || options.rate_run != 0 ||
      options.mean_taxel)
    throw Error("TB-USAGE", "with several runs, fit makes one model per run, of every taxel", "fit",
                "leave out --score, --rate, --creep, --output, --plot and --mean-taxel; or name one run");
  const std::vector<std::int64_t> runs =
      chosen_runs(options.source, db::RunStore::open_read_only(session.db), session.void_too);
  auto list = nlohmann::ordered_json::array();
  std::size_t failed = 0;
  for (const std::int64_t run : runs) {
    FitModelsOptions own = options;
    nlohmann::ordered_json row = {{"run", run}};
    try {
      own.source = std::to_string(run);
      const JudgedFit fit = fit_and_judge(own, session);
      const analysis::Evaluation& e = fit.evaluations.front().evaluation;
      row.update({{"fit", fit.model.fit}, {"taxels", fit.model.fitted().size()}, {"mean_error_psi", e.mean_error_psi}});
      if (!session.json)
        tty::print("run {:>5}: fit {}, {}, {}; mean error on the run itself {:.3f} psi\n", run, fit.model.fit,
                   analysis::label_of(fit.model), analysis::counted(fit.model.fitted().size(), "taxel"),
                   e.mean_error_psi);
    } catch (...) {
      const Error error = as_error(std::current_exception());
      if (error.code() == ExitCode::kStore || error.code() == ExitCode::kStopped || error.code() == ExitCode::kInternal)
        throw;
      ++failed;
      row["error"] = error.id();
      if (!session.json) tty::print("run {:>5}: not fitted: {} [{}]\n", run, one_line(error.what()), error.id());
    }
    list.push_back(row);
  }
  if (failed > 0) session.code = ExitCode::kInconclusive;
  if (session.json)
    print_json("fit.runs", {{"store", session.db}, {"runs", list}});
  else
    tty::print("{} fitted, {} not\n", analysis::counted(list.size() - failed, "run"), failed);
}

void fit(FitOptions options, Session& session) {
  options.models.fit = split_list(options.fit_list);
  choose_model(options, options.models);
  options.models.score = split_list(options.score_list);
  options.models.identify.free_run = options.mode == "free-run";
  options.models.identify.genetic = options.way == "ga";
  check_dynamic(options);
  if (is_run_list(options.models.source)) return fit_many(options.models, session);
  fit_models(options.models, session);
}

// Options of `fit` and of `compare`.
void add_identification(CLI::App& verb, FitOptions& options) {
  verb.add_option("--fit", options.fit_list, "fit only these sequences (names separated by commas)");
  verb.add_option(
      "--score", options.score_list,
      "score on these: sequences, runs or tables, separated by commas (default: the sequences that were not fitted)");
  verb.add_option("--mode", options.mode,
                  "paper: branches start at their measured turning points; free-run: at the model's own")
      ->check(CLI::IsMember({"paper", "free-run"}))
      ->capture_default_str();
  verb.add_option("--identify", options.way, "ELAM: exact, or ga, the paper's genetic algorithm, for comparison")
      ->check(CLI::IsMember({"exact", "ga"}))
      ->capture_default_str();
  verb.add_flag(
      "--linearise", options.models.identify.linearise,
      "invert the readout divider of each taxel, one number c, if a test on inner branches shows that it helps (ours)");
  verb.add_flag("--memory", options.models.identify.memory, "ELAM: return-point memory, inner loops close (ours)");
  verb.add_flag("--exact-outer", options.models.identify.exact_outer, "ELAM: external branches follow the patterns");
  verb.add_option("--splits", options.models.identify.splits, "ELAM: split points per branch (ours if more than 1)")
      ->check(CLI::Range(1, analysis::kMaxSplits))
      ->capture_default_str();
  verb.add_option("--starts", options.models.identify.starts, "GPI: starts of its search")
      ->check(CLI::Range(1, 4096))
      ->capture_default_str();
  verb.add_flag("--mean-taxel", options.models.mean_taxel, "fit and score only the mean taxel");
  for (const char* const name : {"--mode", "--identify", "--linearise", "--memory", "--exact-outer", "--splits",
                                 "--starts", "--mean-taxel", "--fit", "--score"})
    verb.get_option(name)->group(kRareOptions);
}

bool for_others(const CLI::App& verb) {
  constexpr std::array kOfOthers = {"--mode",        "--identify", "--linearise", "--memory",
                                    "--exact-outer", "--splits",   "--starts"};
  return std::ranges::any_of(kOfOthers, [&](const char* name) { return verb.count(name) > 0; });
}

}  // namespace

void add_fit(CLI::App& app, Session& session) {
  auto options = std::make_shared<FitOptions>();
  CLI::App* verb =
      app.add_subcommand("fit",
                         "make a model of every taxel of a run or table, and store it\n"
                         "Its errors are those on its own data; `judge` reports its errors on further runs.");
  verb->add_option("source", options->models.source, "run number, several (1-400,412), or a table (see runs import)")
      ->required();
  verb->add_option("--model", options->model_list,
                   fmt::format("dynamic: Preisach on the linearised output, creep undone, and lag where --rate and "
                               "--creep name runs, or both as a table with time_s shows them (ours); or one of {}; "
                               "elam is the paper's [dynamic; elam of tables and of what the dynamic model does not "
                               "take]",
                               fmt::join(analysis::model_names(), ", ")));
  verb->add_option("--rate", options->models.rate_run, "dynamic: run of recipe rate, which the lag is taken from")
      ->check(CLI::PositiveNumber);
  verb->add_option("--creep", options->models.creep_run,
                   "dynamic: run of recipe creep-levels, from which the creep is fitted; may be the same run")
      ->check(CLI::PositiveNumber);
  verb->add_option("-o,--output", options->models.output, "write the model as a JSON document");
  verb->add_option("--plot", options->models.plot, "draw the measured loop with the models: an SVG file");
  add_replace(*verb, session);
  add_void_too(*verb, session);
  add_all(*verb, session);
  add_table_options(*verb, options->models.table);
  verb->add_option("--mount", options->models.mount, "how the sensor is mounted: kept with the model")
      ->group(kRareOptions);
  verb->add_option("--interface", options->models.interface_material, "material on the sensor: kept with the model")
      ->group(kRareOptions);
  add_identification(*verb, *options);
  verb->callback([options, verb, &session] {
    if (options->model_list == "all" || options->model_list.find(',') != std::string::npos)
      throw Error(
          "TB-USAGE", "fit makes one model, but several are named", "--model",
          fmt::format("compare them: tactbench compare {} --models {}", options->models.source, options->model_list));
    options->for_others = for_others(*verb);
    fit(*options, session);
  });
}

void add_compare(CLI::App& app, Session& session) {
  auto options = std::make_shared<FitOptions>();
  options->model_list = "all";
  options->models.verb = "compare";
  CLI::App* verb = app.add_subcommand("compare",
                                      "kinds of models side by side\n"
                                      "Each is fitted on a run or table, stored where it is a run, and scored on what "
                                      "was not fitted.");
  verb->add_option("source", options->models.source, "run number, or a table (see runs import)")->required();
  verb->add_option("--models", options->model_list,
                   fmt::format("some of {} with commas between, or all", fmt::join(analysis::model_names(), ", ")))
      ->capture_default_str();
  verb->add_option("--html", options->models.html, "write the comparison as a page");
  verb->add_option("--plot", options->models.plot, "draw the measured loop with the models: an SVG file");
  add_replace(*verb, session);
  add_void_too(*verb, session);
  add_all(*verb, session);
  add_table_options(*verb, options->models.table);
  add_identification(*verb, *options);
  for (const char* const name : {"--fit", "--score"}) verb->get_option(name)->group("Options");
  verb->callback([options, &session] {
    if (is_run_list(options->models.source))
      throw Error("TB-USAGE", "models are compared on one run, but several are named", "compare", "name one");
    fit(*options, session);
  });
}

std::string why_elam(const FitModelsOptions& options, const analysis::Histories& fitted) {
  if (!options.elam_reason.empty() || fitted.origin != "imported") return options.elam_reason;
  return fmt::format("{} is {}", fitted.source,
                     is_run_number(options.source) ? "imported" : "a table; --model dynamic takes one with time_s");
}

bool without_inner_branches(const analysis::SensorModel& dynamic) {
  return std::ranges::all_of(dynamic.taxels, [](const analysis::ModelTaxel& taxel) {
    return !taxel.fitted() || !taxel.fit.undetermined.empty();
  });
}

// Shares of the time: they only divide the time left.
std::vector<WorkStage> fit_stages(const std::vector<std::string>& models) {
  std::map<std::string, double> shares = {{analysis::kDynamicModel, 10.0}};
  for (const analysis::ModelKind& kind : analysis::model_kinds()) shares[kind.name] = kind.fit_share;
  const std::vector<std::string> either = {analysis::kDynamicModel, analysis::kElamFit};
  std::vector<WorkStage> stages = {{"reading the data", 1.0}};
  for (const std::string& model : models.empty() ? either : models)
    stages.push_back({model, shares.contains(model) ? shares.at(model) : 1.0});
  stages.push_back({kFiguresStage, 1.0, false});
  return stages;
}

bool is_run_list(const std::string& source) {
  return source.find_first_of("-,") != std::string::npos && !run_ranges(source).empty();
}

}  // namespace tactbench::bench
