// One budget: what contributes to the uncertainty of a compensated reading, and how much.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "analysis/identify/taxel_stream.h"
#include "analysis/statistics/figures/levels.h"
#include "analysis/statistics/uncertainty/uncertainty.h"

namespace tactbench::analysis {
namespace {

const double rectangular = std::numbers::sqrt3;  // 4.3.7: a / sqrt(3)
constexpr std::size_t kResidualReach = 2;        // levels to each side that the model's residual is taken from
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
    TaxelStream compensator(model, 0.0);  // of the model alone, without noise
    if (!up) (void)compensator.step(model.yu() + sign * top_width);
    return compensator.step(v + sign * width).pressure_psi;
  };
  return (read(1.0) - read(-1.0)) / (2.0 * width);
}

std::vector<double> errors_of(const LevelReadings& level, std::size_t taxel, std::size_t width) {
  std::vector<double> errors;
  for (std::size_t i = 0; i < level.readings; ++i) errors.push_back(level.error_psi[i * width + taxel]);
  return errors;
}

bool of_voltage(UncertaintySource source) {
  return source == UncertaintySource::kNoise || source == UncertaintySource::kConverterStep ||
         source == UncertaintySource::kZeroReturn || source == UncertaintySource::kCreep;
}

std::size_t index_of(UncertaintySource source) { return static_cast<std::size_t>(source); }

}  // namespace

BudgetMaker::BudgetMaker(const Dataset& dataset, const SensorModel& fit, const SweepErrors& errors,
                         const ReferenceUncertainty& reference, double step_v, const UncertaintyInputs& inputs)
    : fit_(fit), errors_(errors), reference_(reference), inputs_(inputs), noise_v_(dataset.noise_v), step_v_(step_v) {
  for (const SequenceData& data : dataset.sequences)
    for (const Repeat& repeat : data.repeats)
      noise_dof_ += static_cast<double>(repeat.steps.size()) * (dataset.scans - 1);
  find_missing(dataset);
}

void BudgetMaker::find_missing(const Dataset& dataset) {
  const auto missing = [this](UncertaintySource source) -> std::string& { return missing_[index_of(source)]; };
  missing(UncertaintySource::kCertificate) = reference_.certificate_missing;
  missing(UncertaintySource::kDrift) = reference_.drift_missing;
  missing(UncertaintySource::kReferenceDigit) = reference_.resolution_missing;
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
}

bool BudgetMaker::assessed(UncertaintySource source) const { return missing_[index_of(source)].empty(); }

void BudgetMaker::add(Budget& budget, UncertaintySource source, double width, double divisor, double sensitivity,
                      double dof) const {
  if (!assessed(source)) return;
  budget.contributions.push_back({source, width, divisor, sensitivity, std::abs(sensitivity) * width / divisor, dof});
}

void BudgetMaker::add_reference(Budget& budget) const {
  const double k = reference_.coverage_factor;
  add(budget, UncertaintySource::kCertificate, k * reference_.certificate_u(budget.pressure_psi), k);
  add(budget, UncertaintySource::kDrift, reference_.drift_psi, rectangular);
  add(budget, UncertaintySource::kReferenceDigit, 0.5 * reference_.resolution_psi, rectangular);
}

void BudgetMaker::add_voltages(Budget& budget, std::size_t taxel) const {
  const double noise = assessed(UncertaintySource::kNoise) ? noise_v_[taxel] : 0.0;
  const double step = assessed(UncertaintySource::kConverterStep) ? 0.5 * step_v_ : 0.0;
  const double zero = assessed(UncertaintySource::kZeroReturn) ? errors_.zero_return_v[taxel] : 0.0;
  const ModelTaxel& model = fit_.taxels[taxel];
  const double over_zero = ExternalBranch(model, budget.up).output(budget.pressure_psi) - model.y0();
  const double creep = assessed(UncertaintySource::kCreep)
                           ? inputs_.creep.share(taxel, budget.pressure_psi, budget.up) * over_zero
                           : 0.0;
  const double u_v = std::hypot(std::hypot(noise, step / rectangular, zero / rectangular), creep / rectangular);
  const LocalInverse inverse = inverse_about(model, budget.up, budget.pressure_psi, u_v);
  budget.linear = inverse.linear;
  add(budget, UncertaintySource::kNoise, noise, 1.0, inverse.sensitivity, noise_dof_);
  add(budget, UncertaintySource::kConverterStep, step, rectangular, inverse.sensitivity);
  add(budget, UncertaintySource::kZeroReturn, zero, rectangular, inverse.sensitivity);
  add(budget, UncertaintySource::kCreep, creep, rectangular, inverse.sensitivity);
  if (!assessed(UncertaintySource::kTemperature)) return;
  const double warmth = inputs_.temperature.width_v(over_zero);
  const double top = inputs_.temperature.width_v(model.yu() - model.y0());
  add(budget, UncertaintySource::kTemperature, warmth, rectangular,
      sensitivity_along(model, budget.up, budget.pressure_psi, warmth, top));
}

double BudgetMaker::mean_error(std::size_t level, std::size_t taxel) const {
  return mean_by_shares(errors_of(errors_.levels[level], taxel, fit_.array().size()));
}

// Repeatability is what the scatter of the readings has beyond the noise of one frame, which has a row of its own
// (4.3.10: nothing counts twice). The residual is the root mean square of the mean errors at the level and its
// neighbours: a known correction that is not made, averaged over the pressures near the level (F.2.4.5).
void BudgetMaker::add_readings(Budget& budget, std::size_t taxel, std::size_t level) const {
  const LevelReadings& readings = errors_.levels[level];
  const std::size_t width = fit_.array().size(), half = errors_.levels.size() / 2;
  if (readings.readings >= 2) {
    double noise = 0.0;
    for (const Contribution& other : budget.contributions)
      if (other.source == UncertaintySource::kNoise) noise = other.u_psi;
    const double scatter = sample_deviation(errors_of(readings, taxel, width));
    add(budget, UncertaintySource::kRepeatability, std::sqrt(std::max(0.0, scatter * scatter - noise * noise)), 1.0,
        1.0, static_cast<double>(readings.readings - 1));
  }
  const std::size_t first = level < half ? 0 : half, last = first + half - 1;
  double squares = 0.0;
  int levels = 0;
  for (std::size_t at = std::max(level, first + kResidualReach) - kResidualReach;
       at <= std::min(level + kResidualReach, last); ++at) {
    const double error = mean_error(at, taxel);
    if (std::isnan(error)) continue;
    squares += error * error;
    ++levels;
  }
  add(budget, UncertaintySource::kModel, std::sqrt(squares / levels), 1.0, 1.0, levels);
}

void BudgetMaker::add_given(Budget& budget) const {
  const auto at_level = [&](const std::optional<GivenUncertainty>& given) {
    return given ? std::hypot(given->psi, given->share * budget.pressure_psi) : 0.0;
  };
  const auto dof = [](const std::optional<GivenUncertainty>& given) { return given ? given->dof : kInfiniteDof; };
  const auto add_it = [&](UncertaintySource source, const std::optional<GivenUncertainty>& given) {
    add(budget, source, at_level(given), 1.0, 1.0, dof(given));
  };
  add_it(UncertaintySource::kUniformity, inputs_.uniformity);
  add_it(UncertaintySource::kMounting, inputs_.mounting);
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
  budget.error_psi = mean_error(level, taxel);
  budget.contributions.reserve(kUncertaintySources);
  add_reference(budget);
  add_voltages(budget, taxel);
  add_readings(budget, taxel, level);
  add_given(budget);
  finish(budget);
  return budget;
}

}  // namespace tactbench::analysis
