// One budget: what contributes to the uncertainty of a compensated reading, and how much.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "analysis/identify/compensators.h"
#include "analysis/statistics/figures/levels.h"
#include "analysis/statistics/uncertainty/budget_maker.h"

namespace tactbench::analysis {
namespace {

const double rectangular = std::numbers::sqrt3;  // 4.3.7: a / sqrt(3)
constexpr double kSlopeChange = 0.25;            // of the inverse within +-2 u: more is not linear ...
constexpr double kVoltageVariance = 0.10;        // ... where the voltage has more of the variance than this

// The branch of the external loop, and its inverse about the voltage at a pressure.
struct LocalInverse {
  double sensitivity = 0.0;  // psi/V: c = (f(v + u) - f(v - u)) / 2u (5.1.3, note 2); at the curve's end one-sided
  bool linear = true;
};

LocalInverse inverse_about(const ModelTaxel& model, bool up, double pressure_psi, double u_v) {
  const ExternalBranch curve(model, up);
  const double v = curve.output(pressure_psi), u = u_v > 0.0 ? u_v : 1e-6 * (model.yu() - model.y0());
  const double low = model.y0(), high = model.yu();
  const auto slope = [&](double from, double to) {
    from = std::max(from, low);
    to = std::min(to, high);
    return to > from ? (curve.input(to) - curve.input(from)) / (to - from) : 0.0;
  };
  const double below = slope(v - 2.0 * u, v), above = slope(v, v + 2.0 * u);
  const bool cut = v - 2.0 * u < low || v + 2.0 * u > high;
  const double middle = 0.5 * (below + above);
  return {slope(v - u, v + u), !cut && std::abs(above - below) <= 2.0 * kSlopeChange * middle};
}

// psi/V of what moves the output along the whole way to the reading, as temperature does: unloading, the turn at the
// top moves too, and the compensator takes that into account. Half-widths at the reading and at the top.
double sensitivity_along(const ModelTaxel& model, bool up, double pressure_psi, double width_v, double top_width_v) {
  const double v = ExternalBranch(model, up).output(pressure_psi);
  const double least = 1e-6 * (model.yu() - model.y0());
  const double width = std::max(width_v, least), top_width = std::max(top_width_v, least);
  const auto read = [&](double sign) {
    const auto compensator = compensator_of({}, model, 0.0);  // of the model alone, without noise
    if (!up) (void)compensator->step(model.yu() + sign * top_width, 0.0);
    return compensator->step(v + sign * width, 0.0).pressure_psi;
  };
  return (read(1.0) - read(-1.0)) / (2.0 * width);
}

bool of_voltage(UncertaintySource source) {
  return source == UncertaintySource::kNoise || source == UncertaintySource::kConverterStep ||
         source == UncertaintySource::kZeroReturn || source == UncertaintySource::kCreep;
}

std::size_t index_of(UncertaintySource source) { return static_cast<std::size_t>(source); }

}  // namespace

BudgetMaker::BudgetMaker(const Dataset& dataset, const SensorModel& fit, const SweepErrors& errors,
                         const ReferenceUncertainty& reference, double step_v, const UncertaintyInputs& inputs,
                         int threads)
    : fit_(fit), errors_(errors), reference_(reference), inputs_(inputs), noise_v_(dataset.noise_v), step_v_(step_v) {
  for (const SequenceData& data : dataset.sequences)
    for (const Repeat& repeat : data.repeats)
      noise_dof_ += static_cast<double>(repeat.steps.size()) * (dataset.scans - 1);
  find_common();
  find_histories(dataset, threads);
  find_missing(dataset);
}

void BudgetMaker::find_missing(const Dataset& dataset) {
  const auto missing = [this](UncertaintySource source) -> std::string& { return missing_[index_of(source)]; };
  missing(UncertaintySource::kCertificate) = reference_.certificate_missing;
  missing(UncertaintySource::kDrift) = reference_.drift_missing;
  missing(UncertaintySource::kReferenceDigit) = reference_.resolution_missing;
  for (std::size_t part = 0; part < kReferenceParts; ++part)
    missing_[index_of(UncertaintySource::kReferenceInput) + part] = reference_.limits[part].part.missing;
  if (!inputs_.uniformity)
    missing(UncertaintySource::kUniformity) =
        "no runs of one sensor turned by 0, 90, 180 and 270 degrees in the chamber";
  if (std::ranges::none_of(errors_.levels, [](const LevelReadings& level) { return level.readings >= 2; }))
    missing(UncertaintySource::kRepeatability) = "one full sweep is no repetition: run the recipe with more repeats";
  if (!(noise_dof_ > 0.0))
    missing(UncertaintySource::kNoise) = "one scan a frame: the noise is within the repeatability";
  if (!(step_v_ > 0.0))
    missing(UncertaintySource::kConverterStep) = "the scanner's volts a count are not kept with the run";
  if (errors_.repeats_with_zero == 0)
    missing(UncertaintySource::kZeroReturn) = "no repeat begins and ends at the lowest pressure";
  missing(UncertaintySource::kCreep) = inputs_.creep.not_assessed;
  missing(UncertaintySource::kTemperature) = inputs_.temperature.not_assessed;
  if (!inputs_.temperature.assessed() && dataset.temperatures_c.empty())
    missing(UncertaintySource::kTemperature) = "the run has no temperature readings";
  if (!inputs_.mounting) missing(UncertaintySource::kMounting) = "no runs of this sensor mounted anew";
  if (!inputs_.mounting_own) missing(UncertaintySource::kMountingOwn) = "no runs of this sensor mounted anew";
  if (errors_.groups < 2)
    missing(UncertaintySource::kConditioning) = "all full sweeps have the same way behind them: one group";
  missing(UncertaintySource::kDwell) = dwell_.not_assessed;
  if (!any_way(reversals_))
    missing(UncertaintySource::kHistory) = "neither this run nor a held-out one has inner branches";
}

bool BudgetMaker::assessed(UncertaintySource source) const { return missing_[index_of(source)].empty(); }

void BudgetMaker::add(Budget& budget, UncertaintySource source, double width, double divisor, double sensitivity,
                      double dof, double common) const {
  if (!assessed(source)) return;
  budget.contributions.push_back(
      {source, width, divisor, sensitivity, std::abs(sensitivity) * width / divisor, dof, common});
}

void BudgetMaker::add_reference(Budget& budget) const {
  static_assert(static_cast<int>(UncertaintySource::kCertificate) == 0 &&
                static_cast<int>(UncertaintySource::kReferenceDigit) == 2 &&
                static_cast<int>(UncertaintySource::kReferenceTemperature) == 2 + kReferenceParts);  // ReferenceRow
  for (const ReferenceRow& row : reference_.rows(reference_.certificate_u(budget.pressure_psi), reference_.drift_psi))
    add(budget, static_cast<UncertaintySource>(row.source), row.width_psi, row.divisor, 1.0, kInfiniteDof, 1.0);
}

// What m returns show beyond the noise of their two frames: half of a mean return in the middle of a repeat, even
// between none and the whole of it (4.3.7), and what the mean is known to, s / sqrt(m) (4.2.3). No noise counts twice
// (4.3.10).
double BudgetMaker::zero_return_u(std::size_t taxel) const {
  if (!assessed(UncertaintySource::kZeroReturn)) return 0.0;
  const double noise = 2.0 * noise_v_[taxel] * noise_v_[taxel], m = static_cast<double>(errors_.repeats_with_zero);
  const double mean = errors_.zero_return_v[taxel], s = errors_.zero_return_s_v[taxel];
  return std::sqrt(std::max(0.0, mean * mean - noise / m) / 3.0 + std::max(0.0, s * s - noise) / m);
}

void BudgetMaker::add_voltages(Budget& budget, std::size_t taxel) const {
  const double noise = assessed(UncertaintySource::kNoise) ? noise_v_[taxel] : 0.0;
  const double step = assessed(UncertaintySource::kConverterStep) ? 0.5 * step_v_ : 0.0;
  const double zero = zero_return_u(taxel);
  const ModelTaxel& model = fit_.taxels[taxel];
  const double over_zero = ExternalBranch(model, budget.up).output(budget.pressure_psi) - model.y0();
  // The output goes on rising after a rise and falling after a fall: an error between 0 and the whole of it.
  const double creep = assessed(UncertaintySource::kCreep)
                           ? 0.5 * inputs_.creep.share(taxel, budget.pressure_psi, budget.up) * over_zero
                           : 0.0;
  const double u_v = std::hypot(std::hypot(noise, step / rectangular, zero), creep / rectangular);
  const LocalInverse inverse = inverse_about(model, budget.up, budget.pressure_psi, u_v);
  budget.linear = inverse.linear;
  add(budget, UncertaintySource::kNoise, noise, 1.0, inverse.sensitivity, noise_dof_);
  add(budget, UncertaintySource::kConverterStep, step, rectangular, inverse.sensitivity);
  add(budget, UncertaintySource::kZeroReturn, zero, 1.0, inverse.sensitivity,
      std::max(1.0, static_cast<double>(errors_.repeats_with_zero) - 1.0));
  add(budget, UncertaintySource::kCreep, creep, rectangular, inverse.sensitivity, kInfiniteDof, 1.0);
  budget.error_psi += (budget.up ? 1.0 : -1.0) * creep * inverse.sensitivity;
  if (!assessed(UncertaintySource::kTemperature)) return;
  const double warmth = inputs_.temperature.width_v(over_zero);
  const double top = inputs_.temperature.width_v(model.yu() - model.y0());
  add(budget, UncertaintySource::kTemperature, warmth, rectangular,
      sensitivity_along(model, budget.up, budget.pressure_psi, warmth, top), kInfiniteDof, 1.0);
}

void BudgetMaker::finish(Budget& budget) const {
  std::ranges::stable_sort(budget.contributions, {}, &Contribution::source);
  // A drift beyond its stated limit is more doubt and no knowledge: it raises u, and lowers no k.
  const bool grown = reference_.drift_psi > reference_.drift_stated_psi;
  std::vector<VarianceShare> shares, firm;
  double voltage = 0.0;
  for (const Contribution& contribution : budget.contributions) {
    shares.push_back({contribution.u_psi, contribution.dof});
    firm.push_back(shares.back());
    if (grown && contribution.source == UncertaintySource::kDrift)
      firm.back().u *= reference_.drift_stated_psi / reference_.drift_psi;
    if (of_voltage(contribution.source)) voltage += contribution.u_psi * contribution.u_psi;
  }
  budget.combined_psi = combined_uncertainty(shares);
  budget.dof = effective_dof(firm);
  budget.factor = coverage_factor(std::max(1.0, budget.dof));
  budget.expanded_psi = budget.factor * budget.combined_psi;
  if (voltage <= kVoltageVariance * budget.combined_psi * budget.combined_psi) budget.linear = true;
}

Budget BudgetMaker::budget(std::size_t taxel, std::size_t level) const {
  Budget budget;
  budget.taxel = static_cast<int>(taxel);
  budget.pressure_psi = errors_.levels[level].pressure_psi;
  budget.up = errors_.levels[level].up;
  budget.readings = errors_.levels[level].readings;
  budget.error_psi = corrections_[level * fit_.array().size() + taxel];
  budget.contributions.reserve(kUncertaintySources);
  add_reference(budget);
  add_voltages(budget, taxel);
  add_readings(budget, taxel, level);
  add_dwell(budget, taxel, level);
  add_given(budget);
  add_history(budget, taxel);
  finish(budget);
  return budget;
}

}  // namespace tactbench::analysis
