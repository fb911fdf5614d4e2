#include "analysis/statistics/figures/evaluation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/identify/sensor_model.h"
#include "analysis/json_fields.h"
#include "analysis/statistics/figures/levels.h"

namespace tactbench::analysis {

namespace {

void gather_errors(Evaluation& e, const std::vector<TaxelErrors>& errors) {
  double sum = 0.0, observable = 0.0;
  std::int64_t frames = 0, observable_frames = 0;
  e.taxel_mean_error_psi.assign(errors.size(), kNan);
  for (std::size_t i = 0; i < errors.size(); ++i) {
    const TaxelErrors& own = errors[i];
    if (own.frames == 0) continue;
    e.taxel_mean_error_psi[i] = own.sum_psi / own.frames;
    if (e.worst_taxel < 0 || e.taxel_mean_error_psi[i] > e.worst_taxel_mean_error_psi) {
      e.worst_taxel = static_cast<int>(i);
      e.worst_taxel_mean_error_psi = e.taxel_mean_error_psi[i];
    }
    sum += own.sum_psi;
    frames += own.frames;
    observable += own.sum_observable_psi;
    observable_frames += own.observable;
    if (e.max_error_taxel < 0 || own.max_psi > e.max_error_psi) {
      e.max_error_taxel = static_cast<int>(i);
      e.max_error_psi = own.max_psi;
      e.max_error_at_psi = own.max_at_psi;
    }
    e.max_error_observable_psi = std::max(e.max_error_observable_psi, own.max_observable_psi);
  }
  e.mean_error_psi = sum / static_cast<double>(frames);
  e.mean_error_observable_psi = observable_frames > 0 ? observable / static_cast<double>(observable_frames) : kNan;
}

// The mean taxel along a sequence: the direct model is driven by the measured pressures, each branch from its measured
// turning point [A9], with the models of the fit.
Trace trace_of(const SequenceData& data, const CompensatedSequence& sequence, const ModelTaxel& model,
               const Fitted& fitted, std::size_t width) {
  Trace trace;
  trace.sequence = data.name;
  trace.pressure_psi = sequence.reference_psi;
  const std::size_t steps = sequence.reference_psi.size();
  for (std::size_t i = 0; i < steps; ++i) {
    std::vector<double> volts(width, 0.0);
    for (const Repeat& repeat : data.repeats)
      for (const std::size_t taxel : fitted.taxels())
        volts[taxel] += repeat.volts[i * width + taxel] / static_cast<double>(data.repeats.size());
    trace.measured_v.push_back(mean_of(fitted.row(volts, 0)));
    trace.compensated_psi.push_back(mean_of(fitted.row(sequence.unmoved_psi, i)));
  }
  const double start = trace.measured_v.front();
  trace.model_v =
      model.predicted({data.name, trace.pressure_psi, trace.measured_v, sequence.raw.branches, {}, {}}, false);
  trace.model_v.front() = start;
  return trace;
}

}  // namespace

Evaluation evaluate(const Dataset& measured, const SensorModel& fit, int threads) {
  check_same_sensor(measured, fit);
  const Dataset dataset = as_modelled(measured, fit);
  const Fitted fitted(fit);
  if (fitted.taxels().empty())
    throw AnalysisError("TB-ANALYSIS-NO-TAXEL", fmt::format("the fit of run {} has no fitted taxel", fit.run),
                        "fit another run");
  const CompensatedStreams streams = compensate_all(dataset, fit, threads);
  Evaluation e;
  e.run = dataset.run;
  e.model_run = fit.run;
  gather_levels(e, streams, fitted);
  gather_errors(e, streams.errors);
  for (std::size_t s = 0; s < dataset.sequences.size(); ++s) {
    const SequenceData& data = dataset.sequences[s];
    e.frames += static_cast<int>(data.repeats.size() * streams.sequences[s].reference_psi.size());
    e.traces.push_back(trace_of(data, streams.sequences[s], fit.mean_taxel(), fitted, fit.array().size()));
  }
  return e;
}

std::map<std::string, double> figures_of(const SensorModel& fit, const Evaluation& evaluation) {
  std::map<std::string, double> figures = {{"hysteresis_max_percent_fs", 100.0 * evaluation.hysteresis_max_fs},
                                           {"hysteresis_mean_percent_fs", 100.0 * evaluation.hysteresis_mean_fs},
                                           JSON_FIELDS(evaluation, mean_error_psi, max_error_psi),
                                           {"worst_taxel_error_psi", evaluation.worst_taxel_mean_error_psi},
                                           {"distance_of_mean_percent_fs", 100.0 * evaluation.comp_distance_of_mean},
                                           {"flat_percent", 100.0 * evaluation.flat_share},
                                           {"full_scale_v", evaluation.full_scale_v}};
  double noise_v = 0.0, zero_v = 0.0, fitted = 0.0;
  ElamParameters sum{0.0, 0.0, 0.0, 0.0, 0.0};
  for (const ModelTaxel& taxel : fit.array()) {
    noise_v = std::max(noise_v, taxel.noise);
    if (!taxel.fitted()) continue;
    zero_v += taxel.y0();
    fitted += 1.0;
    const ElamModel* const elam = elam_of(taxel);
    if (elam == nullptr) continue;
    const ElamParameters& own = elam->parameters;
    sum.alpha_d += own.alpha_d;
    sum.beta_d += own.beta_d;
    sum.alpha_a1 += own.alpha_a1;
    sum.alpha_a0 += own.alpha_a0;
    sum.beta_a += own.beta_a;
  }
  figures["noisiest_taxel_mv"] = 1000.0 * noise_v;
  figures["zero_mv"] = 1000.0 * zero_v / fitted;
  if (elam_of(fit.mean_taxel()) != nullptr) {
    figures["elam_alpha_d"] = sum.alpha_d / fitted;
    figures["elam_beta_d"] = sum.beta_d / fitted;
    figures["elam_alpha_a1_per_psi"] = sum.alpha_a1 / fitted;
    figures["elam_alpha_a0"] = sum.alpha_a0 / fitted;
    figures["elam_beta_a"] = sum.beta_a / fitted;
  }
  figures["unfit_taxels"] = static_cast<double>(fit.array().size()) - fitted;
  std::erase_if(figures, [](const auto& figure) { return !std::isfinite(figure.second); });
  return figures;
}

}  // namespace tactbench::analysis
