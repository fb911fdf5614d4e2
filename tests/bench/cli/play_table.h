// Tables of a sensor with play for tests: y follows x through backlash, curved at the top.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace tactbench::tests {

struct PlaySample {
  int step = 0;
  double input = 0.0, output = 0.0;
};

// Through the turning points, `steps` from each to the next.
inline std::vector<PlaySample> play_samples(const std::vector<double>& turns, int steps = 40) {
  std::vector<PlaySample> samples;
  double play = 0.0;
  int step = 0;
  for (std::size_t t = 1; t < turns.size(); ++t)
    for (int k = t == 1 ? 0 : 1; k <= steps; ++k) {
      const double x = turns[t - 1] + (turns[t] - turns[t - 1]) * k / steps;
      play = std::clamp(play, x - 1.5, x);
      samples.push_back({step++, x, 0.5 * x + 0.4 * play + std::sqrt(std::max(x, 0.0))});
    }
  return samples;
}

}  // namespace tactbench::tests
