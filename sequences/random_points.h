// Randomly drawn turning points, for recipes ([random]) and for studies that use the same points without a bench.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace tactbench::sequences {

// kReversals: a loop to the highest, then points anywhere in the range, alternately rising and falling. kWander: small
// reversals that wander through the range. kPress: presses to random heights, each released to 0.
enum class RandomKind { kReversals, kWander, kPress };
std::vector<std::string> random_kind_names();  // in the order of the values

struct RandomPoints {
  RandomKind kind = RandomKind::kReversals;
  std::uint64_t seed = 0;
  int count = 1;                // number of points, or heights, to draw
  long low = 0, high = 1;       // in steps of the grid, low below high
  long smallest = 1, most = 3;  // of kWander: size of a reversal
};

// Points on the grid, starting and ending at 0. The same seed gives the same points on every platform.
std::vector<long> draw_points(const RandomPoints& of);

}  // namespace tactbench::sequences
