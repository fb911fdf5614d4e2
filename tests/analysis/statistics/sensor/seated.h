// Frames of simulated arrays as input of the seating check.
#pragma once

#include <cmath>
#include <vector>

#include "analysis/statistics/sensor/seating.h"
#include "bench/simulation/counter_noise.h"
#include "bench/simulation/specimen.h"

namespace tactbench::analysis {

// Unloaded, then 8 psi after 20 s; 1.5 mV of noise per sample, two samples per frame.
inline SeatingFrames seated(const bench::SpecimenOptions& options, std::uint64_t noise_seed = 1,
                            double noise_v = 0.0015) {
  bench::Specimen specimen(options);
  const auto taxels = static_cast<std::size_t>(options.rows * options.columns);
  SeatingFrames frames{8.0, std::vector<double>(taxels), std::vector<double>(taxels)};
  specimen.output(frames.unloaded_v);
  for (int k = 1; k <= 8; ++k) specimen.advance(k, 0.05);
  for (int k = 0; k < 5; ++k) specimen.advance(8.0, 4.0);
  specimen.output(frames.loaded_v);
  for (std::size_t i = 0; i < taxels; ++i) {
    frames.unloaded_v[i] += noise_v / std::sqrt(2.0) * bench::bell_of(bench::hash_of(noise_seed, 1, i));
    frames.loaded_v[i] += noise_v / std::sqrt(2.0) * bench::bell_of(bench::hash_of(noise_seed, 2, i));
  }
  return frames;
}

inline bench::SpecimenOptions sensor(std::uint64_t seed) {
  bench::SpecimenOptions options;
  options.sensor_seed = seed;
  return options;
}

// The same sensor taken out and mounted again: another noise, 3 % of local pressure.
inline bench::SpecimenOptions mounted_again(std::uint64_t seed) {
  bench::SpecimenOptions options = sensor(seed);
  options.mount_seed = seed + 1;
  options.effects.remount_variation = 0.03;
  return options;
}

}  // namespace tactbench::analysis
