// Cost of the frame compensator against the plain scalar form, a bare scalar form without flags, and a pass that only
// scales counts.
#pragma once

#include <cstdint>
#include <vector>

#include "analysis/compensate/frame_setup.h"
#include "bench/benchmarks/figure.h"

namespace tactbench::bench {

// Taxels of the paper's shape with spread gains and splits, and the counts of pressures that all of them see.
struct CompensationCase {
  analysis::FrameSetup setup;
  std::vector<analysis::ElamModel> models;
  std::vector<std::uint16_t> counts;  // frames x taxels
  std::size_t frames = 0;
};
// In phase, 0-60-10-50-0 psi, 4 mV of noise.
CompensationCase slow_cycles(std::size_t taxels, std::size_t frames);
// Independent random counts for each frame and taxel: two thirds of the taxels turn in each frame.
CompensationCase random_frames(std::size_t taxels, std::size_t frames);

// The first `frames` of a case, its array laid down `times` times.
CompensationCase tiled(const CompensationCase& from, std::size_t times, std::size_t frames);

// Best of `rounds` for each, in turn; ratios and their goals as figures of their own.
std::vector<Figure> benchmark_compensate(int rounds);

// Microseconds a frame of 256 taxels.
struct CompensateTimes {
  double scale = 0.0, plain = 0.0, bare = 0.0, fast = 0.0;  // slow cycles
  double turn = 0.0, plain_turn = 0.0, bare_turn = 0.0;     // random counts
};
void add_ratios(FigureList& figures, const CompensateTimes& times);

}  // namespace tactbench::bench
