#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "bench/cli/evaluation.h"

namespace tactbench::bench {

namespace {

struct ReportOptions {
  std::int64_t run = 0;
  std::vector<std::int64_t> held_out;
  std::string limits, output;
};

void report_run(const ReportOptions& options, Session& session) {
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

void add_report(CLI::App& app, Session& session) {
  auto options = std::make_shared<ReportOptions>();
  CLI::App* verb = app.add_subcommand("report", "write the calibration report of a fitted run as one HTML file");
  verb->add_option("run", options->run, "run number")->required();
  verb->add_option("--held-out", options->held_out, "runs of the same sensor to show compensated with the models")
      ->take_all();
  verb->add_option("--limits", options->limits, "judge anew by this limits file, without storing");
  verb->add_option("-o,--output", options->output, "file to write (default: reports/run-N.html beside the store)");
  add_common(*verb, session);
  verb->callback([options, &session] { report_run(*options, session); });
}

}  // namespace tactbench::bench
