// Noise of the simulated scanner and film, from scans of a plant against its true noise.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "bench/simulation/plant.h"
#include "devices/clock.h"
#include "tests/benchmarks/study/specimen.h"

namespace tactbench::bench {

namespace {

using namespace std::chrono_literals;

constexpr int kUnloadedScans = 400, kSeconds = 2048, kMeanOver = 32;

// Scan minus truth in volts, by taxel.
std::vector<double> noise_of(Plant& plant, const PlantOptions& options, std::vector<double>& truth) {
  truth = plant.true_output();
  std::vector<std::uint16_t> counts(truth.size());
  std::vector<std::uint8_t> status(static_cast<std::size_t>(options.specimen.rows));
  plant.scan(counts, status);
  std::vector<double> noise(truth.size());
  for (std::size_t i = 0; i < noise.size(); ++i) noise[i] = counts[i] * options.scanner.volts_per_count - truth[i];
  return noise;
}

// Power of `values` under a Hann window at `cycles` over its length.
double power_at(const std::vector<double>& values, int cycles) {
  double real = 0.0, imaginary = 0.0;
  const double angle = 2.0 * std::numbers::pi / static_cast<double>(values.size());
  for (std::size_t k = 0; k < values.size(); ++k) {
    const double windowed = values[k] * (1.0 - std::cos(angle * static_cast<double>(k)));
    real += windowed * std::cos(angle * cycles * static_cast<double>(k));
    imaginary += windowed * std::sin(angle * cycles * static_cast<double>(k));
  }
  return real * real + imaginary * imaginary;
}

// Slope of log power over log frequency, by octaves from 2 to 63 cycles.
double slope_of(const std::vector<std::vector<double>>& series) {
  double n = 0.0, sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
  for (int low = 2; low < 64; low *= 2) {
    double power = 0.0;
    for (const std::vector<double>& values : series)
      for (int cycles = low; cycles < 2 * low; ++cycles) power += power_at(values, cycles) / low;
    const double x = std::log(low * std::numbers::sqrt2), y = std::log(power);
    n += 1.0;
    sx += x;
    sy += y;
    sxx += x * x;
    sxy += x * y;
  }
  return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

void measure_unloaded(Plant& plant, const PlantOptions& options, NoiseFigures& figures) {
  std::vector<double> truth, samples;
  for (int scan = 0; scan < kUnloadedScans; ++scan) {
    const std::vector<double> noise = noise_of(plant, options, truth);
    samples.insert(samples.end(), noise.begin(), noise.end());
  }
  double second = 0.0, fourth = 0.0;
  for (const double value : samples) {
    second += value * value;
    fourth += value * value * value * value;
  }
  const auto count = static_cast<double>(samples.size());
  const double deviation = std::sqrt(second / count);
  figures.white_mv = 1000.0 * deviation;
  figures.kurtosis = count * fourth / (second * second);
  figures.beyond_five =
      static_cast<double>(std::ranges::count_if(samples, [&](double v) { return std::abs(v) > 5.0 * deviation; })) /
      count;
}

}  // namespace

NoiseFigures measure_noise(const PlantOptions& options) {
  constexpr std::size_t kTaxels = 32;
  devices::ManualClock clock;
  Plant plant(options, clock);
  NoiseFigures figures;
  measure_unloaded(plant, options, figures);
  plant.drive(devices::Volts(40.0 / options.chamber.span_psi * 10.0), devices::Nanoseconds::max(), devices::Volts(0.0));
  clock.wait_until(60s);
  std::vector<std::vector<double>> series(kTaxels);
  double means = 0.0, count = 0.0;
  std::vector<double> truth, sum(kTaxels, 0.0);
  for (int second = 1; second <= kSeconds; ++second) {
    clock.wait_until(60s + std::chrono::seconds(second));
    const std::vector<double> noise = noise_of(plant, options, truth);
    for (std::size_t i = 0; i < kTaxels; ++i) {
      series[i].push_back(noise[i] / truth[i]);
      sum[i] += noise[i] / truth[i] / kMeanOver;
      if (second % kMeanOver != 0) continue;
      means += sum[i] * sum[i];
      count += 1.0;
      sum[i] = 0.0;
    }
  }
  figures.slope = slope_of(series);
  figures.slow_percent_of_output = 100.0 * std::sqrt(means / count);
  return figures;
}

}  // namespace tactbench::bench
