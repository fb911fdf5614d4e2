#include "analysis/statistics/figures/levels.h"

#include <algorithm>
#include <cmath>

#include "analysis/loop.h"

namespace tactbench::analysis {
namespace {

CompensatedSequence empty_sequence(const SequenceData& data, int taxels) {
  CompensatedSequence sequence;
  sequence.raw = average_repeats(data, taxels);
  const std::size_t steps = sequence.raw.pressure_psi.size();
  sequence.pressure = {sequence.raw.pressure_psi, std::vector<double>(sequence.raw.values.size(), 0.0),
                       sequence.raw.branches};
  sequence.flat = sequence.pressure;
  sequence.unmoved_psi.assign(sequence.raw.values.size(), 0.0);
  sequence.reference_psi.assign(steps, 0.0);
  for (const Repeat& repeat : data.repeats)
    for (std::size_t i = 0; i < steps; ++i)
      sequence.reference_psi[i] += repeat.steps[i].reference_psi / static_cast<double>(data.repeats.size());
  return sequence;
}

void add_error(TaxelErrors& errors, double error, double reference_psi, bool flat) {
  ++errors.frames;
  errors.sum_psi += error;
  if (error > errors.max_psi) {
    errors.max_psi = error;
    errors.max_at_psi = reference_psi;
  }
  if (flat) return;
  ++errors.observable;
  errors.sum_observable_psi += error;
  errors.max_observable_psi = std::max(errors.max_observable_psi, error);
}

}  // namespace

CompensatedStreams compensate_all(const Dataset& dataset, const SensorModel& fit, int threads) {
  const auto width = static_cast<std::size_t>(dataset.taxels());
  CompensatedStreams streams;
  streams.errors.resize(width);
  for (const SequenceData& data : dataset.sequences)
    streams.sequences.push_back(empty_sequence(data, dataset.taxels()));

  compensate_in_order(dataset, fit, threads, [&](std::size_t taxel) {
    return [&, taxel](std::size_t s, std::size_t r, std::size_t i, const Compensated& now) {
      const std::vector<Repeat>& repeats = dataset.sequences[s].repeats;
      CompensatedSequence& sequence = streams.sequences[s];
      const double weight = 1.0 / static_cast<double>(repeats.size());
      const Sample& sample = repeats[r].steps[i];
      const std::size_t at = i * width + taxel;
      sequence.unmoved_psi[at] += weight * now.pressure_psi;
      sequence.pressure.values[at] += weight * (now.pressure_psi + sample.setpoint_psi - sample.reference_psi);
      sequence.flat.values[at] += now.flat ? weight : 0.0;
      add_error(streams.errors[taxel], std::abs(now.pressure_psi - sample.reference_psi), sample.reference_psi,
                now.flat);
    };
  });
  return streams;
}

namespace {

// Over the taxels; one taxel alone has no spread.
double spread_over_taxels(std::span<const double> values) { return values.size() < 2 ? 0.0 : sample_deviation(values); }

}  // namespace

Fitted::Fitted(const SensorModel& fit) : width_(fit.array().size()), taxels_(fit.fitted()) {}

std::vector<double> Fitted::row(const std::vector<double>& table, std::size_t row) const {
  std::vector<double> values;
  values.reserve(taxels_.size());
  for (const std::size_t taxel : taxels_) values.push_back(table[row * width_ + taxel]);
  return values;
}

std::vector<double> Fitted::frame(const std::vector<double>& table, std::size_t row, bool only_fitted) const {
  const auto first = table.begin() + static_cast<std::ptrdiff_t>(row * width_);
  std::vector<double> values(first, first + static_cast<std::ptrdiff_t>(width_));
  if (!only_fitted) return values;
  std::vector<double> fitted(width_, kNan);
  for (const std::size_t taxel : taxels_) fitted[taxel] = values[taxel];
  return fitted;
}

namespace {

// The external loop of one quantity, and of the measured reference as a one-taxel table.
struct Loops {
  ExternalLoop raw, pressure, flat, reference;
};

Loops loops_of(const CompensatedStreams& streams, int taxels) {
  std::vector<TaxelTable> raw, pressure, flat, reference;
  for (const CompensatedSequence& sequence : streams.sequences) {
    raw.push_back(sequence.raw);
    pressure.push_back(sequence.pressure);
    flat.push_back(sequence.flat);
    reference.push_back({sequence.raw.pressure_psi, sequence.reference_psi, sequence.raw.branches});
  }
  return {external_loop(raw, taxels), external_loop(pressure, taxels), external_loop(flat, taxels),
          external_loop(reference, 1)};
}

// Per taxel sums of |up - down| over the levels, all and observable ones.
struct TaxelDistances {
  std::vector<double> sum, observable;
  std::vector<int> observable_levels;
};

LevelFigures level_figures(const Loops& loops, std::size_t level, const Fitted& fitted, double full_v, double full_psi,
                           TaxelDistances& distances) {
  LevelFigures f;
  f.pressure_psi = loops.raw.pressure_psi[level];
  f.up_psi = loops.reference.ascending[level];
  f.down_psi = loops.reference.descending[level];
  f.raw_up_v = fitted.frame(loops.raw.ascending, level, false);
  f.raw_down_v = fitted.frame(loops.raw.descending, level, false);
  f.comp_up_psi = fitted.frame(loops.pressure.ascending, level, true);
  f.comp_down_psi = fitted.frame(loops.pressure.descending, level, true);

  const auto raw_up = fitted.row(loops.raw.ascending, level), raw_down = fitted.row(loops.raw.descending, level);
  const auto up = fitted.row(loops.pressure.ascending, level);
  const auto down = fitted.row(loops.pressure.descending, level);
  const auto flat = fitted.row(loops.flat.descending, level);
  f.raw_std_up = spread_over_taxels(raw_up) / full_v;
  f.raw_std_down = spread_over_taxels(raw_down) / full_v;
  f.comp_std_up = spread_over_taxels(up) / full_psi;
  f.comp_std_down = spread_over_taxels(down) / full_psi;
  f.raw_mean_distance = std::abs(mean_of(raw_up) - mean_of(raw_down)) / full_v;
  f.comp_mean_distance = std::abs(mean_of(up) - mean_of(down)) / full_psi;
  const auto count = static_cast<double>(up.size());
  int observable = 0;
  for (std::size_t i = 0; i < up.size(); ++i) {
    f.raw_distance += std::abs(raw_up[i] - raw_down[i]) / full_v / count;
    const double distance = std::abs(up[i] - down[i]) / full_psi;
    f.comp_distance += distance / count;
    f.worst_taxel_distance = std::max(f.worst_taxel_distance, distance);
    distances.sum[i] += distance;
    if (flat[i] >= 0.5) {  // in at least half of the sweeps
      ++f.flat_taxels;
      continue;
    }
    ++observable;
    ++distances.observable_levels[i];
    distances.observable[i] += distance;
    f.comp_distance_observable += distance;
    f.worst_taxel_distance_observable = std::max(f.worst_taxel_distance_observable, distance);
  }
  if (observable > 0) f.comp_distance_observable /= observable;
  f.made_worse = f.comp_distance > f.raw_distance;
  return f;
}

}  // namespace

void gather_levels(Evaluation& e, const CompensatedStreams& streams, const Fitted& fitted) {
  const Loops loops = loops_of(streams, static_cast<int>(fitted.width()));
  const std::size_t levels = loops.raw.pressure_psi.size();
  e.full_scale_psi = loops.raw.pressure_psi.back();
  e.full_scale_v = 0.0;
  for (std::size_t level = 0; level < levels; ++level)
    for (const auto* table : {&loops.raw.ascending, &loops.raw.descending})
      e.full_scale_v = std::max(e.full_scale_v, std::abs(mean_of(fitted.row(*table, level))));
  const std::size_t taxels = fitted.taxels().size();
  TaxelDistances distances{std::vector<double>(taxels, 0.0), std::vector<double>(taxels, 0.0),
                           std::vector<int>(taxels, 0)};
  double flat = 0.0;
  for (std::size_t level = 0; level < levels; ++level) {
    e.levels.push_back(level_figures(loops, level, fitted, e.full_scale_v, e.full_scale_psi, distances));
    const LevelFigures& f = e.levels.back();
    const auto share = 1.0 / static_cast<double>(levels);
    e.hysteresis_max_fs = std::max(e.hysteresis_max_fs, f.raw_mean_distance);
    e.raw_distance += share * f.raw_mean_distance;
    e.comp_distance_of_mean += share * f.comp_mean_distance;
    e.comp_distance += share * f.comp_distance;
    flat += f.flat_taxels;
  }
  e.hysteresis_mean_fs = e.raw_distance;
  e.flat_share = flat / static_cast<double>(levels * taxels);
  double observable_sum = 0.0;
  int observable_pairs = 0;
  for (std::size_t i = 0; i < taxels; ++i) {
    e.worst_taxel_distance = std::max(e.worst_taxel_distance, distances.sum[i] / static_cast<double>(levels));
    observable_sum += distances.observable[i];
    observable_pairs += distances.observable_levels[i];
    if (distances.observable_levels[i] > 0)
      e.worst_taxel_distance_observable =
          std::max(e.worst_taxel_distance_observable, distances.observable[i] / distances.observable_levels[i]);
  }
  e.comp_distance_observable = observable_pairs > 0 ? observable_sum / observable_pairs : kNan;
}

namespace {

constexpr double kFullBranchShare = 0.01;  // as external_loop

}  // namespace

std::vector<StepKind> step_kinds(const SequenceData& sequence, double low, double high) {
  if (sequence.repeats.empty()) return {};
  std::vector<double> commanded;
  for (const Sample& step : sequence.repeats.front().steps) commanded.push_back(step.setpoint_psi);
  std::vector<StepKind> kinds(commanded.size());
  const double near = kFullBranchShare * (high - low);
  int number = 0;
  for (const Branch& branch : branches_along(commanded)) {
    const auto first = static_cast<std::size_t>(branch.first), last = static_cast<std::size_t>(branch.last);
    const auto [bottom, top] = std::minmax(commanded[first], commanded[last]);
    const bool full = bottom - low <= near && high - top <= near;
    for (std::size_t i = first == 0 ? first : first + 1; i <= last; ++i) kinds[i] = {full, branch.ascending, number};
    ++number;
  }
  return kinds;
}

}  // namespace tactbench::analysis
