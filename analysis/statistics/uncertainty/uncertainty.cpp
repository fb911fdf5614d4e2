#include "analysis/statistics/uncertainty/budget_maker.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <deque>

#include "analysis/loop.h"
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
  keep(UncertaintySource::kMountingOwn, inputs.mounting_own);
  if (out.reference.drift_missing.empty())
    out.from[static_cast<std::size_t>(UncertaintySource::kDrift)] = out.reference.drift_basis;
  for (std::size_t part = 0; part < kReferenceParts; ++part)
    out.from[static_cast<std::size_t>(UncertaintySource::kReferenceInput) + part] =
        out.reference.limits[part].part.from;
  out.creep = inputs.creep;
  out.temperature = inputs.temperature;
  out.from[static_cast<std::size_t>(UncertaintySource::kCreep)] = inputs.creep.in_words();
  out.from[static_cast<std::size_t>(UncertaintySource::kTemperature)] = inputs.temperature.in_words();
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

Uncertainty assess_uncertainty(const Dataset& measured, const SensorModel& measured_fit, const db::RunRecord& run,
                               const UncertaintyInputs& given, int threads) {
  check_same_sensor(measured, measured_fit);
  SensorModel fit = measured_fit;
  const Dataset dataset = as_modelled(measured, fit);
  const RisingRuns rising(given, measured_fit);
  const UncertaintyInputs& inputs = rising.inputs;
  fit.falling = false;
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
  out.conditions = counted_uncertainty(maker.counted(), fit, maker.corrections(), errors.levels,
                                       [&](double psi) { return maker.hidden_psi(psi); });
  return out;
}

std::vector<ConditionUncertainty> reading_conditions(const Dataset& measured, const SensorModel& measured_fit,
                                                     const db::RunRecord& run, const HistoryRuns& history,
                                                     const SweepErrors& sweeps, int threads) {
  SensorModel fit = measured_fit;
  const Dataset dataset = as_modelled(measured, fit);
  UncertaintyInputs given;
  given.history = history;
  const RisingRuns rising(given, measured_fit);
  fit.falling = false;
  const ReferenceUncertainty reference = reference_uncertainty(run);
  const bool certified = reference.certificate_missing.empty();
  return counted_uncertainty(counted_errors(dataset, rising.inputs.history, fit, threads), fit,
                             mean_errors(sweeps, fit.array().size()), sweeps.levels, [&](double psi) {
                               return certified && reference.holds_at(psi) ? reference.combined_u(psi) : kNan;
                             });
}

}  // namespace tactbench::analysis
