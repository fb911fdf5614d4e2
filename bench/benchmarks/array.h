// Cost of the simulated array a frame, against plain play operators and against the wire that carries the frame.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <vector>

#include "bench/benchmarks/figure.h"

namespace tactbench::bench {

// The simplest form of 256 taxels: twelve play operators each, of 0 to 11 psi and 5 mV/psi, normal noise of 1.5 mV, 16
// bit of 5 V.
class PlainArray {
 public:
  PlainArray() : plays_(kTaxels) {}
  void frame(double pressure_psi);
  [[nodiscard]] std::span<const std::uint16_t> counts() const { return counts_; }

 private:
  static constexpr std::size_t kTaxels = 256;
  std::vector<std::array<double, 12>> plays_;
  std::array<std::uint16_t, kTaxels> counts_{};
  std::mt19937 random_{1};
  std::normal_distribution<double> normal_;
};
// 0 to 60 psi and back in 200 frames, along a cosine.
double benchmarked_pressure(std::size_t frame);

struct ArraySizes {
  std::size_t frames = 1000;
  int scans = 501;  // on the wire
};
// 256 taxels, best of `rounds`. A frame on the wire is one scan of the simulated scanner through its driver: median.
std::vector<Figure> benchmark_array(int rounds, const ArraySizes& sizes = {});

// Seconds for all frames each, and microseconds for one on the wire.
struct ArrayTimes {
  double plain_s = 0.0, specimen_s = 0.0, counts_s = 0.0;
  double wire_us = 0.0;
};
std::vector<Figure> figures_of(const ArrayTimes& times, const ArraySizes& sizes = {});

}  // namespace tactbench::bench
