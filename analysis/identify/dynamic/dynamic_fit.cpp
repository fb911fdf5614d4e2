#include "analysis/identify/dynamic/dynamic_fit.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "analysis/compensate/dynamic_compensator.h"
#include "analysis/compensate/everett.h"
#include "analysis/identify/congruency.h"
#include "analysis/identify/dynamic/track.h"
#include "analysis/identify/histories.h"
#include "analysis/identify/identifier.h"
#include "analysis/models/preisach.h"
#include "analysis/workers.h"

namespace tactbench::analysis {
namespace {

// The mean output at the lowest set-point.
std::vector<double> zeros_of(const Dataset& data) {
  const auto width = static_cast<std::size_t>(data.taxels());
  double lowest = HUGE_VAL, count = 0.0;
  for (const SequenceData& sequence : data.sequences)
    for (const Repeat& repeat : sequence.repeats)
      for (const Sample& sample : repeat.steps) lowest = std::min(lowest, sample.setpoint_psi);
  std::vector<double> zeros(width, 0.0);
  for (const SequenceData& sequence : data.sequences)
    for (const Repeat& repeat : sequence.repeats)
      for (std::size_t i = 0; i < repeat.steps.size(); ++i) {
        if (repeat.steps[i].setpoint_psi > lowest) continue;
        count += 1.0;
        for (std::size_t t = 0; t < width; ++t) zeros[t] += repeat.volts[i * width + t];
      }
  for (double& zero : zeros) zero /= count;
  return zeros;
}

// Outputs with the creep undone at the pressures that have arrived.
Dataset undone(Dataset data, const ArrayDynamics& dynamics, const std::vector<double>& zero_v, double lowest,
               double span) {
  const auto width = static_cast<std::size_t>(data.taxels());
  const Dynamics& d = dynamics.shared;
  DynamicsState state;
  double before = -1.0;
  for (SequenceData& sequence : data.sequences)
    for (Repeat& repeat : sequence.repeats)
      for (std::size_t i = 0; i < repeat.steps.size(); ++i) {
        Sample& sample = repeat.steps[i];
        const DynamicsStep step = next_step(d, state, sample, before, span);
        const double pressure = sample.reference_psi - lowest;
        for (std::size_t t = 0; t < width; ++t) {
          double& v = repeat.volts[i * width + t];
          v = zero_v[t] + (v - zero_v[t]) / creep_factor(d, state, step, pressure, dynamics.creep_scale[t]);
        }
        sample.reference_psi = lowest + arrived(d.lag_share, state, step, pressure);
        advance(d, state, step, pressure);
        before = sample.time_s;
      }
  return data;
}

std::vector<double> everett_of(const PreisachModel& model, std::size_t n) {
  std::vector<double> table;
  const double step = (model.x_high() - model.x_low()) / static_cast<double>(n);
  const auto at = [&](std::size_t i) { return model.x_low() + step * static_cast<double>(i); };
  for (std::size_t i = 0; i <= n; ++i)
    for (std::size_t j = 0; j <= i; ++j) table.push_back(model.everett(at(i), at(j)));
  return table;
}

// What the stream leaves of the fitted data: one shape over levels and directions, a scale a taxel.
void find_residuals(const Dataset& data, int threads, DynamicSetup& setup) {
  const std::size_t width = setup.taxels.size(), n = setup.intervals;
  struct Sums {
    std::vector<double> squares, count;
  };
  std::vector<Sums> sums(width);
  const Sample& begin = data.sequences.front().repeats.front().steps.front();
  setup.worked_s = std::max(0.0, begin.time_s - begin.held_s);
  for_each_index(width, threads, [&](std::size_t t) {
    if (!setup.taxels[t].usable) return;
    sums[t] = {std::vector<double>(2 * n, 0.0), std::vector<double>(2 * n, 0.0)};
    DynamicTaxelCompensator compensator(setup, t);
    double before = -1.0;
    for (const SequenceData& sequence : data.sequences)
      for (std::size_t i = 0; i < sequence.repeats.front().steps.size(); ++i) {
        const Sample& sample = sequence.repeats.front().steps[i];
        const double seconds = before < 0.0 ? 0.0 : sample.time_s - before;
        before = sample.time_s;
        const double estimate = compensator.step(sequence.repeats.front().volts[i * width + t], seconds).pressure_psi;
        const double place = (estimate - setup.x_low) / (setup.x_high - setup.x_low) * static_cast<double>(n);
        const std::size_t at = std::min(n - 1, static_cast<std::size_t>(std::max(place, 0.0)));
        const std::size_t k = compensator.ascending() ? at : n + at;
        sums[t].squares[k] += std::pow(estimate - sample.reference_psi, 2);
        sums[t].count[k] += 1.0;
      }
  });
  setup.worked_s = 0.0;
  std::vector<double> shape(2 * n, 0.0), count(2 * n, 0.0);
  for (std::size_t t = 0; t < width; ++t) {
    if (sums[t].squares.empty()) continue;
    const double all = std::accumulate(sums[t].squares.begin(), sums[t].squares.end(), 0.0);
    const double mean = all / std::accumulate(sums[t].count.begin(), sums[t].count.end(), 0.0);
    setup.taxels[t].residual_scale = std::sqrt(mean);
    for (std::size_t k = 0; k < 2 * n && mean > 0.0; ++k) {
      shape[k] += sums[t].squares[k] / mean;
      count[k] += sums[t].count[k];
    }
  }
  for (std::size_t k = 0; k < 2 * n; ++k)
    setup.residual_psi.push_back(count[k] > 0.0 ? std::sqrt(shape[k] / count[k]) : 1.0);
}

}  // namespace

DynamicFit fit_dynamic(const Dataset& fitted, const Dataset* rate, const Dataset* creep,
                       const DynamicFitOptions& options) {
  DynamicFit fit;
  const Histories before = histories_of(fitted);
  const auto width = static_cast<std::size_t>(fitted.taxels());
  std::vector<bool> usable(width);
  for (std::size_t t = 0; t < width; ++t) usable[t] = before.taxels[t].usable();
  const std::vector<double> zeros = zeros_of(fitted);
  fit.dynamics = find_dynamics(rate, creep, zeros, usable);
  constexpr double lowest = 0.0;
  double highest = 0.0;
  for (const SequenceData& sequence : fitted.sequences)
    for (const Repeat& repeat : sequence.repeats)
      for (const Sample& sample : repeat.steps) highest = std::max(highest, sample.setpoint_psi);
  const Histories histories = histories_of(undone(fitted, fit.dynamics, zeros, lowest, highest));
  fit.setup.dynamics = fit.dynamics.shared;
  fit.setup.intervals = static_cast<std::size_t>(options.cells);
  fit.setup.taxels.resize(width);
  fit.mean_error_v.resize(width);
  IdentifyOptions identify;
  identify.cells = options.cells;
  identify.by_input = options.by_input;
  std::unique_ptr<Identifier> identifier;
  for (std::size_t t = 0; t < width && identifier == nullptr; ++t)
    if (usable[t]) {
      const FitData like = fit_data_of(histories.taxels[t], {});
      fit.setup.x_low = like.ascending.x().front();
      fit.setup.x_high = like.ascending.x().back();
      identifier = prepare("preisach", like, identify);
    }
  for_each_index(width, options.threads, [&](std::size_t t) {
    if (!usable[t]) return;
    const FitData data = fit_data_of(histories.taxels[t], {});
    DynamicTaxel& taxel = fit.setup.taxels[t];
    taxel.divider = options.linearise ? find_divider(data).divider : Divider{data.ascending.y().front(), 0.0};
    const ModelFit own = identifier->fit(linearised(data, taxel.divider));
    const auto& model = dynamic_cast<const PreisachModel&>(*own.model);
    taxel.everett = everett_of(model, fit.setup.intervals);
    taxel.creep_scale = fit.dynamics.creep_scale[t];
    taxel.lag_share = fit.dynamics.lag_share[t];
    taxel.noise_v = histories.taxels[t].noise;
    taxel.falling = histories.falling;
    taxel.usable = true;
    fit.mean_error_v[t] = own.mean_error;
  });
  find_residuals(fitted, options.threads, fit.setup);
  return fit;
}

}  // namespace tactbench::analysis
