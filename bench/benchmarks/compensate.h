// Cost of the frame compensator against the plain scalar form, a bare scalar form without flags, and a pass that only
// scales counts.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "analysis/compensate/frame_compensator.h"
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

// What a form of the compensator makes of a frame.
struct StreamedResults {
  std::vector<float> pressure, uncertainty;
  std::vector<std::uint16_t> status;
  explicit StreamedResults(std::size_t taxels) : pressure(taxels), uncertainty(taxels), status(taxels) {}
};
// Each goes through all frames `rounds` times; seconds for all of them. `results` are those of the last frame.
double fast_seconds(int rounds, const CompensationCase& c, analysis::FrameCompensator<float>& fast,
                    StreamedResults& results);
// One taxel after the other, with flags and uncertainty.
double plain_seconds(int rounds, const CompensationCase& c, StreamedResults& results);
// The simplest form: a fixed dead band, a search in the curve, no flags, no uncertainty, no averaging.
double bare_seconds(int rounds, const CompensationCase& c, StreamedResults& results);
// The very frames that the others read, times 1e-3, written as floats to where they write theirs.
double scale_seconds(int rounds, const CompensationCase& c, StreamedResults& results);

// Of frames' times in microseconds.
struct Latency {
  double median_us = 0.0, p99_us = 0.0, worst_us = 0.0;
};
Latency latency_of(const std::vector<double>& taken_us);

// Seconds for all frames: slow cycles, and random counts.
struct CompensateTimes {
  std::size_t slow_frames = 0, random_frames = 0;
  double scale = 0.0, plain = 0.0, bare = 0.0;
  std::vector<std::pair<std::string, double>> fast;  // by vector level, the best one last
  Latency fast_latency;
  double turn = 0.0, plain_turn = 0.0, bare_turn = 0.0;  // random counts
  Latency turn_latency;
  double unknown_start_us = 0.0;                       // median
  std::vector<std::pair<std::size_t, double>> growth;  // taxels a side, seconds a frame
};
std::vector<Figure> figures_of(const CompensateTimes& times);

struct CompensateSizes {
  std::size_t taxels = 256, slow_frames = 20000, random_frames = 1000, growth_frames = 1500;
  std::size_t middle_frames = 100;  // from a twentieth of the slow ones on, from which no start is known
};
// Best of `rounds` for each, in turn.
std::vector<Figure> benchmark_compensate(int rounds, const CompensateSizes& sizes = {});

}  // namespace tactbench::bench
