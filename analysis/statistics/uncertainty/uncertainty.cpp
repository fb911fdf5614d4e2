#include "analysis/statistics/uncertainty/uncertainty.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <deque>
#include <iterator>
#include <numbers>

#include "analysis/identify/sensor_model.h"
#include "analysis/loop.h"
#include "analysis/statistics/figures/levels.h"
#include "analysis/workers.h"

namespace tactbench::analysis {

// Order of UncertaintySource.
const SourceText& text_of(UncertaintySource source) {
  static constexpr std::array<SourceText, kUncertaintySources> kTexts = {{
      {"reference, certificate", 'B', "normal", "psi", "U of the certificate", "U / k (4.3.3)"},
      {"reference, drift", 'B', "rectangular", "psi", "half-width", "stated limit of its change (4.3.7)"},
      {"reference, resolution", 'B', "rectangular", "psi", "half-width",
       "half a step of its converter or display (F.2.2.1)"},
      {"reference, voltage input", 'B', "rectangular", "psi", "half-width",
       "limit of error of the input that reads the transducer, by its data sheet, times psi a volt (4.3.7)"},
      {"reference, hysteresis", 'B', "rectangular", "psi", "half-width",
       "limit of the transducer's hysteresis, to each side (4.3.7)"},
      {"reference, zero", 'B', "rectangular", "psi", "half-width", "limit of the transducer's zero deviation (4.3.7)"},
      {"reference, temperature", 'B', "rectangular", "psi", "half-width",
       "limit of what temperature does to the transducer where the bench stands (4.3.7)"},
      {"chamber uniformity", 'A', "normal", "psi", "s",
       "spread of the chamber's pressure over the array, from the sensor turned in it (4.2.2)"},
      {"repeatability", 'A', "Student", "psi", "s",
       "scatter of full sweeps with the same way behind them, beyond the noise of a frame (4.2.2, H.5.2)"},
      {"noise", 'A', "normal", "V", "s",
       "scatter of the scans of a frame, of their mean (4.2.2), times the inverse's slope"},
      {"converter resolution", 'B', "rectangular", "V", "half-width",
       "half a count (F.2.2.1), times the inverse's slope"},
      {"lack of fit, corrected", 'A', "Student", "psi", "u of the mean",
       "the mean error of the full sweeps at the level is taken off; how well it is known (4.2.3, 6.3.1)"},
      {"zero return", 'A', "Student", "V", "u",
       "mean change of the unloaded output over a repeat, and s / sqrt(m), less the noise of the frames (4.2.3, 4.3.7, "
       "4.3.10), times the inverse's slope"},
      {"creep under load", 'B', "rectangular", "V", "half-width",
       "what the output continues to move after the dwell of the calibration, up to the end of a hold; on one side: "
       "half "
       "of it is taken off, half of it is the half-width (4.3.7, F.2.4.5), times the inverse's slope"},
      {"temperature", 'B', "rectangular", "V", "half-width",
       "change of the output a kelvin, with its own uncertainty, times half the range of the run's temperatures "
       "(4.3.7), times what the compensator makes of a whole loop that is moved by it: unloading, the turn at the top "
       "moves too"},
      {"re-mounting, common", 'A', "Student", "psi", "s",
       "between mounts of this sensor, what all taxels have in common, times sqrt(2): calibrated in one mount, used in "
       "another (4.2.2, m - 1 degrees of freedom)"},
      {"re-mounting, a taxel's own", 'A', "Student", "psi", "s",
       "the rest, times sqrt(2), pooled over the taxels (4.2.2, (m - 1)(taxels - 1) degrees of freedom)"},
      {"conditioning, rest, first sweep", 'A', "Student", "psi", "s",
       "between groups of full sweeps that differ in what lies before them (H.5.2)"},
      {"dwell and rate", 'B', "rectangular", "psi", "half-width",
       "largest change of the readings of one loop between dwell times (4.3.7)"},
      {"history (inner branches)", 'A', "Student", "psi", "s",
       "errors on inner branches within 4 psi (27.6 kPa) of the level, by direction, beyond the rows above (4.2.2, "
       "ways through "
       "the window as degrees of freedom)"},
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
  const auto off = [&](const LevelUncertainty& level) {
    return std::abs(level.pressure_psi - 0.5 * (low + high)) + (level.up ? 1e-9 : 0.0);
  };
  return static_cast<std::size_t>(std::ranges::min_element(levels, {}, off) - levels.begin());
}

// A centre of pressure moves by the taxels' own errors alone; the array is evenly loaded.
ArrayUncertainty array_uncertainty(const std::vector<Budget>& budgets, int columns) {
  ArrayUncertainty out;
  const auto n = static_cast<double>(budgets.size());
  double row = 0.0, column = 0.0;
  for (const Budget& budget : budgets) {
    const std::div_t place = std::div(budget.taxel, columns);
    row += place.quot / n;
    column += place.rem / n;
  }
  std::array<double, kUncertaintySources> common{}, own{}, dof{};
  double along_rows = 0.0, along_columns = 0.0;
  for (const Budget& budget : budgets) {
    double own_square = 0.0;
    for (const Contribution& part : budget.contributions) {
      const auto source = static_cast<std::size_t>(part.source);
      common[source] += std::sqrt(part.common) * part.u_psi / n;
      own[source] += (1.0 - part.common) * part.u_psi * part.u_psi / (n * n);
      dof[source] = part.dof;
      own_square += (1.0 - part.common) * part.u_psi * part.u_psi;
    }
    const std::div_t place = std::div(budget.taxel, columns);
    along_rows += std::pow(place.quot - row, 2) * own_square;
    along_columns += std::pow(place.rem - column, 2) * own_square;
  }
  std::vector<VarianceShare> shares;
  for (std::size_t source = 0; source < kUncertaintySources; ++source) {
    if (!(common[source] + own[source] > 0.0)) continue;
    shares.push_back({common[source], dof[source]});
    shares.push_back({std::sqrt(own[source]), kInfiniteDof});  // of many taxels
  }
  out.mean_u_psi = combined_uncertainty(shares);
  out.mean_expanded_psi = coverage_factor(std::max(1.0, effective_dof(shares))) * out.mean_u_psi;
  const double total = n * budgets.front().pressure_psi;
  out.centre_expanded =
      total > 0.0 ? coverage_factor(kInfiniteDof) * std::sqrt(std::max(along_rows, along_columns)) / total : kNan;
  return out;
}

// The further runs of a falling sensor with outputs that rise.
struct RisingRuns {
  UncertaintyInputs inputs;
  std::deque<Dataset> turned;
  RisingRuns(const UncertaintyInputs& given, const SensorModel& fit) : inputs(given) {
    HistoryRuns& history = inputs.history;
    for (std::vector<const Dataset*>* runs :
         {&history.same, &history.later, &history.warm, &history.mounted, &history.paced})
      for (const Dataset*& run : *runs) {
        check_same_sensor(*run, fit);
        if (fit.falling) run = &turned.emplace_back(as_modelled(*run, fit));
      }
  }
};

void keep_given(const UncertaintyInputs& inputs, Uncertainty& out) {
  const auto keep = [&](UncertaintySource source, const std::optional<GivenUncertainty>& given) {
    if (given) out.from[static_cast<std::size_t>(source)] = given->from;
  };
  keep(UncertaintySource::kUniformity, inputs.uniformity);
  keep(UncertaintySource::kMounting, inputs.mounting);
  keep(UncertaintySource::kMountingPerTaxel, inputs.mounting_per_taxel);
  if (out.reference.drift_missing.empty())
    out.from[static_cast<std::size_t>(UncertaintySource::kDrift)] = out.reference.drift_basis;
  for (std::size_t part = 0; part < kReferenceParts; ++part)
    out.from[static_cast<std::size_t>(UncertaintySource::kReferenceInput) + part] =
        out.reference.limits[part].part.from;
  out.creep = inputs.creep;
  out.temperature = inputs.temperature;
  out.from[static_cast<std::size_t>(UncertaintySource::kCreep)] = inputs.creep.display_text();
  out.from[static_cast<std::size_t>(UncertaintySource::kTemperature)] = inputs.temperature.display_text();
}

}  // namespace

const ConditionUncertainty& Uncertainty::condition(UseCondition which) const {
  return *std::ranges::find(conditions, which, &ConditionUncertainty::condition);
}

const LevelUncertainty* Uncertainty::level(double pressure_psi, bool up) const {
  const auto found = std::ranges::find_if(levels, [&](const LevelUncertainty& level) {
    return level.up == up && same_level(level.pressure_psi, pressure_psi);
  });
  return found == levels.end() ? nullptr : &*found;
}

Uncertainty assess_uncertainty(const Dataset& measured, const SensorModel& fit, const db::RunRecord& run,
                               const UncertaintyInputs& given, int threads) {
  check_same_sensor(measured, fit);
  const Dataset dataset = as_modelled(measured, fit);
  const RisingRuns rising(given, fit);
  const UncertaintyInputs& inputs = rising.inputs;
  Uncertainty out;
  out.reference = reference_uncertainty(run, inputs.notes);
  const SweepErrors errors = sweep_errors(dataset, fit, threads);
  const BudgetMaker maker(dataset, fit, errors, out.reference, scanner_step_v(run), inputs, threads);
  out.missing = maker.missing();
  keep_given(inputs, out);
  const std::vector<std::size_t> fitted = Fitted(fit).taxels();
  if (fitted.empty()) throw AnalysisError("TB-ANALYSIS-NO-TAXEL", "the fit has no fitted taxel", "fit another run");
  for (std::size_t i = 0; i < errors.levels.size(); ++i) {
    if (errors.levels[i].readings == 0 || !out.reference.holds_at(errors.levels[i].pressure_psi)) continue;
    LevelUncertainty level;
    level.pressure_psi = errors.levels[i].pressure_psi;
    level.up = errors.levels[i].up;
    level.expanded_psi.assign(fit.array().size(), kNan);
    level.error_psi.assign(fit.array().size(), kNan);
    level.factor.assign(fit.array().size(), kNan);
    std::vector<Budget> budgets(fitted.size());
    for_each_index(fitted.size(), threads, [&](std::size_t at) { budgets[at] = maker.budget(fitted[at], i); });
    for (const Budget& budget : budgets) {
      level.expanded_psi[static_cast<std::size_t>(budget.taxel)] = budget.expanded_psi;
      level.error_psi[static_cast<std::size_t>(budget.taxel)] = budget.error_psi;
      level.factor[static_cast<std::size_t>(budget.taxel)] = budget.factor;
    }
    level.array = array_uncertainty(budgets, fit.columns);
    level.not_linear = static_cast<int>(std::ranges::count(budgets, false, &Budget::linear));
    keep_median_and_worst(level, maker, i, fitted);
    out.levels.push_back(std::move(level));
  }
  out.chosen = chosen_level(out.levels);
  out.dwell = maker.dwell();
  out.conditions = empirical_uncertainty(maker.counted(), fit, maker.corrections(), errors.levels,
                                         [&](double psi) { return maker.unobservable_u_psi(psi); });
  return out;
}

std::vector<ConditionUncertainty> reading_conditions(const Dataset& measured, const SensorModel& fit,
                                                     const db::RunRecord& run, const HistoryRuns& history,
                                                     const SweepErrors& sweeps, int threads) {
  const Dataset dataset = as_modelled(measured, fit);
  UncertaintyInputs given;
  given.history = history;
  const RisingRuns rising(given, fit);
  const ReferenceUncertainty reference = reference_uncertainty(run);
  const bool certified = reference.certificate_missing.empty();
  return empirical_uncertainty(empirical_errors(dataset, rising.inputs.history, fit, threads), fit,
                               mean_errors(sweeps, fit.array().size()), sweeps.levels, [&](double psi) {
                                 return certified && reference.holds_at(psi) ? reference.combined_u(psi) : kNan;
                               });
}

// One budget: what contributes to the uncertainty of a compensated reading, and how much.

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
  if (!inputs_.mounting_per_taxel)
    missing(UncertaintySource::kMountingPerTaxel) = "no runs of this sensor mounted anew";
  if (errors_.groups < 2)
    missing(UncertaintySource::kConditioning) = "all full sweeps have the same way behind them: one group";
  missing(UncertaintySource::kDwell) = dwell_.not_assessed;
  if (!has_any_branch(reversals_))
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

// The part of a budget that readings tell: of full sweeps, of inner branches, of other dwell times, of further runs.

namespace {

std::vector<double> errors_of(const LevelReadings& level, std::size_t taxel, std::size_t width) {
  std::vector<double> errors;
  for (std::size_t i = 0; i < level.readings; ++i) errors.push_back(level.error_psi[i * width + taxel]);
  return errors;
}

// The readings of a taxel by the group that their sweeps belong to.
std::vector<std::vector<double>> groups_of(const LevelReadings& level, std::size_t taxel, std::size_t width,
                                           int groups) {
  std::vector<std::vector<double>> out(static_cast<std::size_t>(groups));
  for (std::size_t i = 0; i < level.readings; ++i)
    out[static_cast<std::size_t>(level.group[i])].push_back(level.error_psi[i * width + taxel]);
  return out;
}

double squared_u(const Budget& budget, UncertaintySource source) {
  for (const Contribution& row : budget.contributions)
    if (row.source == source) return row.u_psi * row.u_psi;
  return 0.0;
}

// Of the rows that this run's own full sweeps and frames tell of a reading.
double known_square(const Budget& budget) {
  double known = 0.0;
  for (const UncertaintySource source :
       {UncertaintySource::kNoise, UncertaintySource::kConverterStep, UncertaintySource::kZeroReturn,
        UncertaintySource::kRepeatability, UncertaintySource::kConditioning, UncertaintySource::kModel})
    known += squared_u(budget, source);
  return known;
}

}  // namespace

void BudgetMaker::find_histories(const Dataset& dataset, int threads) {
  corrections_ = mean_errors(errors_, fit_.array().size());
  counted_ = empirical_errors(dataset, inputs_.history, fit_, threads);
  std::vector<FrameHistory> reversals = counted_.in(UseCondition::kReversals).histories;
  std::ranges::copy(counted_.in(UseCondition::kSmallReversals).histories, std::back_inserter(reversals));
  reversals_ = pooled_errors(reversals, fit_, corrections_);
  if (!has_any_branch(reversals_)) {
    const FrameErrors own = frame_errors(dataset, fit_, threads);
    FrameHistory inner{&own, {}};
    for (std::size_t i = 0; i < own.frames.size(); ++i)
      if (!own.frames[i].full) inner.frames.push_back(i);
    reversals_ = pooled_errors({&inner, 1}, fit_, corrections_);
  }
  dwell_ = dwell_effect_of(dataset, inputs_.history.paced, fit_, threads);
}

// The scatter of the array's mean against the taxels' own: of a reading's variance what all taxels have in common.
void BudgetMaker::find_common() {
  const std::size_t width = fit_.array().size();
  for (const LevelReadings& level : errors_.levels) {
    std::vector<double> means, variances;
    for (std::size_t i = 0; i < level.readings; ++i)
      means.push_back(mean_of(finite_of(std::span(level.error_psi).subspan(i * width, width))));
    for (std::size_t taxel = 0; taxel < width; ++taxel)
      variances.push_back(sample_variance(errors_of(level, taxel, width)));
    const double common = sample_variance(means), own = mean_of(finite_of(variances));
    common_scatter_.push_back(own > 0.0 && common > 0.0 ? std::min(1.0, common / own) : 0.0);
  }
}

// Repeatability is what the scatter within groups of sweeps has beyond the noise of one frame, which has a row of its
// own (4.3.10: nothing counts twice); conditioning, rest and first sweep are the scatter between the groups. The mean
// error is taken off: what is left of the lack of fit is how well that mean is known (4.2.3).
void BudgetMaker::add_readings(Budget& budget, std::size_t taxel, std::size_t level) const {
  const LevelReadings& readings = errors_.levels[level];
  const double noise = squared_u(budget, UncertaintySource::kNoise), common = common_scatter_[level];
  const GroupedScatter scatter = grouped_scatter(groups_of(readings, taxel, fit_.array().size(), errors_.groups));
  if (scatter.within_dof > 0.0)
    add(budget, UncertaintySource::kRepeatability, std::sqrt(std::max(0.0, scatter.within - noise)), 1.0, 1.0,
        scatter.within_dof, common);
  if (scatter.between_dof > 0.0)
    add(budget, UncertaintySource::kConditioning, std::sqrt(scatter.between), 1.0, 1.0, scatter.between_dof, common);
  const std::vector<VarianceShare> mean = {
      {std::sqrt(std::max(scatter.within, noise) / scatter.readings), std::max(1.0, scatter.within_dof)},
      {std::sqrt(scatter.between / std::max(1.0, scatter.groups)), std::max(1.0, scatter.between_dof)}};
  add(budget, UncertaintySource::kModel, combined_uncertainty(mean), 1.0, 1.0, effective_dof(mean), common);
}

// What the readings of the history err by beyond what the rows above say of them (4.3.10). A window without a way
// through it takes that of the nearest level of its direction.
void BudgetMaker::add_history(Budget& budget, std::size_t taxel) const {
  const WindowErrors* own = nullptr;
  for (const WindowErrors& window : reversals_) {
    if (window.up != budget.up || !(window.branches > 0.0)) continue;
    const double off = std::abs(window.pressure_psi - budget.pressure_psi);
    if (own == nullptr || off < std::abs(own->pressure_psi - budget.pressure_psi)) own = &window;
  }
  if (own == nullptr) return;
  const double square = own->square_psi[taxel];
  const double common = square > 0.0 ? std::min(1.0, own->common_square_psi / square) : 0.0;
  add(budget, UncertaintySource::kHistory, std::sqrt(std::max(0.0, square - known_square(budget))), 1.0, 1.0,
      own->branches, common);
}

void BudgetMaker::add_dwell(Budget& budget, std::size_t taxel, std::size_t level) const {
  if (!assessed(UncertaintySource::kDwell)) return;
  const double square = dwell_.square_psi[level * fit_.array().size() + taxel];
  const double noise = 2.0 * squared_u(budget, UncertaintySource::kNoise);
  add(budget, UncertaintySource::kDwell, std::sqrt(std::max(0.0, square - noise)), std::sqrt(3.0), 1.0, kInfiniteDof,
      1.0);
}

void BudgetMaker::add_given(Budget& budget) const {
  const auto add_it = [&](UncertaintySource source, const std::optional<GivenUncertainty>& given, double common) {
    if (given) add(budget, source, given->u(budget.pressure_psi), 1.0, 1.0, given->dof, common);
  };
  add_it(UncertaintySource::kUniformity, inputs_.uniformity, 0.0);
  add_it(UncertaintySource::kMounting, inputs_.mounting, 1.0);
  add_it(UncertaintySource::kMountingPerTaxel, inputs_.mounting_per_taxel, 0.0);
}

double BudgetMaker::unobservable_u_psi(double pressure_psi) const {
  if (!reference_.certificate_missing.empty() || !reference_.holds_at(pressure_psi)) return kNan;
  return std::hypot(reference_.combined_u(pressure_psi),
                    inputs_.uniformity ? inputs_.uniformity->u(pressure_psi) : 0.0);
}

}  // namespace tactbench::analysis
