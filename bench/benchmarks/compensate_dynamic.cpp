#include "bench/benchmarks/compensate_dynamic.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "analysis/compensate/dynamic_frame_compensator.h"
#include "analysis/compensate/everett.h"
#include "analysis/models/preisach.h"
#include "bench/benchmarks/compensate.h"

namespace tactbench::bench {

namespace {

using namespace analysis;

constexpr double kDynamicNoise = 0.004, kDynamicVoltsPerCount = 5.0 / 65536.0;

DynamicCase dynamic_case(std::vector<PreisachModel>& films, std::size_t taxels) {
  DynamicCase c;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform;
  constexpr std::size_t n = 20;
  c.setup.x_high = 60.0;
  c.setup.intervals = n;
  c.setup.volts_per_count = kDynamicVoltsPerCount;
  c.setup.start_unknown = false;
  c.setup.dynamics.creep_share = {0.015, 0.012, 0.01};
  for (std::size_t t = 0; t < taxels; ++t) {
    std::vector<double> weights;
    double sum = 0.0;
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j <= i; ++j) {
        weights.push_back((0.2 + uniform(random)) * std::exp(-8.0 * static_cast<double>(i - j) / n));
        sum += weights.back();
      }
    for (double& weight : weights) weight *= 20.0 / sum;
    films.emplace_back(0.0, 60.0, 0.0, weights);
    DynamicTaxel taxel;
    taxel.usable = true;
    taxel.divider = {0.02, 1.0 / (3.9 + 0.3 * uniform(random))};
    for (std::size_t i = 0; i <= n; ++i)
      for (std::size_t j = 0; j <= i; ++j)
        taxel.everett.push_back(
            films.back().everett(60.0 * static_cast<double>(i) / n, 60.0 * static_cast<double>(j) / n));
    taxel.lag_share = 0.07;
    taxel.noise_v = kDynamicNoise;
    c.setup.taxels.push_back(std::move(taxel));
  }
  return c;
}

}  // namespace

DynamicCase slow_dynamic(std::size_t taxels, std::size_t frames) {
  std::vector<PreisachModel> films;
  DynamicCase c = dynamic_case(films, taxels);
  c.frames = frames;
  std::vector<std::unique_ptr<ModelState>> states;
  for (const PreisachModel& film : films) states.push_back(film.state());
  std::mt19937 random(7);
  std::normal_distribution<double> normal(0.0, kDynamicNoise);
  const double turns[] = {0.0, 60.0, 10.0, 50.0, 0.0, 0.0};
  for (std::size_t f = 0; f < frames; ++f) {
    const double phase = 4.0 * static_cast<double>(f) / static_cast<double>(frames);
    const auto leg = static_cast<std::size_t>(phase);
    const double x = turns[leg] + (turns[leg + 1] - turns[leg]) * (phase - static_cast<double>(leg));
    for (std::size_t t = 0; t < films.size(); ++t) {
      states[t]->go(x);
      const double volts = c.setup.taxels[t].divider.output(states[t]->output_at(x)) + normal(random);
      c.counts.push_back(
          static_cast<std::uint16_t>(std::clamp(std::lround(volts / kDynamicVoltsPerCount), 0L, 65535L)));
    }
  }
  return c;
}

DynamicCase random_dynamic(std::size_t taxels, std::size_t frames) {
  std::vector<PreisachModel> films;
  DynamicCase c = dynamic_case(films, taxels);
  c.frames = frames;
  std::mt19937 random(9);
  std::uniform_real_distribution<double> uniform;
  for (std::size_t f = 0; f < frames; ++f)
    for (std::size_t t = 0; t < films.size(); ++t)
      c.counts.push_back(static_cast<std::uint16_t>(3.2 * uniform(random) / kDynamicVoltsPerCount));
  return c;
}

namespace {

template <class Compensator>
double seconds_of(int rounds, Compensator& compensator, const std::vector<std::uint16_t>& counts, std::size_t frames) {
  const std::size_t taxels = counts.size() / frames;
  std::vector<float> pressure(taxels), uncertainty(taxels);
  std::vector<std::uint16_t> status(taxels);
  return sum_of_best_seconds(rounds, frames, [&](std::size_t f) {
    compensator.frame(std::span(counts).subspan(f * taxels, taxels), {pressure, uncertainty, status});
  });
}

}  // namespace

std::vector<Figure> benchmark_compensate_dynamic(int rounds, const CompensateDynamicSizes& sizes) {
  const DynamicCase slow = slow_dynamic(sizes.taxels, sizes.slow_frames),
                    random = random_dynamic(sizes.taxels, sizes.random_frames);
  const CompensationCase elam_slow = slow_cycles(sizes.taxels, sizes.slow_frames),
                         elam_random = random_frames(sizes.taxels, sizes.random_frames);
  CompensateDynamicTimes times;
  times.slow_frames = slow.frames;
  times.random_frames = random.frames;
  for (const Dispatch level : {Dispatch::kBase, Dispatch::kAvx2, Dispatch::kAvx512}) {
    if (level > best_dispatch()) continue;
    DynamicFrameCompensator<float> still(slow.setup), turning(random.setup);
    FrameCompensator<float> elam_still(elam_slow.setup), elam_turning(elam_random.setup);
    for (DynamicFrameCompensator<float>* const c : {&still, &turning}) {
      c->set_dispatch(level);
      c->set_interval(0.01);
    }
    elam_still.set_dispatch(level);
    elam_turning.set_dispatch(level);
    DynamicLevelTimes own;
    own.level = to_string(level);
    own.slow = seconds_of(rounds, still, slow.counts, slow.frames);
    own.turning = seconds_of(rounds, turning, random.counts, random.frames);
    own.slow_elam = seconds_of(rounds, elam_still, elam_slow.counts, elam_slow.frames);
    own.turning_elam = seconds_of(rounds, elam_turning, elam_random.counts, elam_random.frames);
    times.levels.push_back(own);
  }
  times.bytes_per_taxel = DynamicFrameCompensator<float>(slow.setup).bytes_per_taxel();
  return figures_of(times);
}

std::vector<Figure> figures_of(const CompensateDynamicTimes& times) {
  FigureList figures("compensate-dynamic");
  const double per_slow = 1e6 / static_cast<double>(times.slow_frames),
               per_random = 1e6 / static_cast<double>(times.random_frames);
  for (const DynamicLevelTimes& own : times.levels) {
    if (own.level == "avx2") {
      figures.add_at_most("slow_avx2", per_slow * own.slow, 2.0, "us/frame");
      figures.add_at_most("turning_avx2", per_random * own.turning, 12.0, "us/frame");
    } else {
      figures.add("slow_" + own.level, per_slow * own.slow, "us/frame");
      figures.add("turning_" + own.level, per_random * own.turning, "us/frame");
    }
    figures.add("slow_elam_" + own.level, per_slow * own.slow_elam, "us/frame");
    figures.add("turning_elam_" + own.level, per_random * own.turning_elam, "us/frame");
  }
  figures.add_at_most("memory_a_taxel", static_cast<double>(times.bytes_per_taxel), 2048.0, "bytes");
  return figures.take();
}

}  // namespace tactbench::bench
