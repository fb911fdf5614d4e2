#include "analysis/statistics/figures/evaluation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/statistics/figures/levels.h"
#include "analysis/statistics/figures/same_sensor.h"
#include "analysis/statistics/figures/streams.h"

namespace tactbench::analysis {

void check_same_sensor(const Dataset& dataset, const SensorModel& fit) {
  if (dataset.rows != fit.rows || dataset.columns != fit.columns ||
      fit.array().size() != static_cast<std::size_t>(dataset.taxels()))
    throw AnalysisError("TB-ANALYSIS-OTHER-SENSOR",
                        fmt::format("run {} has {} x {} taxels, the models of run {} {} x {}", dataset.run,
                                    dataset.rows, dataset.columns, fit.run, fit.rows, fit.columns),
                        "use models of the same sensor");
  if (dataset.sensor_serial != fit.sensor_serial || dataset.scanner_serial != fit.scanner_serial)
    throw AnalysisError(
        "TB-ANALYSIS-OTHER-SENSOR",
        fmt::format("run {} is of sensor {} on scanner {}, the models of run {} are of {} on {}", dataset.run,
                    or_not_stated(dataset.sensor_serial), or_not_stated(dataset.scanner_serial), fit.run,
                    or_not_stated(fit.sensor_serial), or_not_stated(fit.scanner_serial)),
        "a model is bound to sensor and scanner: fit a run of this pair");
  if (dataset.origin != fit.origin)
    throw AnalysisError(
        "TB-ANALYSIS-ORIGIN",
        fmt::format("run {} is {}, the models of run {} are {}", dataset.run, dataset.origin, fit.run, fit.origin),
        "use models of the same origin as the run");
}

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
  if (fit.falling) {
    SensorModel rising = fit;
    rising.falling = false;
    return evaluate(as_modelled(measured, fit), rising, threads);
  }
  const Dataset& dataset = measured;
  const Fitted fitted(fit);
  if (fitted.taxels().empty())
    throw AnalysisError("TB-ANALYSIS-NO-TAXEL", fmt::format("the fit of run {} has no fitted taxel", fit.run),
                        "fit another run");
  const CompensatedStreams streams = compensate_all(dataset, fit, threads);
  Evaluation e;
  e.run = dataset.run;
  e.model_run = fit.run;
  e.excluded_taxels = dataset.taxels() - static_cast<int>(fitted.taxels().size());
  gather_levels(e, streams, fitted);
  gather_errors(e, streams.errors);
  for (std::size_t s = 0; s < dataset.sequences.size(); ++s) {
    const SequenceData& data = dataset.sequences[s];
    e.frames += static_cast<int>(data.repeats.size() * streams.sequences[s].reference_psi.size());
    e.traces.push_back(trace_of(data, streams.sequences[s], fit.mean_taxel(), fitted, fit.array().size()));
  }
  return e;
}

}  // namespace tactbench::analysis
