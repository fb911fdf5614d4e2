// Physics of an array whose counts and status encode the scan and the taxel.
#pragma once

#include <atomic>
#include <cstdint>
#include <span>
#include <stdexcept>

#include "devices/tactile/simulated_scanner.h"

namespace tactbench::devices {

// Taxel i of scan n has 100 n + i counts, row r the status r of scan n plus 16 n.
class CountedArray final : public TactilePort {
 public:
  void scan(std::span<std::uint16_t> counts, std::span<std::uint8_t> status) override {
    const int number = scans++;
    if (number == broken_scan) throw std::runtime_error("no physics");
    for (std::size_t i = 0; i < counts.size(); ++i)
      counts[i] = static_cast<std::uint16_t>(100 * number + static_cast<int>(i));
    for (std::size_t row = 0; row < status.size(); ++row)
      status[row] = static_cast<std::uint8_t>(16 * number + static_cast<int>(row));
  }
  std::atomic<int> scans{0};
  std::atomic<int> broken_scan{-1};
};

}  // namespace tactbench::devices
