// Counter-based random numbers of the simulation: the same key and counter give the same number on every platform,
// in any order of calls. Used for the constants of the sensor (sensor seed) and for all noise (seed).
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace tactbench::bench {

// The finaliser of SplitMix64: a bijection of 64 bits, each output bit depends on each input bit.
constexpr std::uint64_t mix64(std::uint64_t value) {
  value += 0x9E3779B97F4A7C15ULL;
  value = (value ^ (value >> 30U)) * 0xBF58476D1CE4E5B9ULL;
  value = (value ^ (value >> 27U)) * 0x94D049BB133111EBULL;
  return value ^ (value >> 31U);
}

constexpr std::uint64_t hash_of(std::uint64_t seed, std::uint64_t stream, std::uint64_t counter) {
  return mix64(mix64(mix64(seed) ^ stream) ^ counter);
}

// In (0, 1).
constexpr double uniform_of(std::uint64_t hash) {
  return (static_cast<double>(hash >> 12U) + 0.5) * (1.0 / 4503599627370496.0);
}

// Mean 0, standard deviation 1, bounded by 3.46: the sum of four uniforms of 16 bits, which needs no library function
// whose last bit differs between platforms.
constexpr double bell_of(std::uint64_t hash) {
  const auto sum = (hash & 0xFFFFU) + ((hash >> 16U) & 0xFFFFU) + ((hash >> 32U) & 0xFFFFU) + (hash >> 48U);
  // Four uniforms on 0..65535: mean 131070, variance 4 (65536^2 - 1) / 12.
  return (static_cast<double>(sum) - 131070.0) * (1.0 / 37837.2272372);
}

// The random stream from which one taxel's constants are drawn in order.
class Scatter {
 public:
  explicit Scatter(std::uint64_t key) : key_(key) {}
  // Mean 0, standard deviation 1 before it is truncated.
  double normal() { return std::clamp(bell_of(hash_of(key_, 0, drawn_++)), -2.1, 2.1); }
  // `spread`: standard deviation of the logarithm.
  double around(double usual, double spread) { return usual * std::exp(spread * normal()); }

 private:
  std::uint64_t key_, drawn_ = 0;
};

}  // namespace tactbench::bench
