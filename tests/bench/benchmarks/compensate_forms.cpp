// `benchmark compensate`: all forms that it compares read the same pressures, and its figures are worked out by hand
// from round numbers.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "bench/benchmarks/compensate.h"

using namespace tactbench;
using namespace tactbench::bench;

namespace {

using CompensateLines = std::vector<std::string>;

// The first `frames` of a stream.
CompensationCase beginning_of(const CompensationCase& whole, std::size_t frames) { return tiled(whole, 1, frames); }

float farthest_from(double psi, const std::vector<float>& pressures) {
  float farthest = 0.0F;
  for (const float pressure : pressures) farthest = std::max(farthest, std::abs(pressure - static_cast<float>(psi)));
  return farthest;
}

}  // namespace

TEST_CASE("benchmark compensate: the fast, the plain and the bare form read the pressures of slow cycles") {
  constexpr std::size_t kTaxels = 6, kFrames = 400;
  const CompensationCase whole = slow_cycles(kTaxels, kFrames);
  // 0-60-10-50-0 psi in 400 frames; the last of 50, 151, 251 and 351 frames, in the middle of each leg.
  const std::vector<std::pair<std::size_t, double>> courses = {{51, 30.0}, {151, 35.0}, {251, 30.0}, {351, 25.0}};
  for (const auto& [frames, psi] : courses) {
    INFO(frames << " frames, " << psi << " psi");
    const CompensationCase c = beginning_of(whole, frames);
    StreamedResults fast(kTaxels), plain(kTaxels), bare(kTaxels);
    analysis::FrameCompensator<float> compensator(c.setup);
    CHECK(fast_seconds(1, c, compensator, fast) > 0.0);
    CHECK(plain_seconds(1, c, plain) > 0.0);
    CHECK(bare_seconds(1, c, bare) > 0.0);
    CHECK(farthest_from(psi, fast.pressure) < 1.0F);
    CHECK(farthest_from(psi, plain.pressure) < 1.0F);
    CHECK(farthest_from(psi, bare.pressure) < 1.0F);
    for (std::size_t t = 0; t < kTaxels; ++t) {
      INFO("taxel " << t);
      CHECK(plain.pressure[t] == Approx(fast.pressure[t]).margin(1e-3));
      // Taxels of the case are uncertain by 0.5 psi beside their noise, of which the plain form knows nothing.
      const double both = std::hypot(0.5, plain.uncertainty[t]);
      CHECK(fast.uncertainty[t] == Approx(both).epsilon(0.15));
      CHECK(plain.uncertainty[t] > 0.05F);
      CHECK(plain.status[t] == fast.status[t]);
      CHECK(bare.uncertainty[t] == 0.0F);
      CHECK(bare.status[t] == 0);
    }
  }
}

TEST_CASE("benchmark compensate: the bare form turns where the output falls behind by more than six times the noise") {
  // One taxel, up to 30 psi, then down by a little.
  CompensationCase c = slow_cycles(1, 4);
  const analysis::ElamModel& model = c.models.front();
  const analysis::ElamCurve up(model, true, model.x0(), model.y0());
  const double volt = 65536.0 / 5.0, noise_v = 0.004;
  const auto counts_of_volts = [&](double volts) { return static_cast<std::uint16_t>(std::lround(volts * volt)); };
  const double top = up.output(30.0);
  const auto read = [&](const std::vector<double>& volts) {
    c.counts.clear();
    for (const double one : volts) c.counts.push_back(counts_of_volts(one));
    c.frames = volts.size();
    StreamedResults results(1);
    (void)bare_seconds(1, c, results);
    return static_cast<double>(results.pressure[0]);
  };
  CHECK(read({up.output(15.0), top}) == Approx(30.0).margin(0.01));
  // Within the dead band the branch stays, and is read backwards.
  CHECK(read({top, top - 5.9 * noise_v}) == Approx(up.input(top - 5.9 * noise_v)).margin(0.01));
  // Beyond it another branch begins at the highest output, even where the outputs before lay below it.
  const auto turned_at = [&](double turn_v, double volts) {
    return analysis::ElamCurve(model, false, up.input(turn_v), turn_v).input(volts);
  };
  CHECK(read({top, top - 6.1 * noise_v}) == Approx(turned_at(top, top - 6.1 * noise_v)).margin(0.02));
  CHECK(read({top, top - 2.0 * noise_v, top - 7.0 * noise_v}) ==
        Approx(turned_at(top, top - 7.0 * noise_v)).margin(0.02));
  CHECK(std::abs(turned_at(top, top - 6.1 * noise_v) - up.input(top - 6.1 * noise_v)) > 0.1);
  // And back up again from its lowest output.
  const double low = top - 100.0 * noise_v, low_psi = turned_at(top, low);
  const double again = analysis::ElamCurve(model, true, low_psi, low).input(low + 20.0 * noise_v);
  CHECK(read({top, low + 50.0 * noise_v, low, low + 3.0 * noise_v, low + 20.0 * noise_v}) ==
        Approx(again).margin(0.05));
  CHECK(read({top, low, low + 5.9 * noise_v}) == Approx(turned_at(top, low + 5.9 * noise_v)).margin(0.02));
}

TEST_CASE("benchmark compensate: scaling alone writes thousandths of the counts") {
  const CompensationCase c = random_frames(3, 2);
  StreamedResults results(3);
  CHECK(scale_seconds(1, c, results) >= 0.0);
  for (std::size_t t = 0; t < 3; ++t) CHECK(results.pressure[t] == Approx(c.counts[3 + t] / 1000.0).epsilon(1e-6));
}

TEST_CASE("benchmark compensate: median, 99th of a hundred and the worst of frames' times") {
  std::vector<double> taken;
  for (int i = 0; i <= 100; ++i) taken.push_back(100 - i);
  const Latency latency = latency_of(taken);
  CHECK(latency.median_us == 50.0);
  CHECK(latency.p99_us == 99.0);
  CHECK(latency.worst_us == 100.0);
}

TEST_CASE("benchmark compensate: microseconds a frame, nanoseconds a taxel and ratios from round numbers") {
  CompensateTimes times;
  times.slow_frames = 2000;
  times.random_frames = 100;
  times.scale = 0.004;
  times.plain = 0.12;
  times.bare = 0.08;
  times.fast = {{"base", 0.02}, {"avx2", 0.01}};
  times.fast_latency = {5.0, 6.0, 7.0};
  times.turn = 0.0009;
  times.plain_turn = 0.0036;
  times.bare_turn = 0.0006;
  times.turn_latency = {8.0, 9.5, 10.5};
  times.unknown_start_us = 11.5;
  times.growth = {{16, 256e-8}, {32, 2048e-8}, {64, 12288e-8}};
  CompensateLines lines;
  for (const Figure& figure : figures_of(times))
    lines.push_back(fmt::format("{} {:.7g} {}", figure.name, figure.value, figure.unit));
  CHECK(lines == CompensateLines{"compensate_scale_only 2 us/frame",
                                 "compensate_straightforward 60 us/frame",
                                 "compensate_bare_scalar 40 us/frame",
                                 "compensate_fast_base 10 us/frame",
                                 "compensate_fast_avx2 5 us/frame",
                                 "compensate_fast_median 5 us",
                                 "compensate_fast_p99 6 us",
                                 "compensate_fast_worst 7 us",
                                 "compensate_turning_fast 9 us/frame",
                                 "compensate_turning_straightforward 36 us/frame",
                                 "compensate_turning_bare_scalar 6 us/frame",
                                 "compensate_turning_p99 9.5 us",
                                 "compensate_turning_worst 10.5 us",
                                 "compensate_unknown_start_median 11.5 us",
                                 "compensate_growth_16x16_per_taxel 10 ns",
                                 "compensate_growth_32x32_per_taxel 20 ns",
                                 "compensate_growth_64x64_per_taxel 30 ns",
                                 "compensate_speedup 12 x",
                                 "compensate_speedup_over_bare 8 x",
                                 "compensate_speedup_over_bare_goal_at_least 3 x",
                                 "compensate_over_scale_only 2.5 x",
                                 "compensate_over_scale_only_goal_at_most 25 x",
                                 "compensate_turning_slowdown 0.25 x",
                                 "compensate_turning_slowdown_over_bare 1.5 x",
                                 "compensate_turning_slowdown_over_bare_goal_at_most 2.5 x"});
}

TEST_CASE("benchmark compensate: on small arrays it measures every form, each level of the processor and each size") {
  std::string names;
  for (const Figure& figure : benchmark_compensate(1, {4, 1100, 10, 3})) {
    INFO(figure.name);
    CHECK(figure.value > 0.0);
    if (figure.name.find("_avx") == std::string::npos) names += figure.name.substr(11) + " ";
  }
  CHECK(names ==
        "scale_only straightforward bare_scalar fast_base fast_median fast_p99 fast_worst turning_fast "
        "turning_straightforward turning_bare_scalar turning_p99 turning_worst unknown_start_median "
        "growth_16x16_per_taxel growth_32x32_per_taxel growth_64x64_per_taxel speedup speedup_over_bare "
        "speedup_over_bare_goal_at_least over_scale_only over_scale_only_goal_at_most turning_slowdown "
        "turning_slowdown_over_bare turning_slowdown_over_bare_goal_at_most ");
}
