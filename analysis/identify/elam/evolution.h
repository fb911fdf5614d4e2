// Shared by the evolution strategies with an adapted covariance: constants, and a fixed sequence of variates.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace tactbench::analysis {

// Weights log(kParents + 0.5) - log(i) of the parents, and the constants that follow from them and the dimension
// (Hansen, The CMA Evolution Strategy: A Tutorial).
template <std::size_t kParents, int kDimensions>
struct EvolutionConstants {
  std::array<double, kParents> weight{};
  double mass = 0.0, path_share = 0.0, path_damping = 0.0, way_share = 0.0, rank_one = 0.0, rank_many = 0.0;
  EvolutionConstants() {
    constexpr double n = kDimensions;
    double sum = 0.0, squares = 0.0;
    for (std::size_t i = 0; i < kParents; ++i)
      sum += weight[i] = std::log(kParents + 0.5) - std::log(1.0 + static_cast<double>(i));
    for (double& w : weight) {
      w /= sum;
      squares += w * w;
    }
    mass = 1.0 / squares;
    path_share = (mass + 2.0) / (n + mass + 5.0);
    path_damping = 1.0 + path_share;
    way_share = (4.0 + mass / n) / (n + 4.0 + 2.0 * mass / n);
    rank_one = 2.0 / ((n + 1.3) * (n + 1.3) + mass);
    rank_many = std::min(1.0 - rank_one, 2.0 * (mass - 2.0 + 1.0 / mass) / ((n + 2.0) * (n + 2.0) + mass));
  }
};

// Nearly normal variates, the same sequence from each object: sums of four 16-bit parts of xorshift numbers.
class Variates {
 public:
  double operator()() {
    state_ ^= state_ << 13U;
    state_ ^= state_ >> 7U;
    state_ ^= state_ << 17U;
    const std::uint64_t sum =
        (state_ & 0xffffU) + ((state_ >> 16U) & 0xffffU) + ((state_ >> 32U) & 0xffffU) + (state_ >> 48U);
    return (static_cast<double>(sum) / 65536.0 - 2.0) * 1.7320508;
  }

 private:
  std::uint64_t state_ = 88172645463325252ULL;
};

}  // namespace tactbench::analysis
