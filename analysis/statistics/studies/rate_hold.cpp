#include <algorithm>
#include <cmath>

#include "analysis/statistics/figures/evaluation.h"
#include "analysis/statistics/figures/levels.h"
#include "analysis/statistics/figures/same_sensor.h"
#include "analysis/statistics/studies/studies.h"

namespace tactbench::analysis {
namespace {

constexpr double kSamePace = 1.2;  // repeats whose durations differ by a smaller factor have the same pace

double length_s(const Repeat& repeat) { return repeat.steps.back().time_s - repeat.steps.front().time_s; }

// Mean output of the fitted taxels in a frame.
double mean_output(const Repeat& repeat, std::size_t step, const Fitted& fitted) {
  return mean_of(fitted.row(repeat.volts, step));
}

void compare_paces(const SequenceData& sequence, const Fitted& fitted, double full_scale_v, RateHoldRun& out) {
  const auto slowest = std::ranges::max_element(sequence.repeats, {}, length_s);
  double sum = 0.0;
  int samples = 0;
  for (const Repeat& repeat : sequence.repeats) {
    if (&repeat == &*slowest || length_s(repeat) * kSamePace > length_s(*slowest)) continue;
    for (std::size_t i = 0; i < repeat.steps.size(); ++i) {
      const double off = std::abs(mean_output(repeat, i, fitted) - mean_output(*slowest, i, fitted)) / full_scale_v;
      out.output_max_share = std::max(out.output_max_share, off);
      sum += off;
      ++samples;
    }
  }
  if (samples > 0) out.output_mean_share = sum / samples;
}

}  // namespace

std::vector<RateHoldRun> rate_hold_of(const Dataset& measured, const SensorModel& fit, int threads) {
  check_same_sensor(measured, fit);
  const Dataset dataset = as_modelled(measured, fit);
  const Fitted fitted(fit);
  const std::size_t width = fitted.width();
  // Scores of each taxel and sequence, added up afterwards in the taxels' order.
  std::vector<std::vector<Score>> scores(width, std::vector<Score>(dataset.sequences.size()));
  compensate_in_order(dataset, fit, threads, [&](std::size_t taxel) {
    return [&, taxel](std::size_t s, std::size_t r, std::size_t i, const Compensated& compensated) {
      const std::vector<Sample>& steps = dataset.sequences[s].repeats[r].steps;
      const Sample& now = steps[i];
      const double off = std::abs(compensated.pressure_psi - now.reference_psi);
      const double passed = i > 0 ? now.time_s - steps[i - 1].time_s : 0.0;
      const double rate = passed > 0.0 ? std::abs(now.reference_psi - steps[i - 1].reference_psi) / passed : 0.0;
      // A level that is held has no rate but noise.
      const bool moved = i > 0 && now.setpoint_psi != steps[i - 1].setpoint_psi;
      scores[taxel][s].add_sample(off, now.held_s, moved ? rate : 0.0);
    };
  });
  std::vector<RateHoldRun> runs;
  for (std::size_t s = 0; s < dataset.sequences.size(); ++s) {
    Score sum;
    for (const std::vector<Score>& own : scores) sum.add(own[s]);
    RateHoldRun run{dataset.run, dataset.sequences[s].name, sum.compensated, sum.by_hold, sum.by_rate, 0.0, 0.0};
    compare_paces(dataset.sequences[s], fitted, fit.full_scale_v(), run);
    runs.push_back(std::move(run));
  }
  return runs;
}

}  // namespace tactbench::analysis
