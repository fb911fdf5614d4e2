#include "bench/cli/models/fit_models.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "analysis/counted.h"
#include "analysis/identify/dynamic/dynamic_fit.h"
#include "analysis/identify/stored/model_document.h"
#include "analysis/json_fields.h"
#include "analysis/json_io.h"
#include "analysis/models/linearised.h"
#include "analysis/report/document/document.h"
#include "analysis/report/overview/overview_figures.h"
#include "analysis/report/page/page.h"
#include "bench/cli/judgement_output.h"
#include "bench/cli/models/fit.h"
#include "bench/cli/models/model_table.h"
#include "bench/cli/session.h"
#include "bench/common/build_info.h"
#include "bench/common/output_file.h"
#include "bench/common/work_progress.h"
#include "bench/config/config.h"
#include "bench/config/config_laboratory.h"
#include "bench/reporting/evaluation.h"
#include "bench/reporting/evidence.h"
#include "db/run_store.h"

namespace tactbench::bench {

namespace doc = analysis::doc;

namespace {

std::vector<std::string> not_fitted(const analysis::Histories& histories, const std::vector<std::string>& fitted) {
  std::vector<std::string> others;
  for (const std::string& name : histories.sequences)
    if (!fitted.empty() && std::ranges::find(fitted, name) == fitted.end()) others.push_back(name);
  return others;
}

// The threshold for turns, and the noise used for inputs.
std::string imported_table_text(const analysis::Histories& histories, const std::vector<std::string>& fitted) {
  const analysis::TaxelHistories& taxel = histories.taxels.back();
  std::size_t branches = 0;
  for (const analysis::History& history : analysis::named(taxel.fit, fitted)) branches += history.branches.size();
  return fmt::format("{}: a turn of the input is a step back by more than {:.4g}; noise of the output {:.3g}",
                     analysis::counted(branches, "branch", "branches"), taxel.turn, taxel.noise);
}

// Checks that scored data are named once and are not the data of the models.
void check_scored(const FitModelsOptions& options, const analysis::Histories& histories) {
  // 01 and 1 are one run.
  const auto plain = [](const std::string& name) {
    return is_run_number(name) ? std::to_string(std::stoll(name)) : name;
  };
  std::vector<std::string> named;
  for (const std::string& name : options.score) {
    const bool sequence = std::ranges::find(histories.sequences, name) != histories.sequences.end();
    if (std::ranges::find(named, sequence ? name : plain(name)) != named.end())
      throw Error("TB-RUN-TWICE", fmt::format("'{}' is named twice", name), "--score");
    named.push_back(sequence ? name : plain(name));
    if (!sequence && plain(name) == plain(options.source))
      throw Error("TB-RUN-OWN",
                  fmt::format("the models are made from {}, so it is not independent data for them", histories.source),
                  "--score", "name other runs or tables, or with --fit the sequences to fit, and score on the others");
  }
}

nlohmann::ordered_json mean_json(const analysis::ModelTaxel& taxel) {
  nlohmann::ordered_json json = {{"status", analysis::to_string(taxel.status)}};
  if (const analysis::ElamModel* const elam = analysis::elam_of(taxel)) {
    const analysis::ElamParameters& p = elam->parameters;
    json["alpha_d"] = p.alpha_d;
    json["beta_d"] = p.beta_d;
    json["alpha_a1_per_psi"] = p.alpha_a1;
    json["alpha_a0"] = p.alpha_a0;
    json["beta_a"] = p.beta_a;
  }
  const double fs = taxel.full_scale();
  json["j_v2"] = taxel.fit.j;
  json["mean_error_v"] = taxel.fit.mean_error;
  json["mean_error_fs"] = fs > 0.0 ? taxel.fit.mean_error / fs : 0.0;
  json["max_error_v"] = taxel.fit.max_error;
  json["full_scale_v"] = fs;
  json["at_bound"] = taxel.fit.at_bound;
  json["undetermined"] = taxel.fit.undetermined;
  if (const analysis::LinearisedModel* const model = analysis::linearised_of(taxel))
    json["c_per_v"] = model->divider().per_amplitude;
  return json;
}

nlohmann::ordered_json repeats_json(const std::vector<analysis::RepeatDrift>& repeats) {
  auto json = nlohmann::ordered_json::array();
  for (const analysis::RepeatDrift& repeat : repeats)
    json.push_back({{"sequence", repeat.sequence},
                    {"first_differs", repeat.differs},
                    JSON_FIELDS(repeat, shift_v, uncertainty_v, rms_v, others_rms_v)});
  return json;
}

nlohmann::ordered_json left_out_json(const std::vector<LeftOut>& left_out) {
  auto json = nlohmann::ordered_json::array();
  for (const LeftOut& own : left_out) json.push_back({JSON_FIELDS(own, taxel, row, column, status, why)});
  return json;
}

std::string left_out_lines(const std::vector<LeftOut>& left_out) {
  constexpr std::size_t kNamed = 12;
  std::string text;
  for (const LeftOut& own : std::span(left_out).first(std::min(left_out.size(), kNamed)))
    text += fmt::format("{}left out: row {}, column {} ({}{})", text.empty() ? "" : "\n", own.row, own.column,
                        own.status, own.why == own.status ? "" : ": " + own.why);
  if (left_out.size() > kNamed) text += fmt::format("\nleft out: {} more; --json lists all", left_out.size() - kNamed);
  return text;
}

std::string parameters_text(const analysis::ModelTaxel& mean) {
  if (const analysis::ElamModel* const elam = analysis::elam_of(mean)) {
    const analysis::ElamParameters& p = elam->parameters;
    return fmt::format("alpha_d {:.4f}, beta_d {:.4f}, alpha_a1 {:.5f} /psi, alpha_a0 {:.4f}, beta_a {:.4f}", p.alpha_d,
                       p.beta_d, p.alpha_a1, p.alpha_a0, p.beta_a);
  }
  return analysis::counted(mean.fit.model->parameters().size(), "parameter");
}

// The verdict first, then the model and its figures. `all`: every check, and the mean taxel's parameters.
doc::Document fitted_document(const FittedRun& fitted, analysis::PressureUnit unit, bool all) {
  const analysis::SensorModel& fit = *fitted.model;
  const bool judged = !fitted.judgement.figures.empty();
  doc::Document out;
  const auto add = [&](const std::string& text) {
    if (!text.empty()) out.add(doc::Paragraph{{text}});
  };
  if (judged) out.add(judgement_document(fitted.judgement, fit.origin, unit, all));
  const std::string label = analysis::label_of(fit);
  add(fmt::format("{} on run {}{}: {} of {} fitted, full scale {:.3f} V", label == analysis::kElamFit ? "ELAM" : label,
                  fit.run, fit.origin == "simulated" && !judged ? " (simulated)" : "", fit.fitted().size(),
                  analysis::counted(fit.array().size(), "taxel"), fit.full_scale_v()));
  add(left_out_lines(left_out_of(fit)));
  add(dynamics_text(fit));
  const analysis::ModelTaxel& mean = fit.mean_taxel();
  if (all && mean.fit.model != nullptr)
    add(fmt::format("mean taxel: {}; J {:.3f} V2, mean error {:.2f} % FS, max {:.2f} % FS", parameters_text(mean),
                    mean.fit.j, 100.0 * mean.fit.mean_error / mean.full_scale(),
                    100.0 * mean.fit.max_error / mean.full_scale()));
  if (all) add(linearised_text(fit));
  for (const analysis::RepeatDrift& repeat : fit.repeats)
    if (repeat.differs)
      add(fmt::format("first repeat of {} {:.0f} ± {:.0f} mV {}: not yet conditioned; add a cycle", repeat.sequence,
                      1e3 * std::abs(repeat.shift_v), 1e3 * repeat.uncertainty_v, repeat.shift_v < 0 ? "low" : "high"));
  out.add(figures_table(fitted.evaluations, fitted.judgement, unit));
  return out;
}

// A `fit` from its source to its output.
class Fit {
 public:
  Fit(const FitModelsOptions& options, Session& session) : options_(options), session_(session) {
    if (!options.output.empty() && options.models.size() > 1)
      throw Error("TB-USAGE", "--output writes one model, but several are named", "fit --output",
                  "name one with --model");
    // Before hours of computation.
    if (!options.output.empty()) check_output(options.output, kModelFile, session.replace);
    if (!options.html.empty()) check_output(options.html, kPageFile, session.replace);
    if (!options.plot.empty()) check_output(options.plot, kSvgFile, session.replace);
    if (!options.limits.empty()) (void)read_limits(find_config(options.limits));
    if (!options.lab.empty()) laboratory_ = read_laboratory(find_config(options.lab));
    if (!is_run_number(options.source)) return;
    (void)db::RunStore::open_read_only(session.db)
        .run(std::stoll(options.source));  // no store is made for a wrong name
    runs_.emplace(store_.emplace(db::RunStore::open(session.db)));
  }

  void run() {
    work();
    // An array may have unfit taxels, which a verdict judges.
    const auto of_table = [](const ModelRow& row) { return row.document.run == 0 && any_unfit(row.document); };
    if (std::ranges::any_of(rows_, of_table)) session_.code = ExitCode::kInconclusive;
    if (!options_.html.empty()) write_page();
    session_.json ? print_as_json() : print();
  }

  JudgedFit judged() {
    judging_ = true;
    work();
    FittedRun& fitted = fitted_.front();
    return {std::move(rows_.front().document), std::move(fitted.evaluations), std::move(fitted.judgement)};
  }

 private:
  void work() {
    WorkProgress progress("fit", session_.quiet || session_.json, fit_stages(options_.models));
    options_.table.timed = std::ranges::find(options_.models, analysis::kDynamicModel) != options_.models.end();
    histories_ = read(options_.source, options_.fit);
    // Figures and verdicts need a run of a bench with every taxel.
    on_bench_ = runs_ && histories_.origin != "imported" && !options_.mean_taxel;
    if (on_bench_) (void)named_runs(*runs_, options_.held_out, {"--held-out", histories_.run}, session_.void_too);
    check_scored(options_, histories_);
    find_targets();
    const bool named = !options_.models.empty();
    if (!named) options_.models = {analysis::kDynamicModel};
    if (const std::string why = named ? "" : why_elam(options_, histories_); !why.empty()) keep_to_elam(why);
    progress.begin(options_.models.front());
    if (options_.models.front() == analysis::kDynamicModel) fit_dynamic();
    if (!named && !rows_.empty() && without_inner_branches(rows_.front().document)) {
      keep_to_elam(fmt::format("{} has no inner branches", histories_.source));
      rows_.clear();
    }
    if (rows_.empty())
      rows_ = model_rows(options_.models, histories_, options_.fit, options_.identify, targets_, &refusals_,
                         [&](const std::string& model) { progress.begin(model); });
    progress.begin(kFiguresStage);
    for (const ModelRefusal& refusal : refusals_)
      tty::print(stderr, "warning: {} is left out: {}\n", refusal.model, refusal.why);
    for (ModelRow& row : rows_) {
      row.document.validity.mount = options_.mount;
      row.document.validity.interface_material = options_.interface_material;
      if (on_bench_ && !row.document.fitted().empty())
        row.document.repeats = analysis::repeat_drifts(runs_->dataset(histories_.run), row.document.fitted(), {});
    }
    in_table_ = !on_bench_ || options_.models.size() > 1 || !targets_.empty();
    // The dynamic model needs the times of a whole run, not parts of its branches.
    if (in_table_ && options_.models.front() != analysis::kDynamicModel)
      cross_validate(rows_, histories_, options_.fit);
    evaluate();
    keep();
  }

  // `fitted`: sequences of it that the models are made from; empty: all.
  analysis::Histories read(const std::string& source, const std::vector<std::string>& fitted) {
    analysis::Histories histories = is_run_number(source) && runs_
                                        ? read_run(*runs_, std::stoll(source), "fit", options_.table, session_, fitted)
                                        : read_source(source, options_.table, session_, fitted);
    return options_.mean_taxel ? analysis::mean_taxel_of(std::move(histories)) : histories;
  }

  // Other sources first, so that a wrong name is found before the fit.
  void find_targets() {
    others_.reserve(options_.score.size());
    std::vector<std::string> own;
    for (const std::string& name : options_.score) {
      if (std::ranges::find(histories_.sequences, name) != histories_.sequences.end()) {
        own.push_back(name);
        continue;
      }
      others_.push_back(read(name, {}));
      targets_.push_back({is_run_number(name) ? "run " + name : name, &others_.back(), {}});
    }
    if (options_.score.empty()) own = not_fitted(histories_, options_.fit);
    if (!own.empty())
      targets_.insert(targets_.begin(),
                      {fmt::format("{} of {}", fmt::join(own, ", "), histories_.source), &histories_, own});
  }

  void keep_to_elam(const std::string& why) {
    options_.models = {analysis::kElamFit};
    if (!session_.quiet && !session_.json) tty::print(stderr, "model: ELAM ({})\n", one_line(why));
  }

  void fit_dynamic() {
    analysis::SensorDynamics::Source rate, creep;
    if (!on_bench_) return keep_dynamic(analysis::fit_dynamic_table(histories_), rate, creep);
    for (const auto& [number, option, source] :
         {std::tuple(options_.rate_run, "--rate", &rate), std::tuple(options_.creep_run, "--creep", &creep)}) {
      if (number == 0) continue;
      const db::RunRecord run = named_runs(*runs_, {number}, {option}, session_.void_too).front();
      if (std::ranges::find(options_.held_out, number) != options_.held_out.end())
        throw Error("TB-RUN-OWN",
                    fmt::format("run {} is named by {}, so it is not independent data for the model", number, option),
                    "--held-out", "name runs from which the model is not made");
      *source = {number, run.content_sha256};
    }
    const analysis::Dataset& fitted = runs_->dataset(histories_.run);
    keep_dynamic(rate.run != 0 ? analysis::fit_dynamic(fitted, runs_->dataset(rate.run), runs_->dataset(creep.run))
                               : analysis::fit_dynamic_single_run(fitted),
                 rate, creep);
  }

  void keep_dynamic(analysis::SensorModel model, const analysis::SensorDynamics::Source& rate,
                    const analysis::SensorDynamics::Source& creep) {
    ModelRow& row = rows_.emplace_back();
    row.document = std::move(model);
    row.document.content_sha256 = histories_.content_sha256;
    row.document.program_version = build_info().version;
    row.document.dynamics->rate = rate;
    row.document.dynamics->creep = creep;
    row.label = analysis::label_of(row.document);
    for (const ScoreTarget& target : targets_)
      row.scores.push_back(analysis::score_model(row.document, *target.histories, target.sequences));
  }

  // Figures only for a single model, or on request.
  void evaluate() {
    if (!on_bench_ || (in_table_ && !judging_)) return;
    for (const ModelRow& row : rows_) {
      if (row.document.fitted().empty())
        throw analysis::AnalysisError("TB-ANALYSIS-NO-TAXEL", histories_.source + ": no taxel could be fitted",
                                      "check the frames: dead, stuck and saturated taxels are left out");
      fitted_.push_back({&row.document, evaluate_runs(*runs_, row.document, options_.held_out), {}});
    }
  }

  // Only after every held-out run was found to fit the models.
  void keep() {
    for (ModelRow& row : rows_)
      if (store_) row.document.fit = keep_fit(*store_, row.document);
    if (!options_.output.empty())
      write_output(options_.output, analysis::to_text(rows_.front().document), session_.replace);
    if (!options_.plot.empty()) {
      std::vector<const analysis::SensorModel*> models;
      for (const ModelRow& row : rows_) models.push_back(&row.document);
      write_output(options_.plot, svg_file(analysis::fitted_loop(histories_, models, session_.unit())),
                   session_.replace);
    }
    for (FittedRun& fitted : fitted_) {
      record_fit_trend(*store_, *fitted.model, fitted.evaluations.front().evaluation);
      if (options_.limits.empty()) continue;
      fitted.judgement = judge_and_store(*store_, *runs_, *fitted.model, fitted.evaluations, options_.limits,
                                         session_.void_too, laboratory_.instruments)
                             .judgement;
      session_.code = exit_code_of(fitted.judgement.overall);
    }
  }

  void print_as_json() {
    nlohmann::ordered_json json;
    if (in_table_) {
      auto models = nlohmann::ordered_json::array();
      for (const ModelRow& row : rows_) models.push_back(model_row_json(row, targets_));
      auto left_out = nlohmann::ordered_json::array();
      for (const ModelRefusal& refusal : refusals_) left_out.push_back({JSON_FIELDS(refusal, model, why)});
      json = {JSON_FIELDS(histories_, source, origin, input_unit, output_unit, falling),
              {"fitted", rows_.front().document.sequences},
              JSON_FIELDS(histories_, assumed, warnings),
              {"turn", histories_.taxels.back().turn},
              {"noise", histories_.taxels.back().noise},
              {"models", models},
              {"models_left_out", left_out}};
    } else {
      add_fitted_json(fitted_.front(), json);
    }
    if (on_bench_) json["outlying_samples"] = runs_->dataset(histories_.run).outlying;
    print_json(options_.verb, json);
  }

  void print() {
    if (on_bench_) report_outliers();
    doc::Document out = document();
    if (!store_ && options_.output.empty())
      out.add(doc::Paragraph{{"the model was not saved: -o FILE.json saves it; tactbench runs import ",
                              one_line(options_.source), " stores data and models"}});
    for (const std::string& file : {options_.plot, options_.html})
      if (!file.empty()) out.add(doc::Paragraph{{one_line(file)}});
    print_document(out, session_.unit());
  }

  doc::Document document() {
    doc::Document out;
    if (in_table_) add_tables(out);
    for (const FittedRun& fitted : fitted_) {
      if (const std::string open = undetermined_text(*fitted.model); !in_table_ && !open.empty())
        out.add(doc::Paragraph{{open.substr(0, open.size() - 1)}});
      out.add(fitted_document(fitted, session_.unit(), session_.all));
    }
    return out;
  }

  void write_page() {
    const nlohmann::ordered_json whose = {{"schema", "tactbench.compare"}, {"source", histories_.source}};
    const std::string json = analysis::printable_json(whose, 0);
    analysis::Page page{.document = "Comparison of models", .number = std::to_string(histories_.run)};
    page.title = one_line(histories_.source);
    page.state = "not a calibration report";
    page.simulated = histories_.origin == "simulated";
    page.body = to_html(document(), session_.page_unit());
    page.json = json;
    write_output(options_.html, page_of(page), session_.replace);
  }

  // For several models, or for data that are not a run of the bench.
  void add_tables(doc::Document& out) {
    const auto add = [&](const std::string& text) { out.add(doc::Paragraph{{text}}); };
    add(fmt::format("{} ({}): fitted on {}{}{}", one_line(histories_.source), histories_.origin,
                    fmt::join(rows_.front().document.sequences, ", "),
                    histories_.taxels.back().taxel == analysis::kMeanTaxel ? "; figures of the mean taxel" : "",
                    histories_.falling ? "; the output falls with the input and is negated" : ""));
    if (histories_.origin == "imported") add(imported_table_text(histories_, options_.fit));
    out.add(fits_document(rows_, session_.all));
    out.add(scores_document(rows_, targets_, histories_.input_unit.empty() ? "input units" : histories_.input_unit,
                            session_.unit(), session_.all));
    if (const std::string dynamics = dynamics_text(rows_.front().document); !on_bench_ && !dynamics.empty())
      add(dynamics);
    if (targets_.empty()) add("no data were held out: --fit SEQ,... or --score selects the data to score on");
  }

  void report_outliers() {
    std::vector<std::int64_t> numbers = options_.held_out;
    numbers.insert(numbers.begin(), histories_.run);
    for (const std::int64_t run : numbers)
      if (const int count = runs_->dataset(run).outlying; count > 0)
        tty::print("run {}: {} left out, because the other scans of the frame contradict them\n", run,
                   analysis::counted(count, "outlying sample"));
  }

  FitModelsOptions options_;
  Session& session_;
  analysis::Laboratory laboratory_;
  std::optional<db::RunStore> store_;
  std::optional<analysis::Runs> runs_;
  analysis::Histories histories_;
  bool on_bench_ = false, in_table_ = false, judging_ = false;
  std::vector<analysis::Histories> others_;
  std::vector<ScoreTarget> targets_;
  std::vector<ModelRow> rows_;
  std::vector<ModelRefusal> refusals_;
  std::vector<FittedRun> fitted_;
};

}  // namespace

void fit_models(const FitModelsOptions& options, Session& session) { Fit(options, session).run(); }

JudgedFit fit_and_judge(const FitModelsOptions& options, Session& session) { return Fit(options, session).judged(); }

std::vector<LeftOut> left_out_of(const analysis::SensorModel& fit) {
  std::vector<LeftOut> left_out;
  for (const analysis::ModelTaxel& taxel : fit.array()) {
    if (taxel.status == analysis::TaxelStatus::kFitted) continue;
    left_out.push_back({taxel.taxel, taxel.taxel / fit.columns, taxel.taxel % fit.columns,
                        analysis::to_string(taxel.status), taxel.why()});
  }
  return left_out;
}

std::string linearised_text(const analysis::SensorModel& fit) {
  double low = HUGE_VAL, high = 0.0;
  std::size_t on = 0, taxels = 0;
  const bool alone = fit.array().empty();  // the mean taxel
  for (const analysis::ModelTaxel& taxel : alone ? std::span(fit.taxels) : fit.array()) {
    const analysis::LinearisedModel* const model = analysis::linearised_of(taxel);
    if (model == nullptr) continue;
    ++taxels;
    const double c = model->divider().per_amplitude;
    if (c == 0.0) continue;
    ++on;
    low = std::min(low, c);
    high = std::max(high, c);
  }
  if (taxels == 0) return {};
  const std::string unit = fit.output_unit.empty() ? "" : " 1/" + fit.output_unit;
  return fmt::format("linearised output, u = v / (1 - c v): {} of {}{}", on, analysis::counted(taxels, "taxel"),
                     on > 0 ? fmt::format(", c {:.4f} to {:.4f}{}", low, high, unit) : std::string());
}

std::string dynamics_text(const analysis::SensorModel& fit) {
  if (!fit.dynamics) return {};
  const analysis::Dynamics& d = fit.dynamics->shared;
  const std::string creep =
      analysis::compensates_creep(*fit.dynamics)
          ? fmt::format("removed ({:.1f} % within {:.0f} s)",
                        100.0 * std::accumulate(d.creep_share.begin(), d.creep_share.end(), 0.0), d.creep_s.back())
          : "not compensated (needs a run of creep-levels)";
  return fmt::format("creep {}; lag {}", creep,
                     analysis::compensates_lag(*fit.dynamics)
                         ? fmt::format("removed ({:.1f} %, {:.2g} s)", 100.0 * d.lag_share, d.lag_s)
                         : "not compensated (needs a run of rate)");
}

void print_fitted(const FittedRun& fitted, const Session& session) {
  analysis::doc::Document out;
  if (session.quiet && !fitted.judgement.figures.empty())
    out.add(analysis::doc::Paragraph{{headline(fitted.judgement, fitted.model->origin, session.unit())}});
  else
    out = fitted_document(fitted, session.unit(), session.all);
  print_document(out, session.unit());
}

void add_fitted_json(const FittedRun& fitted, nlohmann::ordered_json& json) {
  const analysis::SensorModel& fit = *fitted.model;
  json["run"] = fit.run;
  json["model"] = analysis::label_of(fit);
  json["origin"] = fit.origin;
  json["taxels"] = fit.array().size();
  json["fitted_taxels"] = fit.fitted().size();
  json["left_out"] = left_out_json(left_out_of(fit));
  json["mean_taxel"] = mean_json(fit.mean_taxel());
  json["evaluations"] = nlohmann::ordered_json::array();
  for (const NamedEvaluation& named : fitted.evaluations) json["evaluations"].push_back(evaluation_json(named));
  json["repeats"] = repeats_json(fit.repeats);
  json["verdicts"] = verdicts_json(fitted.judgement.figures, fit.origin);
  if (!fitted.judgement.figures.empty()) json["judgement"] = judgement_json(fitted.judgement, fit.origin);
}

}  // namespace tactbench::bench
