#include "analysis/statistics/scoring/score.h"

#include <algorithm>
#include <cmath>

#include "analysis/compensate/compensator.h"

namespace tactbench::analysis {
namespace {

constexpr double kAtRest = 0.01;  // of the input's span

// 0.1, 0.2, 0.5, 1, ...: a value belongs to the bin whose lower bound is the greatest not above it.
Bin bin_of(double value) {
  const double decade = std::pow(10.0, std::floor(std::log10(value)));
  constexpr double kBinSteps[] = {1.0, 2.0, 5.0, 10.0};
  std::size_t i = 2;
  while (i > 0 && value < kBinSteps[i] * decade * (1.0 - 1e-6)) --i;
  return {kBinSteps[i] * decade, kBinSteps[i + 1] * decade, {}};
}

void add_to(std::vector<Bin>& bins, const Bin& bin) {
  const auto place = std::ranges::lower_bound(bins, 0.99 * bin.low, {}, &Bin::low);
  if (place != bins.end() && place->low < 1.01 * bin.low)
    place->error.add(bin.error);
  else
    bins.insert(place, bin);
}

void add_error(std::vector<Bin>& bins, double value, double error) {
  if (!(value > 0.0)) return;
  Bin bin = bin_of(value);
  bin.error.add(error);
  add_to(bins, bin);
}

}  // namespace

void ErrorSum::add(double error) {
  sum += error;
  max = std::max(max, error);
  ++samples;
}

void ErrorSum::add(const ErrorSum& other) {
  sum += other.sum;
  max = std::max(max, other.max);
  samples += other.samples;
}

void Score::add(const Score& other) {
  direct.add(other.direct);
  free_running.add(other.free_running);
  compensated.add(other.compensated);
  raw.add(other.raw);
  for (const Bin& bin : other.by_hold) add_to(by_hold, bin);
  for (const Bin& bin : other.by_rate) add_to(by_rate, bin);
}

void Score::add_sample(double error, double hold_s, double rate) {
  compensated.add(error);
  add_error(by_hold, hold_s, error);
  add_error(by_rate, rate, error);
}

Score score(const HysteresisModel& model, std::span<const History> histories, const ScoreOptions& options) {
  Score score;
  const double per_output = (options.x_high - options.x_low) / (options.y_high - options.y_low);
  const double near_low = options.x_low + kAtRest * (options.x_high - options.x_low);
  CompensatorSetup setup;
  setup.noise = options.noise;
  const auto inverse = make_compensator(model, setup);
  for (const History& history : histories) {
    const std::vector<double> predicted = predict_history(model, history, false);
    const std::vector<double> running = predict_history(model, history, true);
    inverse->start(history.x.empty() || history.x.front() <= near_low ? Start::kAtRest : Start::kUnknown);
    std::vector<double> estimates;
    for (const double y : history.y) estimates.push_back(inverse->step(y, 0.0).pressure_psi);
    for (const Branch& branch : history.branches) {
      for (auto i = static_cast<std::size_t>(branch.first) + 1; i <= static_cast<std::size_t>(branch.last); ++i) {
        const double off = std::abs(estimates[i] - history.x[i]);
        score.direct.add(std::abs(predicted[i] - history.y[i]));
        score.free_running.add(std::abs(running[i] - history.y[i]));
        score.compensated.add(off);
        score.raw.add(std::abs(options.x_low + (history.y[i] - options.y_low) * per_output - history.x[i]));
        if (history.time_s.empty()) continue;
        add_error(score.by_hold, history.held_s[i], off);
        const double passed = history.time_s[i] - history.time_s[i - 1];
        if (passed > 0.0) add_error(score.by_rate, std::abs(history.x[i] - history.x[i - 1]) / passed, off);
      }
    }
  }
  return score;
}

}  // namespace tactbench::analysis
