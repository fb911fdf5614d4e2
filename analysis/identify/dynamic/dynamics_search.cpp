#include "analysis/identify/dynamic/dynamics_search.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>

#include "analysis/algebra/dense.h"
#include "analysis/compensate/compensator.h"
#include "analysis/identify/rivals/nnls.h"
#include "analysis/statistics/numbers/moments.h"

namespace tactbench::analysis {
namespace {

constexpr double kHeldPsi = 0.5;  // a level is held while the reference stays within this of its first sample
constexpr std::size_t kHeldSamples = 10;
constexpr double kLagSettles = 6.0;  // seconds of a hold that the lag may still be in

std::vector<double> mean_above_zero(const Track& track, const std::vector<double>& zero_v,
                                    const std::vector<bool>& usable) {
  std::vector<double> mean;
  for (const double* const row : track.volts) {
    double sum = 0.0, count = 0.0;
    for (std::size_t t = 0; t < zero_v.size(); ++t)
      if (usable[t]) {
        sum += row[t] - zero_v[t];
        count += 1.0;
      }
    mean.push_back(sum / count);
  }
  return mean;
}

struct Hold {
  std::size_t first, last;  // settled samples
};

std::vector<Hold> holds_of(const Track& track) {
  std::vector<Hold> holds;
  for (std::size_t i = 0; i < track.time.size();) {
    std::size_t end = i + 1;
    while (end < track.time.size() && std::abs(track.pressure[end] - track.pressure[i]) < kHeldPsi) ++end;
    std::size_t first = i;
    while (first < end && track.time[first] < track.time[i] + kLagSettles) ++first;
    if (end >= first + kHeldSamples && track.pressure[i] > kHeldPsi) holds.push_back({first, end - 1});
    i = end;
  }
  return holds;
}

struct CreepRows {
  Eigen::MatrixXd columns;  // a row a sample: psi less the hold's mean, times the hold's mean output
  Eigen::VectorXd scale;    // that mean output
};

CreepRows creep_rows(const Track& track, const std::vector<Hold>& holds, const Dynamics& d) {
  const auto psi = walk_creep(track, d);
  Eigen::Index count = 0;
  for (const Hold& hold : holds) count += static_cast<Eigen::Index>(hold.last - hold.first + 1);
  CreepRows rows{Eigen::MatrixXd(count, kCreepElements), {}};
  Eigen::Index row = 0;
  for (const Hold& hold : holds)
    for (std::size_t j = 0; j < kCreepElements; ++j) {
      double mean = 0.0;
      const auto length = hold.last - hold.first + 1;
      for (std::size_t i = hold.first; i <= hold.last; ++i) mean += psi[i][j] / static_cast<double>(length);
      for (std::size_t i = hold.first; i <= hold.last; ++i)
        rows.columns(row + static_cast<Eigen::Index>(i - hold.first), static_cast<Eigen::Index>(j)) = psi[i][j] - mean;
      if (j + 1 == kCreepElements) row += static_cast<Eigen::Index>(length);
    }
  return rows;
}

// Outputs less the hold's mean, and that mean, row by row.
void relative(const std::vector<Hold>& holds, const std::vector<double>& above, Eigen::VectorXd& off,
              Eigen::VectorXd& mean_of) {
  Eigen::Index row = 0;
  for (const Hold& hold : holds) {
    double mean = 0.0;
    for (std::size_t i = hold.first; i <= hold.last; ++i)
      mean += above[i] / static_cast<double>(hold.last - hold.first + 1);
    for (std::size_t i = hold.first; i <= hold.last; ++i, ++row) {
      off[row] = above[i] - mean;
      mean_of[row] = mean;
    }
  }
}

// The mean output of a hold is the static one times its mean factor.
double mean_factor(const Track& track, const std::vector<Hold>& holds, const Dynamics& d) {
  const auto psi = walk_creep(track, d);
  double factor = 0.0, count = 0.0;
  for (const Hold& hold : holds)
    for (std::size_t i = hold.first; i <= hold.last; ++i) {
      double sum = 1.0;
      for (std::size_t j = 0; j < kCreepElements; ++j) sum += d.creep_share[j] * (psi[i][j] - 1.0);
      factor += sum;
      count += 1.0;
    }
  return factor / count;
}

// Each taxel's creep over the median taxel's; `shape`: a row a sample, the array's relative change within its hold.
void find_scales(const Track& track, const std::vector<Hold>& holds, const Eigen::VectorXd& shape,
                 const std::vector<double>& zero_v, const std::vector<bool>& usable, ArrayDynamics& result) {
  const std::array<double, kCreepElements>& share = result.shared.creep_share;
  const double total = share[0] + share[1] + share[2];
  const double most = total > 0.0 ? std::min(kMaxCreepScale, kMaxCreep / total) : kMaxCreepScale;
  Eigen::VectorXd off(shape.size()), level(shape.size());
  struct Scale {
    std::size_t taxel;
    double scale, doubt2;
  };
  std::vector<Scale> scales;
  for (std::size_t t = 0; t < zero_v.size(); ++t) {
    if (!usable[t]) continue;
    std::vector<double> above;
    for (const double* const row : track.volts) above.push_back(row[t] - zero_v[t]);
    relative(holds, above, off, level);
    const Eigen::VectorXd column = level.cwiseProduct(shape);
    if (column.squaredNorm() <= 0.0) continue;
    const double scale = column.dot(off) / column.squaredNorm();
    scales.push_back(
        {t, scale, (off - scale * column).squaredNorm() / static_cast<double>(off.size()) / column.squaredNorm()});
  }
  std::vector<double> all;
  for (const Scale& own : scales) all.push_back(own.scale);
  const double median = median_of(all);
  if (!(median > 0.0)) return;
  for (const Scale& own : scales) {
    constexpr double kSpread2 = 0.25 * 0.25;  // of taxels, as far as is known before
    const double scale = own.scale / median, doubt2 = own.doubt2 / (median * median);
    result.creep_scale[own.taxel] = std::clamp(1.0 + (scale - 1.0) * kSpread2 / (kSpread2 + doubt2), 0.0, most);
  }
}

}  // namespace

void find_creep(const Dataset& data, const std::vector<double>& zero_v, const std::vector<bool>& usable,
                ArrayDynamics& result) {
  const Track track = track_of(data);
  const std::vector<Hold> holds = holds_of(track);
  result.holds = static_cast<int>(holds.size());
  if (holds.empty()) return;
  const std::vector<double> mean = mean_above_zero(track, zero_v, usable);
  double least = std::numeric_limits<double>::infinity();
  Eigen::VectorXd off, level;
  Eigen::MatrixXd best_columns;
  Eigen::VectorXd share_found = Eigen::VectorXd::Zero(kCreepElements);
  for (double half = 1.0; half <= 64.0; half *= 1.2) {
    Dynamics d = result.shared;
    d.creep_half = half;
    const CreepRows rows = creep_rows(track, holds, d);
    off.resize(rows.columns.rows());
    level.resize(rows.columns.rows());
    relative(holds, mean, off, level);
    const Eigen::MatrixXd columns = level.asDiagonal() * rows.columns;
    const Eigen::VectorXd share = non_negative_least_squares(gram_of(columns), columns.transpose() * off);
    const double rest = (off - columns * share).squaredNorm();
    if (rest >= least) continue;
    least = rest;
    best_columns = rows.columns;
    share_found = share;
    result.shared.creep_half = half;
    for (std::size_t j = 0; j < kCreepElements; ++j) result.shared.creep_share[j] = share[static_cast<Eigen::Index>(j)];
  }
  const double factor = mean_factor(track, holds, result.shared);
  for (double& k : result.shared.creep_share) k *= factor;
  find_scales(track, holds, best_columns * share_found, zero_v, usable, result);
}

void find_creep_scales(const Dataset& data, const std::vector<double>& zero_v, const std::vector<bool>& usable,
                       ArrayDynamics& result) {
  const Track track = track_of(data);
  const std::vector<Hold> holds = holds_of(track);
  if (holds.empty()) return;
  const Eigen::Map<const Eigen::Vector3d> share(result.shared.creep_share.data());
  const Eigen::VectorXd shape = creep_rows(track, holds, result.shared).columns * share;
  find_scales(track, holds, shape / mean_factor(track, holds, result.shared), zero_v, usable, result);
}

ArrayDynamics find_dynamics(const Dataset* rate, const Dataset* creep, const std::vector<double>& zero_v,
                            const std::vector<bool>& usable) {
  ArrayDynamics result;
  result.creep_scale.assign(zero_v.size(), 1.0);
  result.lag_share.assign(zero_v.size(), 0.0);
  if (creep != nullptr) find_creep(*creep, zero_v, usable, result);
  if (rate != nullptr) find_lag(*rate, zero_v, usable, result);
  return result;
}

namespace {

struct LagRow {
  double slope, still;     // dV/dp, and what is still to come, of the fast repeat less the slow one
  std::size_t fast, slow;  // samples
};

}  // namespace

// The outputs, creep undone, of two repeats at the same step differ by slope * (difference of what has arrived).
void find_lag(const Dataset& data, const std::vector<double>& zero_v, const std::vector<bool>& usable,
              ArrayDynamics& result) {
  const Track track = track_of(data);
  const auto width = zero_v.size();
  const auto psi = walk_creep(track, result.shared);
  // Pairs of samples of the same step in the fastest and the slowest repeat of a sequence.
  std::vector<LagRow> rows;
  std::size_t begin = 0;
  for (const SequenceData& sequence : data.sequences) {
    if (sequence.repeats.empty()) continue;
    const std::size_t length = sequence.repeats.front().steps.size();
    std::size_t fast = 0, slow = 0;
    const auto lasts = [&](std::size_t r) {
      const std::vector<Sample>& steps = sequence.repeats[r].steps;
      return steps.back().time_s - steps.front().time_s;
    };
    for (std::size_t r = 0; r < sequence.repeats.size(); ++r) {
      if (lasts(r) < lasts(fast)) fast = r;
      if (lasts(r) > lasts(slow)) slow = r;
    }
    if (lasts(slow) > 2.0 * lasts(fast))
      for (std::size_t i = 1; i + 1 < length; ++i)
        rows.push_back({0.0, 0.0, begin + fast * length + i, begin + slow * length + i});
    begin += sequence.repeats.size() * length;
  }
  // A turn has no slope.
  std::erase_if(rows, [&](const LagRow& row) {
    return (track.pressure[row.slow + 1] - track.pressure[row.slow]) *
               (track.pressure[row.slow] - track.pressure[row.slow - 1]) <=
           0.0;
  });
  result.rate_samples = static_cast<int>(rows.size());
  if (rows.empty()) return;
  const auto undone = [&](std::size_t taxel, std::size_t i) {
    double factor = 1.0;
    for (std::size_t j = 0; j < kCreepElements; ++j)
      factor += result.creep_scale[taxel] * result.shared.creep_share[j] * (psi[i][j] - 1.0);
    return (track.volts[i][taxel] - zero_v[taxel]) / factor;
  };
  const auto still_to_come = [&](double lag_s) {
    Dynamics d;
    d.lag_s = lag_s;
    DynamicsState state;
    std::vector<double> still;
    for (std::size_t i = 0; i < track.time.size(); ++i) {
      const DynamicsStep step = next_step(d, state, *track.samples[i], i == 0 ? -1.0 : track.time[i - 1], track.span);
      advance(d, state, step, track.pressure[i]);
      still.push_back(state.late - track.pressure[i]);
    }
    return still;
  };
  struct Share {
    double share, doubt2, rest;
  };
  const auto share_of = [&](const std::vector<double>& output, const std::vector<double>& still) {
    double xx = 0.0, xy = 0.0, yy = 0.0;
    for (const LagRow& row : rows) {
      const double slope =
          (output[row.slow + 1] - output[row.slow - 1]) / (track.pressure[row.slow + 1] - track.pressure[row.slow - 1]);
      const double x = slope * (still[row.fast] - still[row.slow]);
      const double y =
          output[row.fast] - output[row.slow] - slope * (track.pressure[row.fast] - track.pressure[row.slow]);
      xx += x * x;
      xy += x * y;
      yy += y * y;
    }
    if (xx <= 0.0) return Share{0.0, std::numeric_limits<double>::infinity(), yy};
    const double share = xy / xx, rest = yy - share * xy;
    return Share{share, rest / static_cast<double>(rows.size()) / xx, rest};
  };
  std::vector<std::vector<double>> outputs(width);
  std::vector<double> mean(track.time.size(), 0.0);
  double count = 0.0;
  for (std::size_t t = 0; t < width; ++t) {
    if (!usable[t]) continue;
    count += 1.0;
    for (std::size_t i = 0; i < track.time.size(); ++i) outputs[t].push_back(undone(t, i));
    for (std::size_t i = 0; i < mean.size(); ++i) mean[i] += outputs[t][i];
  }
  for (double& at : mean) at /= count;
  double least = std::numeric_limits<double>::infinity();
  for (double lag_s = 0.1; lag_s <= 12.0; lag_s *= 1.1) {
    const Share share = share_of(mean, still_to_come(lag_s));
    if (share.rest >= least || share.share <= 0.0) continue;
    least = share.rest;
    result.shared.lag_s = lag_s;
    result.shared.lag_share = std::min(share.share, 0.5);
  }
  const std::vector<double> still = still_to_come(result.shared.lag_s);
  for (std::size_t t = 0; t < width; ++t) {
    result.lag_share[t] = result.shared.lag_share;
    // Where the array has none, neither has a taxel.
    if (!usable[t] || result.shared.lag_share == 0.0) continue;
    const Share own = share_of(outputs[t], still);
    const double spread2 = std::pow(0.3 * result.shared.lag_share, 2);
    result.lag_share[t] = std::clamp(
        result.shared.lag_share + (own.share - result.shared.lag_share) * spread2 / (spread2 + own.doubt2), 0.0, 0.5);
  }
}

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
