#include "bench/benchmarks/array.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "analysis/statistics/numbers/moments.h"
#include "bench/config/config.h"
#include "bench/rig/rig.h"
#include "bench/simulation/plant.h"

namespace tactbench::bench {

namespace {

constexpr std::size_t kArrayTaxels = 256, kRows = 16;
constexpr int kScored = 1000, kScans = 501;

double median_scan_us() {
  Rig rig(read_bench(find_config("simulated.toml"), {}));
  rig.open();
  std::vector<double> taken;
  for (int i = 0; i < kScans; ++i) {
    const auto start = std::chrono::steady_clock::now();
    (void)rig.array().read(1);
    taken.push_back(std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count());
  }
  return analysis::quantile_of(std::move(taken), 0.5);
}

}  // namespace

double benchmarked_pressure(int frame) { return 30.0 - 30.0 * std::cos(6.2831853 * frame / 200.0); }

void PlainArray::frame(double pressure_psi) {
  for (std::size_t t = 0; t < counts_.size(); ++t) {
    double sum = 0.0, width = 0.0;
    for (double& play : plays_[t]) {
      play = std::clamp(play, pressure_psi - width, pressure_psi);
      sum += play;
      width += 1.0;
    }
    const double volts = 5e-3 * sum + 0.0015 * normal_(random_);
    counts_[t] = static_cast<std::uint16_t>(std::clamp(std::lround(volts / (5.0 / 65535.0)), 0L, 65535L));
  }
  keep(counts_);
}

std::vector<Figure> benchmark_array(int rounds) {
  Specimen specimen({});
  PlainArray plain;
  std::vector<double> volts(kArrayTaxels);
  // The same plant behind the scanner: it asks while time stands still, and counts with noise come out.
  const devices::TurnedClock clock;
  Plant plant({}, clock);
  std::vector<std::uint16_t> counts(kArrayTaxels);
  std::vector<std::uint8_t> status(kRows);
  const std::vector<double> taken = best_seconds(rounds, {[&] {
                                                            for (int i = 0; i < kScored; ++i)
                                                              plain.frame(benchmarked_pressure(i));
                                                          },
                                                          [&] {
                                                            for (int i = 0; i < kScored; ++i) {
                                                              specimen.advance(benchmarked_pressure(i), 0.01);
                                                              specimen.output(volts);
                                                            }
                                                          },
                                                          [&] {
                                                            for (int i = 0; i < kScored; ++i)
                                                              plant.scan(counts, status);
                                                          }});
  return figures_of(ArrayTimes{taken[0], taken[1], taken[2], median_scan_us()});
}

std::vector<Figure> figures_of(const ArrayTimes& times) {
  const double per_frame = 1e6 / kScored, scan = per_frame * times.counts_s;
  FigureList figures("array");
  figures.add("plain_plays", per_frame * times.plain_s, "us/frame");
  figures.add("specimen_moved_and_read", per_frame * times.specimen_s, "us/frame");
  figures.add("specimen_over_plain_plays", times.specimen_s / times.plain_s, "x");
  figures.add("counts_with_noise", scan, "us/frame");
  figures.add("frame_on_the_wire", times.wire_us, "us");
  figures.add("share_of_the_wire", scan / times.wire_us, "1");
  return figures.take();
}

}  // namespace tactbench::bench
