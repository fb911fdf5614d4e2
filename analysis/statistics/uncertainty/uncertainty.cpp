#include "analysis/statistics/uncertainty/uncertainty.h"

#include <algorithm>
#include <cmath>

#include "analysis/statistics/figures/levels.h"
#include "analysis/statistics/figures/same_sensor.h"
#include "analysis/workers.h"

namespace tactbench::analysis {

// Order of UncertaintySource.
const SourceText& text_of(UncertaintySource source) {
  static constexpr std::array<SourceText, kUncertaintySources> kTexts = {{
      {"reference, certificate", 'B', "normal", "psi", "U of the certificate", "U / k (4.3.3)"},
      {"reference, drift", 'B', "rectangular", "psi", "half-width", "stated limit of its change (4.3.7)"},
      {"reference, resolution", 'B', "rectangular", "psi", "half-width",
       "half a step of its converter or display (F.2.2.1)"},
      {"chamber uniformity", 'A', "normal", "psi", "s",
       "spread of the chamber's pressure over the array, from the sensor turned in it (4.2.2)"},
      {"repeatability", 'A', "Student", "psi", "s",
       "scatter over the full sweeps beyond the noise of a frame (4.2.2, n - 1 degrees of freedom)"},
      {"noise", 'A', "normal", "V", "s",
       "scatter of the scans of a frame, of their mean (4.2.2), times the inverse's slope"},
      {"converter resolution", 'B', "rectangular", "V", "half-width",
       "half a count (F.2.2.1), times the inverse's slope"},
      {"model residual", 'B', "normal", "psi", "rms",
       "mean errors at the level and two neighbours to each side, not corrected (F.2.4.5)"},
      {"zero return", 'B', "rectangular", "V", "half-width",
       "largest change of the unloaded output over a repeat (4.3.7), times the inverse's slope"},
      {"creep under load", 'B', "rectangular", "V", "half-width",
       "what the output goes on moving after the dwell of the calibration, up to the end of a hold; on one side, not "
       "corrected: half-width is the whole of it (4.3.7, F.2.4.5), times the inverse's slope"},
      {"temperature", 'B', "rectangular", "V", "half-width",
       "change of the output a kelvin, with its own uncertainty, times half the range of the run's temperatures "
       "(4.3.7), times what the compensator makes of a whole loop that is moved by it: unloading, the turn at the top "
       "moves too"},
      {"re-mounting", 'A', "Student", "psi", "s", "between mounts of this sensor (4.2.2)"},
  }};
  return kTexts[static_cast<std::size_t>(source)];
}

namespace {

void keep_median_and_worst(LevelUncertainty& level, const BudgetMaker& maker, std::size_t index,
                           const std::vector<std::size_t>& fitted) {
  std::vector<std::size_t> order = fitted;
  std::ranges::stable_sort(order, {}, [&](std::size_t taxel) { return level.expanded_psi[taxel]; });
  level.median = maker.budget(order[(order.size() - 1) / 2], index);
  level.worst = maker.budget(order.back(), index);
}

// Mid range, going down, where the inverse is worked hardest; else any.
std::size_t chosen_level(const std::vector<LevelUncertainty>& levels) {
  double low = kNan, high = kNan;
  for (const LevelUncertainty& level : levels) {
    low = std::fmin(low, level.pressure_psi);
    high = std::fmax(high, level.pressure_psi);
  }
  std::size_t best = 0;
  double nearest = kInfiniteDof;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const double off = std::abs(levels[i].pressure_psi - 0.5 * (low + high)) + (levels[i].up ? 1e-9 : 0.0);
    if (off >= nearest) continue;
    nearest = off;
    best = i;
  }
  return best;
}

void keep_given(const UncertaintyInputs& inputs, Uncertainty& out) {
  const auto keep = [&](UncertaintySource source, const std::optional<GivenUncertainty>& given) {
    if (given) out.from[static_cast<std::size_t>(source)] = given->from;
  };
  keep(UncertaintySource::kUniformity, inputs.uniformity);
  keep(UncertaintySource::kMounting, inputs.mounting);
  if (out.reference.drift_missing.empty())
    out.from[static_cast<std::size_t>(UncertaintySource::kDrift)] = out.reference.drift_basis;
  out.creep = inputs.creep;
  out.temperature = inputs.temperature;
  out.from[static_cast<std::size_t>(UncertaintySource::kCreep)] = inputs.creep.in_words();
  out.from[static_cast<std::size_t>(UncertaintySource::kTemperature)] = inputs.temperature.in_words();
}

}  // namespace

const LevelUncertainty* Uncertainty::level(double pressure_psi, bool up) const {
  const auto found = std::ranges::find_if(levels, [&](const LevelUncertainty& level) {
    return level.up == up && std::abs(level.pressure_psi - pressure_psi) < 1e-6;
  });
  return found == levels.end() ? nullptr : &*found;
}

Uncertainty assess_uncertainty(const Dataset& measured, const SensorModel& measured_fit, const db::RunRecord& run,
                               const UncertaintyInputs& inputs, int threads) {
  check_same_sensor(measured, measured_fit);
  SensorModel fit = measured_fit;
  const Dataset dataset = as_modelled(measured, fit);
  fit.falling = false;
  Uncertainty out;
  out.reference = reference_uncertainty(run, inputs.notes);
  const SweepErrors errors = sweep_errors(dataset, fit, threads);
  const BudgetMaker maker(dataset, fit, errors, out.reference, scanner_step_v(run), inputs);
  out.missing = maker.missing();
  keep_given(inputs, out);
  const std::vector<std::size_t> fitted = Fitted(fit).taxels();
  if (fitted.empty()) throw AnalysisError("TB-ANALYSIS-NO-TAXEL", "the fit has no fitted taxel", "fit another run");
  for (std::size_t i = 0; i < errors.levels.size(); ++i) {
    if (errors.levels[i].readings == 0) continue;
    LevelUncertainty level;
    level.pressure_psi = errors.levels[i].pressure_psi;
    level.up = errors.levels[i].up;
    level.expanded_psi.assign(fit.array().size(), kNan);
    std::vector<char> linear(fit.array().size(), 1);
    for_each_index(fitted.size(), threads, [&](std::size_t at) {
      const Budget budget = maker.budget(fitted[at], i);
      level.expanded_psi[fitted[at]] = budget.expanded_psi;
      linear[fitted[at]] = budget.linear ? 1 : 0;
    });
    level.not_linear = static_cast<int>(std::ranges::count(linear, 0));
    keep_median_and_worst(level, maker, i, fitted);
    out.levels.push_back(std::move(level));
  }
  out.chosen = chosen_level(out.levels);
  return out;
}

}  // namespace tactbench::analysis
