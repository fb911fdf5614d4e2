// judge: a stored model on further runs of its sensor.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "analysis/identify/stored/model_document.h"
#include "bench/cli/judgement_output.h"
#include "bench/cli/models/fit_models.h"
#include "bench/cli/reports/report.h"
#include "bench/cli/runs/source.h"
#include "bench/common/work_progress.h"
#include "bench/config/config.h"
#include "bench/config/config_laboratory.h"
#include "bench/reporting/evaluation.h"
#include "bench/reporting/evidence.h"
#include "db/run_store.h"

namespace tactbench::bench {

namespace {

struct JudgeOptions {
  std::string model, limits, lab;
  std::vector<std::int64_t> runs;
  bool store = true;
};

void judge(const JudgeOptions& options, Session& session) {
  if (!options.limits.empty()) (void)read_limits(find_config(options.limits));  // before hours of computation
  const analysis::Laboratory laboratory =
      options.lab.empty() ? analysis::Laboratory() : read_laboratory(find_config(options.lab));
  const ModelReference named = parse_model_reference(options.model, 0);
  (void)db::RunStore::open_read_only(session.db).run(named.run);  // no store is made for a wrong name
  db::RunStore store = db::RunStore::open(session.db);
  analysis::Runs runs(store);
  const analysis::SensorModel model = load_model(options.model, session);
  check_models_of_array(runs, model, named);
  (void)named_runs(runs, options.runs, {"judge", named.run}, session.void_too);
  check_independent_of_dynamics(store, model, options.runs);
  WorkProgress progress("judge", session.quiet || session.json, {{"figures", 1.0}});
  progress.begin("figures");
  FittedRun fitted{&model, evaluate_runs(runs, model, options.runs), {}};
  if (!options.limits.empty()) {
    fitted.judgement = options.store ? judge_and_store(store, runs, model, fitted.evaluations, options.limits,
                                                       session.void_too, laboratory.instruments)
                                           .judgement
                                     : judge_for_report(runs, model, fitted.evaluations, options.limits,
                                                        session.void_too, laboratory.instruments, {})
                                           .judgement;
    session.code = exit_code_of(fitted.judgement.overall);
  }
  if (!session.json) {
    print_fitted(fitted, session);
    if (!options.store) tty::print("not stored (--try)\n");
    return;
  }
  nlohmann::ordered_json json;
  add_fitted_json(fitted, json);
  print_json("judge", json);
}

}  // namespace

void add_judge(CLI::App& app, Session& session) {
  auto options = std::make_shared<JudgeOptions>();
  CLI::App* verb =
      app.add_subcommand("judge",
                         "judge a model on further runs by limits; stores the verdict\n"
                         "With several runs the worst verdict counts. Without limits only errors are shown. "
                         "The run from which a model was made is not evidence.");
  verb->add_option("model", options->model, "RUN whose model is judged, or RUN:FIT")->required();
  verb->add_option("runs", options->runs, "runs of the same sensor from which the model was not made")
      ->required()
      ->take_all();
  session.profile.add(*verb, "--limits", ProfileKey::kLimits, options->limits, "limits file to judge by");
  session.profile.add(*verb, "--lab", ProfileKey::kLab, options->lab,
                      "laboratory file: if its dates show that the reference is overdue, verdicts are inconclusive");
  verb->add_flag("!--try", options->store, "store nothing: only show the verdict by these limits");
  add_void_too(*verb, session);
  add_all(*verb, session);
  verb->callback([options, verb, &session] {
    const auto given = session.profile.values().find(ProfileKey::kLimits);
    if (verb->count("--limits") == 0 && given != session.profile.values().end() && !session.quiet && !session.json)
      tty::print(stderr, "judged by {} ({})\n", one_line(options->limits), given->second.origin);
    judge(*options, session);
  });
}

}  // namespace tactbench::bench
