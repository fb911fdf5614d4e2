#include "bench/benchmarks/compensate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "analysis/compensate/compensator.h"
#include "analysis/statistics/numbers/moments.h"
#include "bench/benchmarks/synthetic_array.h"

namespace tactbench::bench {

namespace {

using namespace analysis;

constexpr double kStreamedVoltsPerCount = 5.0 / 65536.0, kStreamedNoise = 0.004;

CompensationCase case_of(std::size_t taxels) {
  CompensationCase result;
  std::mt19937 random(5);
  result.setup.volts_per_count = kStreamedVoltsPerCount;
  result.setup.start_unknown = false;
  for (std::size_t i = 0; i < taxels; ++i) {
    const ElamModel model = taxel_like_the_paper(random);
    const auto x = model.ascending.x(), up = model.ascending.y(), down = model.descending.y();
    result.setup.pressure_psi.assign(x.begin(), x.end());
    result.setup.taxels.push_back({true,
                                   {up.begin(), up.end()},
                                   {down.begin(), down.end()},
                                   model.parameters,
                                   kStreamedNoise,
                                   false,
                                   std::vector<double>(40, 0.5)});
    result.models.push_back(model);
  }
  return result;
}

std::uint16_t counts_of(double volts) {
  return static_cast<std::uint16_t>(std::clamp(std::lround(volts / kStreamedVoltsPerCount), 0L, 65535L));
}

// Of a compensator: makes frame `f` of a case.
auto frames_by(FrameCompensator<float>& fast, const CompensationCase& c, StreamedResults& results) {
  return [&](std::size_t f) {
    const std::size_t width = c.models.size();
    fast.frame(std::span<const std::uint16_t>(c.counts).subspan(f * width, width),
               {results.pressure, results.uncertainty, results.status});
  };
}

Latency latency(const CompensationCase& c, FrameCompensator<float>& fast, StreamedResults& results) {
  return latency_of(microseconds_of_each(c.frames, frames_by(fast, c, results)));
}

}  // namespace

double fast_seconds(int rounds, const CompensationCase& c, FrameCompensator<float>& fast, StreamedResults& results) {
  return sum_of_best_seconds(rounds, c.frames, frames_by(fast, c, results));
}

double plain_seconds(int rounds, const CompensationCase& c, StreamedResults& results) {
  std::vector<TaxelCompensator> plain;
  CompensatorOptions options;
  options.noise_v = kStreamedNoise;
  for (const ElamModel& model : c.models) plain.emplace_back(model, options);
  const std::size_t width = c.models.size();
  return sum_of_best_seconds(rounds, c.frames, [&](std::size_t f) {
    for (std::size_t t = 0; t < width; ++t) {
      const Compensated now = plain[t].step(c.counts[f * width + t] * kStreamedVoltsPerCount);
      results.pressure[t] = static_cast<float>(now.pressure_psi);
      results.uncertainty[t] = static_cast<float>(now.uncertainty_psi);
      results.status[t] = now.flat ? 3 : 1;
    }
  });
}

double bare_seconds(int rounds, const CompensationCase& c, StreamedResults& results) {
  struct Bare {
    ElamCurve curve;
    double extreme;
  };
  std::vector<Bare> bare;
  for (const ElamModel& model : c.models) bare.push_back({{model, true, model.x0(), model.y0()}, model.y0()});
  const std::size_t width = c.models.size();
  return sum_of_best_seconds(rounds, c.frames, [&](std::size_t f) {
    for (std::size_t t = 0; t < width; ++t) {
      Bare& b = bare[t];
      const double volts = c.counts[f * width + t] * kStreamedVoltsPerCount;
      const double ahead = b.curve.ascending() ? volts - b.extreme : b.extreme - volts;
      if (ahead >= 0.0) {
        b.extreme = volts;
      } else if (ahead < -6.0 * kStreamedNoise) {
        b.curve = ElamCurve(c.models[t], !b.curve.ascending(), b.curve.input(b.extreme), b.extreme);
        b.extreme = volts;
      }
      results.pressure[t] = static_cast<float>(b.curve.input(volts));
    }
  });
}

double scale_seconds(int rounds, const CompensationCase& c, StreamedResults& results) {
  const std::size_t width = c.models.size();
  return sum_of_best_seconds(rounds, c.frames, [&](std::size_t f) {
    const std::uint16_t* const counts = c.counts.data() + f * width;
    float* const to = results.pressure.data();
    for (std::size_t t = 0; t < width; ++t) to[t] = static_cast<float>(counts[t]) * 1e-3F;
    keep(*to);  // each frame is written
  });
}

CompensationCase slow_cycles(std::size_t taxels, std::size_t frames) {
  CompensationCase c = case_of(taxels);
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const double turns[] = {0.0, 60.0, 10.0, 50.0, 0.0};
  c.frames = frames;
  c.counts.resize(frames * taxels);
  std::vector<ElamCurve> curves;
  for (const ElamModel& model : c.models) curves.emplace_back(model, true, model.x0(), model.y0());
  std::size_t leg = 0;
  for (std::size_t f = 0; f < frames; ++f) {
    const double phase = 4.0 * static_cast<double>(f) / static_cast<double>(frames);
    const auto now = static_cast<std::size_t>(phase);
    if (now != leg) {
      leg = now;
      for (std::size_t t = 0; t < taxels; ++t)
        curves[t] = ElamCurve(c.models[t], !curves[t].ascending(), turns[leg], curves[t].output(turns[leg]));
    }
    const double x = turns[leg] + (turns[leg + 1] - turns[leg]) * (phase - static_cast<double>(leg));
    for (std::size_t t = 0; t < taxels; ++t)
      c.counts[f * taxels + t] = counts_of(curves[t].output(x) + kStreamedNoise * normal(random));
  }
  return c;
}

CompensationCase random_frames(std::size_t taxels, std::size_t frames) {
  CompensationCase c = case_of(taxels);
  std::mt19937 random(9);
  c.frames = frames;
  std::uniform_real_distribution<double> uniform;
  for (std::size_t f = 0; f < frames; ++f)
    for (const ElamModel& model : c.models)
      c.counts.push_back(counts_of(model.y0() + (model.yu() - model.y0()) * uniform(random)));
  return c;
}

CompensationCase tiled(const CompensationCase& from, std::size_t times, std::size_t frames) {
  CompensationCase c = from;
  c.frames = frames;
  c.counts.clear();
  c.setup.taxels.clear();
  c.models.clear();
  for (std::size_t i = 0; i < times; ++i) {
    c.setup.taxels.insert(c.setup.taxels.end(), from.setup.taxels.begin(), from.setup.taxels.end());
    c.models.insert(c.models.end(), from.models.begin(), from.models.end());
  }
  for (std::size_t f = 0; f < frames; ++f)
    for (std::size_t i = 0; i < times; ++i)
      for (std::size_t t = 0; t < from.models.size(); ++t) c.counts.push_back(from.counts[f * from.models.size() + t]);
  return c;
}

Latency latency_of(const std::vector<double>& taken_us) {
  return {quantile_of(taken_us, 0.5), quantile_of(taken_us, 0.99), quantile_of(taken_us, 1.0)};
}

std::vector<Figure> benchmark_compensate(int rounds, const CompensateSizes& sizes) {
  const std::size_t taxels = sizes.taxels;
  StreamedResults results(taxels);
  const CompensationCase slow = slow_cycles(taxels, sizes.slow_frames),
                         random = random_frames(taxels, sizes.random_frames);
  CompensateTimes times;
  times.slow_frames = slow.frames;
  times.random_frames = random.frames;
  times.scale = scale_seconds(rounds, slow, results);
  times.plain = plain_seconds(rounds, slow, results);
  times.bare = bare_seconds(rounds, slow, results);
  for (const Dispatch dispatch : {Dispatch::kBase, Dispatch::kAvx2, Dispatch::kAvx512}) {
    if (dispatch > best_dispatch()) continue;
    FrameCompensator<float> compensator(slow.setup);
    compensator.set_dispatch(dispatch);
    times.fast.emplace_back(to_string(dispatch), fast_seconds(rounds, slow, compensator, results));
  }
  FrameCompensator<float> compensator(slow.setup);
  times.fast_latency = latency(slow, compensator, results);
  FrameCompensator<float> turning(random.setup);
  times.turn = fast_seconds(rounds, random, turning, results);
  times.plain_turn = plain_seconds(rounds, random, results);
  times.bare_turn = bare_seconds(rounds, random, results);
  times.turn_latency = latency(random, turning, results);
  FrameSetup unknown = slow.setup;
  unknown.start_unknown = true;
  FrameCompensator<float> starting(unknown);
  CompensationCase middle = slow;
  middle.frames = sizes.middle_frames;
  middle.counts.erase(middle.counts.begin(),
                      middle.counts.begin() + static_cast<std::ptrdiff_t>(slow.frames / 20 * taxels));
  times.unknown_start_us = latency(middle, starting, results).median_us;
  for (const std::size_t side : {std::size_t{16}, std::size_t{32}, std::size_t{64}}) {
    const CompensationCase large = tiled(slow, side * side / taxels, sizes.growth_frames);
    FrameCompensator<float> many(large.setup);
    StreamedResults all(side * side);
    times.growth.emplace_back(side, fast_seconds(rounds, large, many, all) / static_cast<double>(large.frames));
  }
  return figures_of(times);
}

// The plain form computes uncertainty and flags too; the bare one is the simplest form.
std::vector<Figure> figures_of(const CompensateTimes& times) {
  FigureList figures("compensate");
  const double per_slow = 1e6 / static_cast<double>(times.slow_frames),
               per_random = 1e6 / static_cast<double>(times.random_frames);
  figures.add("scale_only", per_slow * times.scale, "us/frame");
  figures.add("straightforward", per_slow * times.plain, "us/frame");
  figures.add("bare_scalar", per_slow * times.bare, "us/frame");
  for (const auto& [level, seconds] : times.fast) figures.add("fast_" + level, per_slow * seconds, "us/frame");
  figures.add("fast_median", times.fast_latency.median_us, "us");
  figures.add("fast_p99", times.fast_latency.p99_us, "us");
  figures.add("fast_worst", times.fast_latency.worst_us, "us");
  figures.add("turning_fast", per_random * times.turn, "us/frame");
  figures.add("turning_straightforward", per_random * times.plain_turn, "us/frame");
  figures.add("turning_bare_scalar", per_random * times.bare_turn, "us/frame");
  figures.add("turning_p99", times.turn_latency.p99_us, "us");
  figures.add("turning_worst", times.turn_latency.worst_us, "us");
  figures.add("unknown_start_median", times.unknown_start_us, "us");
  for (const auto& [side, seconds] : times.growth)
    figures.add(fmt::format("growth_{0}x{0}_per_taxel", side), 1e9 * seconds / static_cast<double>(side * side), "ns");
  const double fast = times.fast.back().second;
  figures.add("speedup", times.plain / fast, "x");
  figures.add_at_least("speedup_over_bare", times.bare / fast, 3.0);
  figures.add_at_most("over_scale_only", fast / times.scale, 25.0);
  figures.add("turning_slowdown", times.turn / times.plain_turn, "x");
  figures.add_at_most("turning_slowdown_over_bare", times.turn / times.bare_turn, 2.5);
  return figures.take();
}

}  // namespace tactbench::bench
