#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "bench/cli/evaluation.h"

namespace tactbench::bench {

namespace {

struct Options {
  std::int64_t run = 0;
  std::vector<std::int64_t> held_out;
  std::string limits;
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

void fit(const Options& options, Session& session) {
  if (!options.limits.empty()) (void)read_limits(find_config(options.limits));  // before an hour of anything
  db::RunStore store = db::RunStore::open(session.db);
  const analysis::ArrayFit fitted = fit_run(store, options.run);
  const std::vector<NamedEvaluation> evaluations = evaluate_runs(store, fitted, options.held_out);
  std::vector<db::VerdictRecord> verdicts;
  if (!options.limits.empty()) {
    verdicts = judge_and_store(store, fitted, judged(evaluations), options.limits);
    session.code = exit_code_of(verdicts);
  }
  const std::string origin = store.run(options.run).origin;
  const auto count = std::count_if(fitted.taxels.begin(), fitted.taxels.end(),
                                   [](const auto& t) { return t.status == analysis::TaxelStatus::kFitted; });
  if (session.json) {
    nlohmann::ordered_json json = {{"run", options.run},     {"model", "elam"},
                                   {"origin", origin},       {"taxels", fitted.taxels.size()},
                                   {"fitted_taxels", count}, {"mean_taxel", fit_json(fitted.mean_taxel)}};
    json["evaluations"] = nlohmann::ordered_json::array();
    for (const NamedEvaluation& named : evaluations) json["evaluations"].push_back(evaluation_json(named));
    json["verdicts"] = verdicts_json(verdicts, origin);
    print_json("fit", json);
    return;
  }
  const analysis::ElamFit& mean = fitted.mean_taxel.fit;
  const analysis::ElamParameters& p = mean.model.parameters;
  fmt::print("ELAM on run {} ({}): {} of {} taxels fitted, full scale {:.3f} V\n", options.run, origin, count,
             fitted.taxels.size(), fitted.full_scale_v);
  fmt::print(
      "mean taxel: alpha_d {:.4f}, beta_d {:.4f}, alpha_a1 {:.5f} /psi, alpha_a0 {:.4f}, beta_a {:.4f}; J {:.3f} V2, "
      "mean error {:.2f} % FS, max {:.2f} % FS\n\n",
      p.alpha_d, p.beta_d, p.alpha_a1, p.alpha_a0, p.beta_a, mean.j_v2, 100.0 * mean.mean_error_v / mean.full_scale_v,
      100.0 * mean.max_error_v / mean.full_scale_v);
  fmt::print("{}", figures_table(evaluations));
  if (!verdicts.empty()) fmt::print("\n{}", verdict_table(verdicts, origin));
}

struct ReportOptions {
  std::int64_t run = 0;
  std::vector<std::int64_t> held_out;
  std::string limits, output;
};

void report(const ReportOptions& options, Session& session) {
  const db::RunStore store = db::RunStore::open_read_only(session.db);
  const analysis::ArrayFit fitted = analysis::load_fit(store, options.run);
  const std::vector<NamedEvaluation> evaluations = evaluate_runs(store, fitted, options.held_out);
  const std::string origin = store.run(options.run).origin;
  // --limits judges anew without storing (contract.md, "Words on the command line").
  const analysis::Evaluation& evaluation = judged(evaluations);
  const std::vector<db::VerdictRecord> verdicts =
      options.limits.empty() ? store.verdicts(evaluation.run)
                             : analysis::judge(evaluation, fitted, read_limits(find_config(options.limits)));
  std::string number;
  const std::string path = write_report(store, fitted, evaluations, verdicts, options.output, &number);
  session.code = exit_code_of(verdicts);
  if (session.json) {
    print_json("report", {{"run", options.run},
                          {"number", number},
                          {"path", path},
                          {"origin", origin},
                          {"verdicts", verdicts_json(verdicts, origin)}});
    return;
  }
  if (!verdicts.empty()) fmt::print("{}\n", verdict_table(verdicts, origin));
  fmt::print("report {}: {}\n", number, path);
}

}  // namespace

void add_fit(CLI::App& app, Session& session) {
  auto options = std::make_shared<Options>();
  CLI::App* verb =
      app.add_subcommand("fit", "identify ELAM for every taxel of a run, compensate its frames, judge, store");
  verb->add_option("run", options->run, "run number")->required();
  verb->add_option("--held-out", options->held_out, "score these runs of the same sensor with the models, too")
      ->take_all();
  verb->add_option("--limits", options->limits,
                   "limits file: judge the first held-out run (without one, the run itself) and store the verdicts");
  add_common(*verb, session);
  verb->callback([options, &session] { fit(*options, session); });
}

void add_report(CLI::App& app, Session& session) {
  auto options = std::make_shared<ReportOptions>();
  CLI::App* verb = app.add_subcommand("report", "write the calibration report of a fitted run as one HTML file");
  verb->add_option("run", options->run, "run number")->required();
  verb->add_option("--held-out", options->held_out, "runs of the same sensor to show compensated with the models")
      ->take_all();
  verb->add_option("--limits", options->limits, "judge anew by this limits file, without storing");
  verb->add_option("-o,--output", options->output, "file to write (default: reports/run-N.html beside the store)");
  add_common(*verb, session);
  verb->callback([options, &session] { report(*options, session); });
}

}  // namespace tactbench::bench
