#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "analysis/counted.h"
#include "analysis/models/elam_pieces.h"
#include "bench/cli/judgement_words.h"
#include "bench/cli/models/fit_models.h"
#include "bench/cli/session.h"
#include "bench/config/config.h"
#include "bench/config/config_laboratory.h"
#include "bench/reporting/evaluation.h"
#include "bench/reporting/named_runs.h"
#include "db/run_store.h"

namespace tactbench::bench {

namespace {

struct FitOptions {
  std::int64_t run = 0;
  std::vector<std::int64_t> held_out;
  std::string limits, lab;
  FitModelsOptions models;
  std::string model_list = "elam", fit_list, score_list, mode = "paper", way = "exact", check;
};

nlohmann::ordered_json fit_json(const analysis::TaxelFit& taxel) {
  const analysis::ElamParameters& p = taxel.fit.model.parameters;
  const double fs = taxel.fit.full_scale_v;
  return {{"status", analysis::to_string(taxel.status)},
          {"alpha_d", p.alpha_d},
          {"beta_d", p.beta_d},
          {"alpha_a1_per_psi", p.alpha_a1},
          {"alpha_a0", p.alpha_a0},
          {"beta_a", p.beta_a},
          {"j_v2", taxel.fit.j_v2},
          {"mean_error_v", taxel.fit.mean_error_v},
          {"mean_error_fs", fs > 0.0 ? taxel.fit.mean_error_v / fs : 0.0},
          {"max_error_v", taxel.fit.max_error_v},
          {"full_scale_v", fs},
          {"at_bound", taxel.fit.at_bound}};
}

nlohmann::ordered_json repeats_json(const std::vector<analysis::RepeatDrift>& repeats) {
  auto json = nlohmann::ordered_json::array();
  for (const analysis::RepeatDrift& repeat : repeats)
    json.push_back({{"sequence", repeat.sequence},
                    {"first_differs", repeat.differs},
                    {"shift_v", repeat.shift_v},
                    {"uncertainty_v", repeat.uncertainty_v},
                    {"rms_v", repeat.rms_v},
                    {"others_rms_v", repeat.others_rms_v}});
  return json;
}

void fit(const FitOptions& options, Session& session) {
  if (!options.limits.empty()) (void)read_limits(find_config(options.limits));  // before an hour of anything
  analysis::Laboratory laboratory;
  if (!options.lab.empty()) laboratory = read_laboratory(find_config(options.lab));
  db::RunStore store = db::RunStore::open(session.db);
  analysis::Runs runs(store);
  (void)named_runs(runs, {options.run}, {"fit"}, session.void_too);
  (void)named_runs(runs, options.held_out, {"--held-out", options.run}, session.void_too);
  const analysis::ArrayFit fitted = analysis::fit_array(runs.dataset(options.run));
  const std::vector<NamedEvaluation> evaluations = evaluate_runs(runs, fitted, options.held_out);
  keep_fit(store, fitted);  // not before every held-out run was found to go with it
  (void)follow_sensor(store, runs.record(options.run), fitted, evaluations.front().evaluation);
  Judgement judgement;
  if (!options.limits.empty()) {
    judgement =
        judge_and_store(store, runs, fitted, evaluations, options.limits, session.void_too, laboratory.instruments);
    session.code = exit_code_of(judgement);
    warn_of_conditional(judgement.verdicts);
  }
  const std::vector<db::VerdictRecord>& verdicts = judgement.verdicts;
  const std::string origin = runs.record(options.run).origin;
  const auto count = std::count_if(fitted.taxels.begin(), fitted.taxels.end(),
                                   [](const auto& t) { return t.status == analysis::TaxelStatus::kFitted; });
  if (session.json) {
    nlohmann::ordered_json json = {{"run", options.run},     {"model", "elam"},
                                   {"origin", origin},       {"taxels", fitted.taxels.size()},
                                   {"fitted_taxels", count}, {"mean_taxel", fit_json(fitted.mean_taxel)}};
    json["evaluations"] = nlohmann::ordered_json::array();
    for (const NamedEvaluation& named : evaluations) json["evaluations"].push_back(evaluation_json(named));
    json["repeats"] = repeats_json(fitted.repeats);
    json["verdicts"] = verdicts_json(verdicts, origin);
    if (!verdicts.empty()) json["judgement"] = judgement_json(judgement, origin);
    print_json("fit", json);
    return;
  }
  const analysis::ElamFit& mean = fitted.mean_taxel.fit;
  const analysis::ElamParameters& p = mean.model.parameters;
  tty::print("ELAM on run {} ({}): {} of {} fitted, full scale {:.3f} V\n", options.run, origin, count,
             analysis::counted(fitted.taxels.size(), "taxel"), fitted.full_scale_v);
  tty::print(
      "mean taxel: alpha_d {:.4f}, beta_d {:.4f}, alpha_a1 {:.5f} /psi, alpha_a0 {:.4f}, beta_a {:.4f}; J {:.3f} V2, "
      "mean error {:.2f} % FS, max {:.2f} % FS\n\n",
      p.alpha_d, p.beta_d, p.alpha_a1, p.alpha_a0, p.beta_a, mean.j_v2, 100.0 * mean.mean_error_v / mean.full_scale_v,
      100.0 * mean.max_error_v / mean.full_scale_v);
  for (const analysis::RepeatDrift& repeat : fitted.repeats) {
    if (!repeat.differs) continue;
    tty::print("the first repeat of {} differs from the others by {:.2f} +- {:.2f} mV ({:.2f} mV rms, others {:.2f})\n",
               repeat.sequence, 1e3 * repeat.shift_v, 1e3 * repeat.uncertainty_v, 1e3 * repeat.rms_v,
               1e3 * repeat.others_rms_v);
  }
  tty::print("{}", figures_table(evaluations));
  if (!verdicts.empty()) tty::print("\n{}{}", verdict_table(verdicts, origin), judgement_text(judgement, origin));
}

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

// ELAM in the paper's mode on all sequences of a run: every taxel, its figures, verdicts. All else is a comparison.
void fit_any(FitOptions options, Session& session) {
  options.models.models = models_of(options.model_list);
  options.models.fit = split_list(options.fit_list);
  options.models.score = split_list(options.score_list);
  options.models.identify.free_run = options.mode == "free-run";
  options.models.identify.genetic = options.way == "ga";
  if (!options.check.empty()) {
    check_model(options.check, options.models, session);
    return;
  }
  const analysis::IdentifyOptions& identify = options.models.identify;
  const bool plain = names_run(options.models.source) && options.model_list == "elam" && options.fit_list.empty() &&
                     options.score_list.empty() && options.models.output.empty() && options.models.mount.empty() &&
                     options.models.interface_material.empty() && !options.models.mean_taxel && !identify.free_run &&
                     !identify.genetic && !identify.memory && !identify.exact_outer && identify.splits == 1;
  if (plain) {
    options.run = std::stoll(options.models.source);
    if (db::RunStore::open_read_only(session.db).run(options.run).origin != "imported") {
      fit(options, session);
      return;
    }
  }
  if (!options.limits.empty() || !options.held_out.empty())
    throw Error(ExitCode::kUsage, "TB-USAGE", "--limits and --held-out judge the plain ELAM fit of a run", "fit",
                "leave them out, or fit the run without --model, --fit, --score and --mode");
  fit_models(options.models, session);
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
  verb->add_option("--check", options->check,
                   "fit nothing: say whether this MODEL is still good on the source, or wants a new zero, gain or fit");
  add_table_options(*verb, options->models.table);
  verb->add_option("--held-out", options->held_out, "score these runs of the same sensor with the models, too")
      ->take_all();
  CLI::Option* limits = verb->add_option(
      "--limits", options->limits,
      "limits file: judge every held-out run and store the verdicts; the worst one counts. Without a held-out run "
      "nothing is judged: the run that the models come from is no evidence");
  verb->add_option(
          "--lab", options->lab,
          "laboratory file: a reference that is overdue by its dates makes verdicts inconclusive, as in a report")
      ->needs(limits);
  add_void_too(*verb, session);
  add_common(*verb, session);
  verb->callback([options, &session] { fit_any(*options, session); });
}

}  // namespace tactbench::bench
