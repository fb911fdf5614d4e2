#include "analysis/identify/dynamic/dynamic_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "analysis/identify/dynamic/dynamics_search.h"
#include "analysis/identify/residuals.h"
#include "analysis/pressure_unit.h"
#include "analysis/statistics/numbers/moments.h"

namespace tactbench::analysis {
namespace {

constexpr double kClearlyLess = 0.8;  // of a misfit

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

void check_found(const ArrayDynamics& found, const Dataset* rate, const Dataset* creep) {
  if (creep != nullptr && found.holds == 0)
    throw AnalysisError("TB-ANALYSIS-DYNAMICS",
                        fmt::format("run {} shows no creep: it holds no level for ten frames", creep->run),
                        "measure one that does: tactbench run creep-levels");
  if (rate != nullptr && found.rate_samples == 0)
    throw AnalysisError("TB-ANALYSIS-DYNAMICS",
                        fmt::format("run {} shows no lag: no repeat of it takes twice as long as another", rate->run),
                        "measure one at several dwell times: tactbench run rate");
}

double lowest_level(const Dataset& fitted) {
  double lowest = HUGE_VAL;
  for (const SequenceData& sequence : fitted.sequences)
    for (const Sample& sample : sequence.repeats.front().steps) lowest = std::min(lowest, sample.setpoint_psi);
  return lowest;
}

// Lag and creep count pressures from 0.
void check_lowest(const Dataset& fitted) {
  if (const double lowest = lowest_level(fitted); lowest != 0.0)
    throw AnalysisError(
        "TB-ANALYSIS-DYNAMICS",
        fmt::format("run {} never returns to zero pressure: its lowest level is {}", fitted.run, both_units(lowest)),
        "the dynamic model counts from the unloaded film: fit a run whose levels begin at zero");
}

// Cells that are finer than the levels lie between samples: weights there would be any that have the same sums.
int intervals_between_levels(const Dataset& fitted) {
  std::set<double> levels;
  for (const SequenceData& sequence : fitted.sequences)
    for (const Repeat& repeat : sequence.repeats)
      for (const Sample& sample : repeat.steps) levels.insert(sample.setpoint_psi);
  return std::max(1, static_cast<int>(levels.size()) - 1);
}

// Of all runs, since lag and creep are undone there; inputs are those of the first.
Validity validity_of_runs(const Histories& fitted, const std::vector<Histories>& others) {
  const auto scored = [](const Histories& histories) {
    return std::ranges::find_if(histories.taxels, [](const auto& t) { return !t.score.empty(); })->score;
  };
  std::vector<History> all = scored(fitted);
  Validity validity = validity_of(all, fitted.temperatures_c);
  for (const Histories& other : others)
    for (const History& history : scored(other)) all.push_back(history);
  const Validity times = validity_of(all, {});
  validity.hold_s = times.hold_s;
  validity.rate = times.rate;
  return validity;
}

// Of the runs that are named; creep of none from the fitted run. A film may move in a hold without creeping from pass
// to pass, and holds tell the creep of their own length, and one hold that of its own level, alone. So theirs is taken
// where passes of the fitted run over the same levels are clearly more alike with it than without, and no less than
// with the creep that the run tells itself (of one hold: clearly more alike than with that one); else that is, or none,
// with the taxels' scales from the holds.
ArrayDynamics dynamics_of(const Dataset& fitted, const Dataset* rate, const Dataset* creep,
                          const std::vector<double>& zeros, const std::vector<bool>& usable, double highest,
                          const FitOptions& fit) {
  ArrayDynamics of_runs = find_dynamics(rate, creep, zeros, usable);
  check_found(of_runs, rate, creep);
  if (lowest_level(fitted) != 0.0) return of_runs;
  const CreepMisfit misfit(fitted, zeros, usable, highest, fit);
  ArrayDynamics own = of_runs;
  own.shared = creep_of_one_run(misfit);
  if (creep != nullptr) {
    Dynamics still = of_runs.shared;
    still.lag_share = 0.0;
    const double with_holds = misfit(still), with_own = misfit(own.shared);
    const double least = of_runs.holds > 1 ? std::min(with_own, kClearlyLess * misfit({})) : kClearlyLess * with_own;
    if (with_holds <= least) return of_runs;
    find_creep_scales(*creep, zeros, usable, own);
  }
  if (rate != nullptr) find_lag(*rate, zeros, usable, own);
  return own;
}

// Of a table's recordings.
struct Recorded {
  double step_s = 0.0, longest_s = 0.0, dead = 0.0;
};

// Null: what the fitted run does not tell is left in; both from `recorded`.
SensorModel fit_from(const Dataset& fitted, const Dataset* rate, const Dataset* creep, const DynamicFitOptions& options,
                     const Recorded* recorded = nullptr) {
  std::vector<const Dataset*> others;
  for (const Dataset* const other : {rate, creep})
    if (other != nullptr && other != &fitted) others.push_back(other);
  for (const Dataset* const other : others) check_same_sensor(identity_of(*other), identity_of(fitted));
  HistoriesOptions gathered;
  gathered.threads = options.threads;
  gathered.all_scores = false;
  if (recorded != nullptr) {
    gathered.common.move_to_setpoint = false;
    gathered.dead_v = recorded->dead;
  }
  const Histories before = histories_of(fitted, gathered);
  std::vector<Histories> of_others;
  for (const Dataset* const other : others) of_others.push_back(histories_of(*other, gathered));
  if (!others.empty()) check_lowest(fitted);
  const auto width = static_cast<std::size_t>(fitted.taxels());
  std::vector<bool> usable(width);
  // A taxel that was lost in a later run has the array's lag and creep.
  for (std::size_t t = 0; t < width; ++t)
    usable[t] = before.taxels[t].usable() &&
                std::ranges::all_of(of_others, [t](const Histories& other) { return other.taxels[t].usable(); });
  if (std::ranges::find(usable, true) == usable.end())
    throw AnalysisError("TB-ANALYSIS-NO-TAXEL",
                        fmt::format("no taxel of run {} is usable in it and in all runs of lag and creep", fitted.run),
                        "check the frames: dead, stuck and saturated taxels are left out");
  const std::vector<double> zeros = zeros_of(fitted);
  double highest = 0.0;
  for (const SequenceData& sequence : fitted.sequences)
    for (const Repeat& repeat : sequence.repeats)
      for (const Sample& sample : repeat.steps) highest = std::max(highest, sample.setpoint_psi);
  FitOptions fit;
  fit.model = "preisach";
  fit.identify.cells = std::min(options.cells, intervals_between_levels(fitted));
  fit.identify.by_input = options.by_input;
  fit.identify.linearise = true;
  fit.threads = options.threads;
  fit.common = gathered.common;
  fit.dead_v = gathered.dead_v;
  ArrayDynamics found = recorded != nullptr ? find_dynamics(nullptr, nullptr, zeros, usable)
                                            : dynamics_of(fitted, rate, creep, zeros, usable, highest, fit);
  if (recorded != nullptr) {
    found.shared = dynamics_of_recording(CreepMisfit(fitted, zeros, usable, highest, fit), highest, recorded->step_s,
                                         recorded->longest_s);
    found.lag_share.assign(width, found.shared.lag_share);
  }
  const Dataset undone = dataset_without_dynamics(fitted, found, zeros, highest);
  SensorModel model = fit_array(undone, fit);
  model.model = kDynamicModel;
  model.validity = validity_of_runs(before, of_others);
  model.repeats = repeat_drifts(fitted, model.fitted(), fit.common);
  const auto source = [&](const Dataset* other) {
    return SensorDynamics::Source{other != nullptr && other != &fitted ? other->run : 0, {}};
  };
  model.dynamics = SensorDynamics{found.shared, {}, source(rate), source(creep)};
  for (std::size_t t = 0; t < width; ++t) {
    model.taxels[t].creep_scale = found.creep_scale[t];
    model.taxels[t].lag_share = found.lag_share[t];
  }
  if (model.taxels.size() > width) model.taxels.back().lag_share = found.shared.lag_share;  // the mean taxel
  find_dynamic_residuals(fitted, undone, fit, model);
  return model;
}

}  // namespace

SensorModel fit_dynamic(const Dataset& fitted, const Dataset& rate, const Dataset& creep,
                        const DynamicFitOptions& options) {
  return fit_from(fitted, &rate, &creep, options);
}

SensorModel fit_dynamic_single_run(const Dataset& fitted, const DynamicFitOptions& options) {
  if (lowest_level(fitted) != 0.0) return fit_from(fitted, nullptr, nullptr, options);
  const std::vector<double> zeros(static_cast<std::size_t>(fitted.taxels()), 0.0);
  const ArrayDynamics shown = find_dynamics(&fitted, &fitted, zeros, std::vector<bool>(zeros.size(), true));
  return fit_from(fitted, shown.rate_samples > 0 ? &fitted : nullptr, shown.holds > 0 ? &fitted : nullptr, options);
}

namespace {

// The recordings as repeats of one run, with a rest of `rest_s` before each. Set-points follow the inputs with a play
// of the least turn, so that noise is none.
Dataset dataset_of(const Histories& histories, double rest_s) {
  constexpr double kZero = 0.01;  // of the span: inputs as near to 0 are 0
  Dataset data;
  data.origin = histories.origin;
  data.rows = static_cast<int>(histories.taxels.size());
  data.columns = 1;
  const std::vector<History>& first = histories.taxels.front().fit;
  const double near = kZero * span_of(first, &History::x).length();
  double begun_s = 0.0, before_s = 0.0;
  for (std::size_t h = 0; h < first.size(); ++h) {
    const History& like = first[h];
    SequenceData& sequence = data.sequences.emplace_back();
    sequence.name = like.name;
    Repeat& repeat = sequence.repeats.emplace_back();
    double level = like.x.front();
    for (std::size_t i = 0; i < like.x.size(); ++i) {
      const double half = 0.5 * histories.taxels.front().turn, time_s = begun_s + like.time_s[i] - like.time_s.front();
      level = std::clamp(level, like.x[i] - half, like.x[i] + half);
      repeat.steps.push_back({std::abs(level) <= near ? 0.0 : level, like.x[i], time_s, time_s - before_s});
      before_s = time_s;
      for (const TaxelHistories& taxel : histories.taxels) repeat.volts.push_back(taxel.fit[h].y[i]);
    }
    begun_s = before_s + rest_s;
  }
  for (const TaxelHistories& taxel : histories.taxels) {
    data.noise_v.push_back(taxel.noise);
    data.at_limit.push_back(!taxel.wild.empty());  // left out
  }
  return data;
}

}  // namespace

SensorModel fit_dynamic_table(const Histories& histories, const DynamicFitOptions& options) {
  constexpr double kDead = 1e-6, kRests = 20.0;  // of the outputs' span; of the longest recording
  Histories own = histories;
  if (own.taxels.back().taxel == kMeanTaxel) own.taxels.pop_back();
  const std::vector<History>& first = own.taxels.front().fit;
  for (const TaxelHistories& taxel : own.taxels)
    if (!std::ranges::equal(taxel.fit, first, {}, &History::x, &History::x) ||
        !std::ranges::equal(taxel.fit, first, {}, &History::time_s, &History::time_s))
      throw AnalysisError("TB-ANALYSIS-DYNAMICS", histories.source + ": its taxels have inputs of their own",
                          "fit a table of one taxel, or of taxels in columns beside each other");
  if (std::ranges::none_of(own.taxels, &std::string::empty, &TaxelHistories::wild))
    throw AnalysisError("TB-ANALYSIS-MODEL",
                        fmt::format("{}: the dynamic model cannot be fitted: {}", own.source, own.taxels.front().wild),
                        "correct the line, or leave it out by --skip-bad-rows");
  Recorded recorded;
  std::vector<double> steps;
  for (const History& history : first) {
    recorded.longest_s = std::max(recorded.longest_s, history.time_s.back() - history.time_s.front());
    for (std::size_t i = 1; i < history.time_s.size(); ++i) steps.push_back(history.time_s[i] - history.time_s[i - 1]);
  }
  recorded.step_s = std::max(quantile_of(steps, 0.5), 1e-6 * recorded.longest_s);
  for (const TaxelHistories& taxel : own.taxels)
    recorded.dead = std::max(recorded.dead, kDead * span_of(taxel.fit, &History::y).length());
  const Dataset data = dataset_of(own, kRests * recorded.longest_s);
  if (lowest_level(data) != 0.0)
    throw AnalysisError(
        "TB-ANALYSIS-DYNAMICS", fmt::format("{}: its lowest input is {:g}", own.source, lowest_level(data)),
        "the dynamic model counts inputs from the unloaded sensor: give a table whose inputs begin at 0");
  SensorModel model = fit_from(data, nullptr, nullptr, options, &recorded);
  model.source = own.source;
  model.validity.hold_s.reset();  // how long an input was commanded is not known
  model.run = own.run;
  model.falling = own.falling;
  model.input_unit = own.input_unit;
  model.output_unit = own.output_unit;
  for (std::size_t t = 0; t < own.taxels.size(); ++t) {
    model.taxels[t].taxel = own.taxels[t].taxel;
    if (own.taxels[t].wild.empty()) continue;
    model.taxels[t].status = TaxelStatus::kUnfit;
    model.taxels[t].reason = own.taxels[t].wild;
  }
  return model;
}

bool compensates_creep(const SensorDynamics& dynamics) {
  return std::ranges::any_of(dynamics.shared.creep_share, [](double share) { return share != 0.0; });
}

bool compensates_lag(const SensorDynamics& dynamics) { return dynamics.shared.lag_share != 0.0; }

bool in_time(const SensorDynamics& dynamics) { return undoes(dynamics.shared); }

namespace {

void check_times(const SensorModel& model, const Histories& histories) {
  for (const TaxelHistories& taxel : histories.taxels)
    for (const History& history : taxel.score)
      if (history.time_s.size() != history.x.size())
        throw AnalysisError("TB-MODEL-DYNAMIC",
                            fmt::format("{} tells no times, and without them the dynamic model of {} cannot undo lag "
                                        "and creep",
                                        histories.source, model.source),
                            "give a run, or a table with a column time_s in seconds");
}

void undo(const Dynamics& d, const ModelTaxel& taxel, bool run, std::vector<History>& histories) {
  const HysteresisModel& film = *taxel.fit.model;
  const double x_low = film.x_low(), span = film.x_high() - x_low;
  const double zero = taxel.from_model(film.state()->output_at(x_low));
  DynamicsState state;
  double before = -1.0;
  for (History& history : histories) {
    if (!run) {
      state = {};
      before = -1.0;
    }
    for (std::size_t i = 0; i < history.x.size(); ++i) {
      const double time = history.time_s[i], pressure = history.x[i] - x_low;
      const DynamicsStep step = run ? next_step(d, state, {0.0, 0.0, time, history.held_s[i]}, before, span)
                                    : DynamicsStep(d, before < 0.0 ? 0.0 : std::max(time - before, 0.0));
      const double factor = creep_factor(d, state, step, pressure, taxel.creep_scale);
      history.y[i] = zero + (history.y[i] - zero) / factor;
      history.x[i] = x_low + arrived(taxel.lag_share, state, step, pressure);
      advance(d, state, step, pressure);
      before = time;
    }
  }
}

}  // namespace

Histories histories_without_dynamics(const SensorModel& model, Histories histories) {
  if (!in_time(*model.dynamics)) return histories;
  check_times(model, histories);
  for (TaxelHistories& taxel : histories.taxels) {
    const auto own = std::ranges::find(model.taxels, taxel.taxel, &ModelTaxel::taxel);
    if (own == model.taxels.end() || !own->fitted()) continue;
    undo(model.dynamics->shared, *own, histories.run != 0, taxel.score);
  }
  return histories;
}

}  // namespace tactbench::analysis
