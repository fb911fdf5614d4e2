#include "analysis/identify/dynamic/fit_run_creep.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tactbench::analysis {
namespace {

constexpr double kShareStep = 0.02;                // of a share
constexpr double kMaxCreep = 0.16;                 // of each relaxation time
constexpr double kOfRun = 0.5;                     // a relaxation time that is longer shows no end
constexpr double kCreepHelps = 0.8;                // of the misfit without creep
constexpr double kHalf = 5.0;                      // psi; the misfit hardly depends on it
constexpr double kHalfShare = 1.0 / 12.0;          // the same of another range of inputs
constexpr double kLagStep = 0.05, kMostLag = 0.5;  // of a share

// The array's mean as one taxel.
Dataset mean_taxel_of(const Dataset& data, const std::vector<bool>& usable) {
  Dataset mean = data;
  mean.rows = mean.columns = 1;
  const auto width = static_cast<std::size_t>(data.taxels());
  const auto count = static_cast<double>(std::ranges::count(usable, true));
  mean.noise_v = {0.0};  // no misfit depends on it
  mean.at_limit = {false};
  for (SequenceData& sequence : mean.sequences)
    for (Repeat& repeat : sequence.repeats) {
      std::vector<double> volts(repeat.steps.size(), 0.0);
      for (std::size_t i = 0; i < volts.size(); ++i)
        for (std::size_t t = 0; t < width; ++t) volts[i] += usable[t] ? repeat.volts[i * width + t] / count : 0.0;
      repeat.volts = std::move(volts);
    }
  return mean;
}

Dynamics even_creep(double share, double slowest_s) {
  Dynamics d;
  d.creep_s = creep_times(slowest_s);
  d.creep_share.fill(share);
  d.creep_half = kHalf;
  return d;
}

struct Least {
  double share = 0.0, misfit = std::numeric_limits<double>::infinity();
};

// The misfit falls to its minimum and rises beyond it: found in steps from 0, then by a parabola.
template <class Misfit>
Least least_of(const Misfit& at, double without, double step = kShareStep, double most = kMaxCreep) {
  double before = without, here = without, next = at(step), share = 0.0;
  while (next < here && share + 2.0 * step <= most) {
    share += step;
    before = here;
    here = next;
    next = at(share + step);
  }
  if (next < here) return {share + step, next};
  const bool first = share == 0.0;  // between 0 and one step
  const double width = first ? 0.5 * step : step, centre = first ? width : share;
  if (first) here = at(centre);
  const double bend = before - 2.0 * here + next;
  const double best = bend > 0.0 ? centre + 0.5 * width * (before - next) / bend : centre;
  const double chosen = std::clamp(best, centre - width, centre + width);
  return {chosen, at(chosen)};
}

}  // namespace

CreepMisfit::CreepMisfit(const Dataset& fitted, const std::vector<double>& zero_v, const std::vector<bool>& usable,
                         double highest, const FitOptions& fit)
    : mean_(mean_taxel_of(fitted, usable)), highest_(highest), fit_(fit) {
  fit_.threads = 1;
  double count = 0.0, last_s = 0.0;
  for (std::size_t t = 0; t < zero_v.size(); ++t) {
    if (!usable[t]) continue;
    zero_v_ += zero_v[t];
    count += 1.0;
  }
  zero_v_ /= count;
  for (const SequenceData& sequence : fitted.sequences)
    for (const Repeat& repeat : sequence.repeats) last_s = std::max(last_s, repeat.steps.back().time_s);
  for (const double slowest : {300.0, 1000.0, 3000.0, 10000.0})
    if (slowest <= kOfRun * last_s) slowest_s_.push_back(slowest);
}

double CreepMisfit::operator()(const Dynamics& d) const {
  ArrayDynamics one;
  one.shared = d;
  one.creep_scale = {1.0};
  one.lag_share = {d.lag_share};
  try {
    const SensorModel model = fit_array(dataset_without_dynamics(mean_, one, {zero_v_}, highest_), fit_);
    const ModelFit& own = model.taxels.front().fit;
    if (own.model == nullptr) return std::numeric_limits<double>::infinity();
    return own.j / (own.full_scale * own.full_scale);
  } catch (const AnalysisError&) {
    return std::numeric_limits<double>::infinity();
  }
}

std::array<double, kCreepElements> creep_times(double slowest_s, double fastest_s) {
  std::array<double, kCreepElements> times;
  const double ratio = std::pow(slowest_s / fastest_s, 1.0 / (kCreepElements - 1));
  for (std::size_t j = 0; j < kCreepElements; ++j) times[j] = fastest_s * std::pow(ratio, static_cast<double>(j));
  return times;
}

Dynamics creep_of_one_run(const CreepMisfit& misfit) {
  const double without = misfit(Dynamics());
  Least best;
  double slowest = 0.0;
  for (const double time : misfit.slowest_s()) {
    const Least found = least_of([&](double share) { return misfit(even_creep(share, time)); }, without);
    if (found.misfit >= best.misfit) continue;
    best = found;
    slowest = time;
  }
  return best.misfit < kCreepHelps * without ? even_creep(best.share, slowest) : Dynamics();
}

Dynamics dynamics_of_recording(const CreepMisfit& misfit, double highest, double step_s, double longest_s) {
  constexpr int kRounds = 2;
  constexpr double kFaster = 0.1, kShortest = 10.0;  // of the slowest time; steps
  Dynamics best;
  double least = misfit(best);
  const auto take = [&](const Dynamics& tried, double found) {
    if (found >= kCreepHelps * least) return;
    best = tried;
    least = found;
  };
  for (int round = 0; round < kRounds; ++round) {
    for (double slowest = kOfRun * longest_s; slowest > kShortest * step_s; slowest *= 0.3) {
      const auto with = [&](double share) {
        Dynamics d = best;
        d.creep_s = creep_times(slowest, std::min(kFastest, kFaster * slowest));
        d.creep_share.fill(share);
        d.creep_half = kHalfShare * highest;
        return d;
      };
      Dynamics none = best;
      none.creep_share.fill(0.0);
      const Least found = least_of([&](double share) { return misfit(with(share)); }, misfit(none));
      take(with(found.share), found.misfit);
    }
    for (double lag_s = 0.5 * step_s; lag_s < 0.02 * longest_s; lag_s *= 2.0) {
      const auto with = [&](double share) {
        Dynamics d = best;
        d.lag_s = lag_s;
        d.lag_share = share;
        return d;
      };
      const Least found =
          least_of([&](double share) { return misfit(with(share)); }, misfit(with(0.0)), kLagStep, kMostLag);
      take(with(found.share), found.misfit);
    }
  }
  return best;
}

Dataset dataset_without_dynamics(Dataset data, const ArrayDynamics& dynamics, const std::vector<double>& zero_v,
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
        const double pressure = sample.reference_psi;
        for (std::size_t t = 0; t < width; ++t) {
          double& v = repeat.volts[i * width + t];
          v = zero_v[t] + (v - zero_v[t]) / creep_factor(d, state, step, pressure, dynamics.creep_scale[t]);
        }
        sample.reference_psi = arrived(d.lag_share, state, step, pressure);
        advance(d, state, step, pressure);
        before = sample.time_s;
      }
  return data;
}

Track track_of(const Dataset& data) {
  Track track;
  const auto width = static_cast<std::size_t>(data.taxels());
  for (std::size_t s = 0; s < data.sequences.size(); ++s)
    for (std::size_t r = 0; r < data.sequences[s].repeats.size(); ++r) {
      const Repeat& repeat = data.sequences[s].repeats[r];
      for (std::size_t i = 0; i < repeat.steps.size(); ++i) {
        track.time.push_back(repeat.steps[i].time_s);
        track.pressure.push_back(repeat.steps[i].reference_psi);
        track.samples.push_back(&repeat.steps[i]);
        track.span = std::max(track.span, repeat.steps[i].setpoint_psi);
        track.volts.push_back(&repeat.volts[i * width]);
        track.sequence.push_back(s);
        track.repeat.push_back(r);
        track.step.push_back(i);
      }
    }
  return track;
}

DynamicsStep next_step(const Dynamics& d, DynamicsState& state, const Sample& sample, double before, double span) {
  const TimePassed passed = time_passed(sample, before);
  if (passed.worked_s > 0.0) work_unseen(d, state, passed.worked_s, span);
  return {d, passed.step_s};
}

std::vector<std::array<double, kCreepElements>> walk_creep(const Track& track, const Dynamics& d) {
  std::vector<std::array<double, kCreepElements>> psi;
  DynamicsState state;
  for (std::size_t i = 0; i < track.time.size(); ++i) {
    const DynamicsStep step = next_step(d, state, *track.samples[i], i == 0 ? -1.0 : track.time[i - 1], track.span);
    advance(d, state, step, track.pressure[i]);
    psi.push_back(state.psi);
  }
  return psi;
}

}  // namespace tactbench::analysis
