#include "bench/benchmarks/array.h"

#include <algorithm>
#include <cmath>

#include "bench/config/config.h"
#include "bench/rig/rig.h"
#include "bench/simulation/plant.h"

namespace tactbench::bench {

namespace {

double median_scan_us(int scans) {
  Rig rig(read_bench(find_config("simulated.toml"), {}));
  rig.open();
  return median_microseconds(scans, [&] { (void)rig.array().read(1); });
}

}  // namespace

double benchmarked_pressure(std::size_t frame) {
  return 30.0 - 30.0 * std::cos(6.2831853 * static_cast<double>(frame) / 200.0);
}

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

std::vector<Figure> benchmark_array(int rounds, const ArraySizes& sizes) {
  ArrayTimes times;
  PlainArray plain;
  times.plain_s =
      sum_of_best_seconds(rounds, sizes.frames, [&](std::size_t f) { plain.frame(benchmarked_pressure(f)); });
  Specimen specimen({});
  const SpecimenOptions& shape = specimen.options();
  const auto rows = static_cast<std::size_t>(shape.rows), columns = static_cast<std::size_t>(shape.columns);
  std::vector<double> volts(rows * columns);
  times.specimen_s = sum_of_best_seconds(rounds, sizes.frames, [&](std::size_t f) {
    specimen.advance(benchmarked_pressure(f), 0.01);
    specimen.output(volts);
  });
  // The same plant behind the scanner: it asks while time stands still, and counts with noise come out.
  const devices::TurnedClock clock;
  Plant plant({}, clock);
  std::vector<std::uint16_t> counts(volts.size());
  std::vector<std::uint8_t> status(rows);
  times.counts_s = sum_of_best_seconds(rounds, sizes.frames, [&](std::size_t) { plant.scan(counts, status); });
  times.wire_us = median_scan_us(sizes.scans);
  return figures_of(times, sizes);
}

std::vector<Figure> figures_of(const ArrayTimes& times, const ArraySizes& sizes) {
  const double per_frame = 1e6 / static_cast<double>(sizes.frames), scan = per_frame * times.counts_s;
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
