#include "tests/benchmarks/study/specimen.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "analysis/algebra/dense.h"
#include "analysis/statistics/numbers/moments.h"
#include "tests/benchmarks/study/specimen_walk.h"

namespace tactbench::bench {

namespace {

using analysis::mean_of;

constexpr std::size_t kRuns = 8;

struct SquareMean {
  double sum = 0.0;
  double count = 0.0;
  void add(double value) {
    sum += value * value;
    count += 1.0;
  }
  [[nodiscard]] double root() const { return count > 0.0 ? std::sqrt(sum / count) : 0.0; }
};

void add_to(std::vector<double>& sum, const std::vector<double>& values, double share) {
  sum.resize(values.size(), 0.0);
  for (std::size_t i = 0; i < values.size(); ++i) sum[i] += share * values[i];
}

// Outputs at both ends of low-high, cycled twice, after the way to `entry`.
std::pair<std::vector<double>, std::vector<double>> ends_of(const SpecimenOptions& options, double entry, double low,
                                                            double high) {
  SpecimenWalk walk(options);
  walk.condition_at_once();
  walk.at_once({entry, low, high, low});
  const std::vector<double> bottom = walk.output();
  walk.at_once({high});
  return {bottom, walk.output()};
}

SpecimenOptions of_run(SpecimenOptions options, std::size_t run) {
  options.seed += run;
  return options;
}

// Output behind the divider: conductance in units of its reference.
double linearised(double volts, double amplitude) {
  return std::isinf(amplitude) ? volts : volts * amplitude / (amplitude - volts);
}

}  // namespace

LoopFigures measure_loop(const SpecimenOptions& options) {
  SpecimenWalk walk(options);
  walk.condition();
  const auto loop = walk.loop();
  LoopFigures figures;
  const double bottom = mean_of(loop.front());
  figures.full_scale_v = mean_of(loop[kLevels - 1]) - bottom;
  for (std::size_t level = 0; level < kLevels; ++level) {
    const double gap = mean_of(loop[2 * kLevels - 2 - level]) - mean_of(loop[level]);
    figures.max_percent_fs = std::max(figures.max_percent_fs, 100.0 * gap / figures.full_scale_v);
    figures.mean_percent_fs += 100.0 * gap / figures.full_scale_v / kLevels;
  }
  return figures;
}

CycleFigures measure_cycles(const SpecimenOptions& options, int cycles) {
  SpecimenWalk walk(options);
  walk.condition();
  auto before = walk.loop();
  std::vector<double> span = before[kLevels - 1];
  for (std::size_t i = 0; i < span.size(); ++i) span[i] -= before[0][i];
  SquareMean taxels, mean_taxel;
  for (int cycle = 1; cycle < cycles; ++cycle) {
    auto now = walk.loop();
    for (std::size_t step = 0; step < now.size(); ++step) {
      mean_taxel.add((mean_of(now[step]) - mean_of(before[step])) / mean_of(span));
      for (std::size_t i = 0; i < span.size(); ++i) taxels.add((now[step][i] - before[step][i]) / span[i]);
    }
    before = std::move(now);
  }
  return {100.0 * taxels.root() / std::sqrt(2.0), 100.0 * mean_taxel.root() / std::sqrt(2.0)};
}

double measure_creep_percent_fs(const SpecimenOptions& options, double level_psi, double from_s, double to_s) {
  const double full_scale = measure_loop(options).full_scale_v;
  SpecimenWalk walk(options);
  walk.condition();
  walk.hold(30000.0);
  walk.jump(level_psi);
  walk.hold(from_s);
  const double early = mean_of(walk.output());
  walk.hold(to_s - from_s);
  return 100.0 * (mean_of(walk.output()) - early) / full_scale;
}

double measure_remanence_percent_fs(const SpecimenOptions& options, double after_s) {
  const double full_scale = measure_loop(options).full_scale_v;
  SpecimenWalk walk(options);
  const double start = mean_of(walk.output());
  walk.condition();
  walk.hold(after_s);
  return 100.0 * (mean_of(walk.output()) - start) / full_scale;
}

WalkFigures measure_walk(const SpecimenOptions& options, int hours) {
  SpecimenWalk unloaded(options), loaded(options), other(of_run(options, 1));
  loaded.jump(40.0);
  other.jump(40.0);
  SquareMean zero, gain;
  std::vector<double> zero_before, ratio_before;
  for (int hour = 0; hour <= hours; ++hour) {
    for (SpecimenWalk* walk : {&unloaded, &loaded, &other}) walk->hold(3600.0);
    const std::vector<double> volts = unloaded.output(), a = loaded.output(), b = other.output();
    std::vector<double> ratio(a.size());
    for (std::size_t i = 0; i < a.size(); ++i) ratio[i] = a[i] / b[i];
    for (std::size_t i = 0; hour > 0 && i < volts.size(); ++i) {
      zero.add(volts[i] - zero_before[i]);
      gain.add(ratio[i] - ratio_before[i]);
    }
    zero_before = volts;
    ratio_before = ratio;
  }
  return {1000.0 * zero.root(), 100.0 * gain.root() / std::sqrt(2.0)};
}

CrosstalkFigures measure_crosstalk(const SpecimenOptions& options) {
  CrosstalkFigures figures;
  double pressed = 0.0;
  for (int row = 2; row + 2 < options.rows; row += 3) {
    for (int column = 2; column + 2 < options.columns; column += 3, pressed += 1.0) {
      const auto at = static_cast<std::size_t>(row * options.columns + column);
      SpecimenWalk walk(options);
      const std::vector<double> before = walk.output();
      std::vector<double> contact(before.size(), 0.0);
      contact[at] = 40.0;
      walk.press(contact);
      const std::vector<double> after = walk.output();
      const auto share = [&](std::size_t taxel) { return (after[taxel] - before[taxel]) / (after[at] - before[at]); };
      const auto line = static_cast<std::size_t>(options.columns);
      figures.beside += (share(at - 1) + share(at + 1) + share(at - line) + share(at + line)) / 4.0;
      figures.corner +=
          (share(at - line - 1) + share(at - line + 1) + share(at + line - 1) + share(at + line + 1)) / 4.0;
      figures.two_away += (share(at - 2) + share(at + 2) + share(at - 2 * line) + share(at + 2 * line)) / 4.0;
    }
  }
  for (double* figure : {&figures.beside, &figures.corner, &figures.two_away}) *figure /= std::max(pressed, 1.0);
  return figures;
}

double height_difference(std::span<const MinorLoop> loops, double bottom, double top) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  double least = kNone;
  for (const double amplitude : {kNone, 40.0, 20.0, 12.0, 9.0, 7.5, 6.5, 6.0, 5.5}) {
    SquareMean differences;
    const auto u = [&](double volts) { return linearised(volts, amplitude); };
    for (const MinorLoop& loop : loops)
      differences.add(
          (u(loop.high_from_below) - u(loop.low_from_below) - u(loop.high_from_above) + u(loop.low_from_above)) /
          (u(top) - u(bottom)));
    if (amplitude > 1.02 * top) least = std::min(least, differences.root());
  }
  return least;
}

MemoryFigures measure_memory(const SpecimenOptions& options) {
  constexpr std::array<std::pair<double, double>, 4> kRanges = {{{10, 20}, {20, 30}, {30, 40}, {20, 40}}};
  std::array<std::vector<MinorLoop>, kRanges.size()> loops;  // by taxel
  std::vector<double> bottom, top, not_closed;
  for (std::size_t run = 0; run < kRuns; ++run) {
    const SpecimenOptions of = of_run(options, run);
    const double share = 1.0 / static_cast<double>(kRuns);
    for (std::size_t r = 0; r < kRanges.size(); ++r) {
      const auto [low, high] = kRanges[r];
      const auto below = ends_of(of, 0.0, low, high), above = ends_of(of, kTopPsi, low, high);
      loops[r].resize(below.first.size());
      for (std::size_t i = 0; i < loops[r].size(); ++i) {
        loops[r][i].low_from_below += share * below.first[i];
        loops[r][i].high_from_below += share * below.second[i];
        loops[r][i].low_from_above += share * above.first[i];
        loops[r][i].high_from_above += share * above.second[i];
      }
    }
    SpecimenWalk walk(of);
    walk.condition_at_once();
    add_to(bottom, walk.output(), share);
    walk.at_once({30.0});
    add_to(not_closed, walk.output(), -share);
    walk.at_once({20.0, 30.0});
    add_to(not_closed, walk.output(), share);
    walk.at_once({kTopPsi});
    add_to(top, walk.output(), share);
  }
  SquareMean congruency, closure;
  for (std::size_t i = 0; i < top.size(); ++i) {
    closure.add(not_closed[i] / (top[i] - bottom[i]));
    std::vector<MinorLoop> own;
    for (const std::vector<MinorLoop>& of_all : loops) own.push_back(of_all[i]);
    congruency.add(height_difference(own, bottom[i], top[i]));
  }
  return {100.0 * congruency.root(), 100.0 * closure.root()};
}

double measure_shape_percent_fs(const SpecimenOptions& options, int components) {
  SpecimenWalk walk(options);
  walk.condition();
  const auto loop = walk.loop();
  const auto taxels = static_cast<Eigen::Index>(loop.front().size()), steps = static_cast<Eigen::Index>(loop.size());
  Eigen::MatrixXd shapes(taxels, steps);
  for (Eigen::Index i = 0; i < taxels; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const double zero = loop.front()[at], span = loop[kLevels - 1][at] - zero;
    for (Eigen::Index s = 0; s < steps; ++s) shapes(i, s) = (loop[static_cast<std::size_t>(s)][at] - zero) / span;
  }
  shapes.rowwise() -= shapes.colwise().mean().eval();
  const Eigen::MatrixXd covariance = analysis::gram_of(shapes) / static_cast<double>(taxels);
  const Eigen::VectorXd variances = analysis::eigen_of(covariance).values;
  const Eigen::Index left = std::max<Eigen::Index>(0, steps - components);
  return 100.0 * std::sqrt(std::max(0.0, variances.head(left).sum()) / static_cast<double>(steps));
}

std::vector<Figure> benchmark_specimen(const std::vector<SpecimenKind>& kinds) {
  FigureList figures("specimen");
  for (const SpecimenKind kind : kinds) {
    SpecimenOptions options;
    options.kind = kind;
    PlantOptions plant;
    plant.specimen = options;
    const auto add = [&](const char* name, double value, const char* unit) {
      figures.add(keyword_of(kind) + "_" + name, value, unit);
    };
    const LoopFigures loop = measure_loop(options);
    add("hysteresis_max", loop.max_percent_fs, "%FS");
    add("hysteresis_mean", loop.mean_percent_fs, "%FS");
    add("full_scale", loop.full_scale_v, "V");
    const CycleFigures cycles = measure_cycles(options, 50);
    add("remanence_after_10_s", measure_remanence_percent_fs(options, 10.0), "%FS");
    add("remanence_after_an_hour", measure_remanence_percent_fs(options, 3600.0), "%FS");
    add("cycle_to_cycle_taxel", cycles.taxel_percent_fs, "%FS");
    add("cycle_to_cycle_mean_taxel", cycles.mean_taxel_percent_fs, "%FS");
    add("creep_1_to_10_s", measure_creep_percent_fs(options, 40.0, 1.0, 10.0), "%FS");
    add("creep_100_to_1000_s", measure_creep_percent_fs(options, 40.0, 100.0, 1000.0), "%FS");
    const WalkFigures walk = measure_walk(options, 24);
    add("zero_drift_in_an_hour", walk.zero_mv, "mV");
    add("gain_drift_in_an_hour", walk.gain_percent, "%");
    const CrosstalkFigures crosstalk = measure_crosstalk(options);
    add("crosstalk_adjacent", 100.0 * crosstalk.beside, "%");
    add("crosstalk_diagonal", 100.0 * crosstalk.corner, "%");
    const MemoryFigures memory = measure_memory(options);
    add("minor_loop_congruency_error", memory.congruency_percent_fs, "%FS");
    add("minor_loop_closure_error", memory.closure_percent_fs, "%FS");
    add("shape_residual_after_five_components", measure_shape_percent_fs(options, 5), "%FS");
    const NoiseFigures noise = measure_noise(plant);
    add("white_noise", noise.white_mv, "mV");
    add("kurtosis", noise.kurtosis, "1");
    add("outliers_beyond_five_sigma", 1e6 * noise.beyond_five, "ppm");
    add("slow_noise", noise.slow_percent_of_output, "%");
    add("noise_slope", noise.slope, "1");
  }
  return figures.take();
}

}  // namespace tactbench::bench
