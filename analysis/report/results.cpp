#include "analysis/report/results.h"

#include <algorithm>
#include <cmath>

#include "analysis/identify/compensators.h"
#include "analysis/statistics/figures/levels.h"

namespace tactbench::analysis {
namespace {

TaxelTrace trace_of_mean(const NamedTaxel& taxel, const Trace& trace) {
  return {taxel, trace.sequence, trace.pressure_psi, trace.measured_v, trace.model_v, trace.compensated_psi};
}

// All sequences of one taxel: the compensator's state carries over from repeat to repeat and sequence to sequence.
std::vector<TaxelTrace> traces_of_taxel(const Dataset& dataset, const SensorModel& model, const NamedTaxel& named) {
  const auto width = static_cast<std::size_t>(dataset.taxels()), taxel = static_cast<std::size_t>(named.taxel);
  const ModelTaxel& fit = model.taxels[taxel];
  std::vector<TaxelTrace> out;
  for (const SequenceData& sequence : dataset.sequences) {
    const std::vector<double> zeros(sequence.repeats.front().steps.size(), 0.0);
    out.push_back({named, sequence.name, zeros, zeros, {}, zeros});
  }
  const auto stream = compensator_of(model, fit);
  const auto volts = [&](const Repeat& repeat, std::size_t i) { return repeat.volts[i * width + taxel]; };
  stream_samples(dataset, *stream, volts, [&](std::size_t s, std::size_t r, std::size_t i, const Compensated& now) {
    const Repeat& repeat = dataset.sequences[s].repeats[r];
    const double weight = 1.0 / static_cast<double>(dataset.sequences[s].repeats.size());
    out[s].pressure_psi[i] += weight * repeat.steps[i].reference_psi;
    out[s].measured_v[i] += weight * volts(repeat, i);
    out[s].estimate_psi[i] += weight * now.pressure_psi;
  });
  for (std::size_t s = 0; s < out.size(); ++s) {
    std::vector<double> commanded;
    for (const Sample& step : dataset.sequences[s].repeats.front().steps) commanded.push_back(step.setpoint_psi);
    const History history{out[s].sequence, out[s].pressure_psi, out[s].measured_v, branches_along(commanded), {}, {}};
    out[s].model_v = fit.predicted(history, false);
  }
  return out;
}

StraightLine straight_line(const Dataset& dataset, const SensorModel& fit) {
  const Fitted fitted(fit);
  const ModelTaxel& mean = fit.mean_taxel();
  const double per_volt = (mean.xu() - mean.x0()) / (mean.yu() - mean.y0());
  StraightLine out;
  double sum = 0.0, samples = 0.0;
  std::vector<double> by_taxel(fitted.width(), 0.0);
  for (const SequenceData& sequence : dataset.sequences) {
    for (const Repeat& repeat : sequence.repeats) {
      for (std::size_t i = 0; i < repeat.steps.size(); ++i) {
        samples += 1.0;
        for (const std::size_t taxel : fitted.taxels()) {
          const double volts = repeat.volts[i * fitted.width() + taxel];
          const double off = std::abs(mean.x0() + (volts - mean.y0()) * per_volt - repeat.steps[i].reference_psi);
          by_taxel[taxel] += off;
          sum += off;
          out.max_error_psi = std::max(out.max_error_psi, off);
        }
      }
    }
  }
  out.mean_error_psi = sum / samples / static_cast<double>(fitted.taxels().size());
  out.worst_taxel_mean_error_psi = *std::ranges::max_element(by_taxel) / samples;
  return out;
}

// Omits models of taxels that this run omits, so that every column of a table has the same taxels.
SensorModel of_taxels_in_use(SensorModel previous, const SensorModel& fit) {
  for (std::size_t i = 0; i < std::min(previous.array().size(), fit.array().size()); ++i)
    if (!fit.taxels[i].fitted()) previous.taxels[i].status = fit.taxels[i].status;
  return previous;
}

}  // namespace

ReportResults results_of(const Dataset& measured, const SensorModel& fit, const Evaluation& evaluation,
                         const SensorModel* previous, const std::string& previous_name, int threads) {
  const Dataset dataset = as_modelled(measured, fit);
  const ChosenTaxels chosen = choose_taxels(evaluation);
  ReportResults out;
  out.models = compare_models(measured, fit, chosen, threads);
  for (const NamedTaxel& named : named_taxels(chosen, fit.columns)) {
    if (named.taxel == kMeanTaxel) {
      for (const Trace& trace : evaluation.traces) out.traces.push_back(trace_of_mean(named, trace));
      continue;
    }
    for (TaxelTrace& trace : traces_of_taxel(dataset, fit, named)) out.traces.push_back(std::move(trace));
  }
  out.straight = straight_line(dataset, fit);
  out.usable = usable_range(fit);
  if (previous != nullptr) {
    const SensorModel in_use = of_taxels_in_use(*previous, fit);
    const Fitted fitted(in_use);
    out.previous =
        AsFound{previous_name, evaluate(measured, in_use, threads), static_cast<int>(fitted.taxels().size()), {}, {}};
  }
  return out;
}

void forget_run_numbers(ReportResults& results) {
  Studies& studies = results.studies;
  std::ranges::fill(studies.uniformity.runs, 0);
  std::ranges::fill(studies.remount.runs, 0);
  studies.crosstalk.run = 0;
  for (RateHoldRun& run : studies.rate_hold.runs) run.run = 0;
  for (ContactResult& contact : results.contacts) contact.run = contact.mount_run = 0;
  if (results.previous) results.previous->model.clear();
}

}  // namespace tactbench::analysis
