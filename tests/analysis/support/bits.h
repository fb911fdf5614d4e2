// Numbers to their last bit, all in one: what plain arithmetic (no exp, log or pow) gives is the same everywhere.
#pragma once

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>

#include <fmt/format.h>

namespace to_the_bit {

class Bits {
 public:
  void add(double value) {
    const double plain = value == 0.0 ? 0.0 : std::isnan(value) ? std::numeric_limits<double>::quiet_NaN() : value;
    mix(std::bit_cast<std::uint64_t>(plain));
  }
  void add_count(std::size_t count) { mix(count); }
  [[nodiscard]] std::string text() const { return fmt::format("{:016x}", state_); }

 private:
  void mix(std::uint64_t word) {
    state_ = (state_ ^ word) * 0x9e3779b97f4a7c15U;
    state_ ^= state_ >> 29U;
  }
  std::uint64_t state_ = 0xcbf29ce484222325U;
};

inline double just_above(double value) { return std::nextafter(value, std::numeric_limits<double>::infinity()); }
inline double just_below(double value) { return std::nextafter(value, -std::numeric_limits<double>::infinity()); }

}  // namespace to_the_bit
