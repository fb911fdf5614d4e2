// Figures of the speed benchmarks: main.cpp prints a line FIGURE <name> <value> <unit> for the best repetition of each,
// for counters named "what [unit]", and for the quotients declared here. A time is that of an item where items are
// counted.
#pragma once

#include <string>
#include <vector>

namespace tactbench::speed {

// Time of `of` over the sum of the times of `by`, all by their names with arguments; printed once all are measured.
struct Quotient {
  std::string name, of;
  std::vector<std::string> by;
  double at_most = 0.0, at_least = 0.0;  // our goal; 0: none
};

inline std::vector<Quotient>& quotients() {
  static std::vector<Quotient> list;
  return list;
}

// For static initialisation.
inline bool declare(std::vector<Quotient> more) {
  quotients().insert(quotients().end(), more.begin(), more.end());
  return true;
}

}  // namespace tactbench::speed
