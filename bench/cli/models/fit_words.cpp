#include "bench/cli/models/fit_words.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include "analysis/counted.h"
#include "analysis/identify/dynamic/dynamic_alone.h"
#include "analysis/identify/stored/model_document.h"
#include "analysis/json_fields.h"
#include "analysis/models/linearised.h"
#include "bench/cli/judgement_words.h"
#include "bench/cli/session.h"

namespace tactbench::bench {

namespace doc = analysis::doc;

namespace {

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

std::string left_out_text(const std::vector<LeftOut>& left_out) {
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

}  // namespace

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
      analysis::undoes_creep(*fit.dynamics)
          ? fmt::format("removed ({:.1f} % within {:.0f} s)",
                        100.0 * std::accumulate(d.creep_share.begin(), d.creep_share.end(), 0.0), d.creep_s.back())
          : "left in (needs a run of creep-levels)";
  return fmt::format("creep {}; lag {}", creep,
                     analysis::undoes_lag(*fit.dynamics)
                         ? fmt::format("removed ({:.1f} %, {:.2g} s)", 100.0 * d.lag_share, d.lag_s)
                         : "left in (needs a run of rate)");
}

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
  add(left_out_text(left_out_of(fit)));
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
