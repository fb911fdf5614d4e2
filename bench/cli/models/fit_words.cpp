#include "bench/cli/models/fit_words.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "analysis/counted.h"
#include "analysis/identify/dynamic/dynamic_alone.h"
#include "analysis/identify/stored/model_document.h"
#include "analysis/models/linearised.h"
#include "bench/cli/judgement_words.h"
#include "bench/cli/session.h"

namespace tactbench::bench {

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
                    {"shift_v", repeat.shift_v},
                    {"uncertainty_v", repeat.uncertainty_v},
                    {"rms_v", repeat.rms_v},
                    {"others_rms_v", repeat.others_rms_v}});
  return json;
}

nlohmann::ordered_json left_out_json(const std::vector<LeftOut>& left_out) {
  auto json = nlohmann::ordered_json::array();
  for (const LeftOut& own : left_out)
    json.push_back(
        {{"taxel", own.taxel}, {"row", own.row}, {"column", own.column}, {"status", own.status}, {"why", own.why}});
  return json;
}

std::string left_out_text(const std::vector<LeftOut>& left_out) {
  constexpr std::size_t kNamed = 12;
  std::string text;
  for (const LeftOut& own : std::span(left_out).first(std::min(left_out.size(), kNamed)))
    text += fmt::format("left out: row {}, column {} ({}{})\n", own.row, own.column, own.status,
                        own.why == own.status ? "" : ": " + own.why);
  if (left_out.size() > kNamed) text += fmt::format("left out: {} more; --json lists all\n", left_out.size() - kNamed);
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

std::string dynamics_text(const analysis::SensorModel& fit, analysis::PressureUnit unit) {
  if (!fit.dynamics) return {};
  const bool one_run = fit.dynamics->rate.run == 0 && fit.dynamics->creep.run == 0;
  if (one_run && !analysis::in_time(*fit.dynamics) && fit.run == 0)
    return "lag and creep are left in: the table tells of none that explain a good part of the errors";
  if (one_run && !analysis::in_time(*fit.dynamics))
    return "lag and creep are left in: no runs of them were named, and the fitted one tells no creep";
  const analysis::Dynamics& d = fit.dynamics->shared;
  std::vector<std::string> elements;
  for (std::size_t j = 0; j < analysis::kCreepElements; ++j)
    elements.push_back(fmt::format("{:.2f} % in {:.3g} s", 100.0 * d.creep_share[j], d.creep_s[j]));
  const std::string lag = fmt::format("lag {:.1f} % in {:.2g} s", 100.0 * d.lag_share, d.lag_s);
  const std::string half =
      fit.input_unit == "psi" ? unit.text(d.creep_half, 1) : fmt::format("{:.3g} {}", d.creep_half, fit.input_unit);
  const auto source = [](std::int64_t run) {
    return run == 0 ? std::string("the fitted run") : fmt::format("run {}", run);
  };
  if (one_run && fit.run == 0)
    return fmt::format("creep {}, half of it at {}; {} (from the fitted table)", fmt::join(elements, ", "), half, lag);
  const std::int64_t rate = fit.dynamics->rate.run, creep = fit.dynamics->creep.run;
  const bool own = analysis::creep_of_fitted_run(*fit.dynamics);
  return fmt::format(
      "creep {}, half of it at {} (from {}{}); {}", fmt::join(elements, ", "), half, source(own ? 0 : creep),
      own && creep != 0 ? ", by taxel from " + source(creep) : "",
      !analysis::undoes_lag(*fit.dynamics) ? "lag is left in" : fmt::format("{} (from {})", lag, source(rate)));
}

std::string fitted_text(const FittedRun& fitted, analysis::PressureUnit unit) {
  const analysis::SensorModel& fit = *fitted.model;
  const std::string label = analysis::label_of(fit);
  std::string text = fmt::format("{} on run {} ({}): {} of {} fitted, full scale {:.3f} V\n",
                                 label == analysis::kElamFit ? "ELAM" : label, fit.run, fit.origin, fit.fitted().size(),
                                 analysis::counted(fit.array().size(), "taxel"), fit.full_scale_v());
  text += left_out_text(left_out_of(fit));
  const analysis::ModelTaxel& mean = fit.mean_taxel();
  if (mean.fit.model != nullptr)
    text += fmt::format("mean taxel: {}; J {:.3f} V2, mean error {:.2f} % FS, max {:.2f} % FS\n", parameters_text(mean),
                        mean.fit.j, 100.0 * mean.fit.mean_error / mean.full_scale(),
                        100.0 * mean.fit.max_error / mean.full_scale());
  for (const std::string& line : {linearised_text(fit), dynamics_text(fit, unit)})
    if (!line.empty()) text += line + "\n";
  text += "\n";
  for (const analysis::RepeatDrift& repeat : fit.repeats) {
    if (!repeat.differs) continue;
    text += fmt::format(
        "the first repeat of {} differs from the others by {:.2f} +- {:.2f} mV ({:.2f} mV rms, others {:.2f})\n",
        repeat.sequence, 1e3 * repeat.shift_v, 1e3 * repeat.uncertainty_v, 1e3 * repeat.rms_v,
        1e3 * repeat.others_rms_v);
  }
  text += figures_table(fitted.evaluations, unit);
  const std::vector<analysis::JudgedFigure>& figures = fitted.judgement.figures;
  if (!figures.empty())
    text += fmt::format("\n{}{}", verdict_table(figures, fit.origin, unit),
                        judgement_text(fitted.judgement, fit.origin, unit));
  return text;
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
