// Randomly drawn turning points, for recipes ([random]) and for studies that draw the same points without a bench.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace tactbench::sequences {

// kReversals: a loop to the highest, then points anywhere in the range, rising and falling in turn. kWander: small
// reversals that wander through the range. kPress: presses to heights drawn, each released to 0.
enum class RandomKind { kReversals, kWander, kPress };
std::vector<std::string> random_kind_names();  // in the order of the values

struct RandomPoints {
  RandomKind kind = RandomKind::kReversals;
  std::uint64_t seed = 0;
  int count = 1;                // points, or heights, that are drawn
  long low = 0, high = 1;       // in steps of the grid, low below high
  long smallest = 1, most = 3;  // of kWander: size of a reversal
};

// On the grid, from 0 to 0. The same for the same seed on every platform.
std::vector<long> draw_points(const RandomPoints& of);

}  // namespace tactbench::sequences
