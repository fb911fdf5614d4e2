// Cost of the dynamic frame compensator beside ELAM's on arrays of the same size and pressures of the same course.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "analysis/compensate/dynamic_setup.h"
#include "bench/benchmarks/figure.h"

namespace tactbench::bench {

// Taxels whose films have Preisach densities that fall off from the diagonal, in 20 intervals up to 60 psi, with a
// divider of about 4 V, lag and creep.
struct DynamicCase {
  analysis::DynamicSetup setup;
  std::vector<std::uint16_t> counts;  // frames x taxels
  std::size_t frames = 0;
};
// In phase, 0-60-10-50-0 psi, 4 mV of noise; without lag and creep.
DynamicCase slow_dynamic(std::size_t taxels, std::size_t frames);
// Counts of 0 to 3.2 V drawn anew for each frame and taxel.
DynamicCase random_dynamic(std::size_t taxels, std::size_t frames);

// Seconds for all frames by one vector level: slow cycles and random counts, the dynamic compensator and ELAM's.
struct DynamicLevelTimes {
  std::string level;
  double slow = 0.0, turning = 0.0, slow_elam = 0.0, turning_elam = 0.0;
};
struct CompensateDynamicTimes {
  std::size_t slow_frames = 0, random_frames = 0;
  std::vector<DynamicLevelTimes> levels;
  std::size_t bytes_per_taxel = 0;
};
std::vector<Figure> figures_of(const CompensateDynamicTimes& times);

struct CompensateDynamicSizes {
  std::size_t taxels = 256, slow_frames = 20000, random_frames = 1000;
};
std::vector<Figure> benchmark_compensate_dynamic(int rounds, const CompensateDynamicSizes& sizes = {});

}  // namespace tactbench::bench
