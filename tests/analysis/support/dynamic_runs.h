// Runs of small arrays that follow the dynamic model: the paper's sequences, rates, held levels, and one further
// trajectory.
#pragma once

#include <string>
#include <utility>

#include "analysis/dataset.h"
#include "tests/analysis/support/dynamic_plant.h"

namespace synthetic {

inline constexpr std::size_t kTaxels = 4;

struct Timed {
  std::vector<double> levels;
  double seconds = 2.6;  // at each
  int frames = 1;
};

// Plants that begin at rest, without conditioning.
inline Dataset run_of(const DynamicArray& array,
                      const std::vector<std::pair<std::string, std::vector<Timed>>>& sequences, std::int64_t number,
                      double sign = 1.0) {
  std::vector<DynamicPlant> plants;
  for (std::size_t t = 0; t < kTaxels; ++t) plants.emplace_back(array.films[t], array.dynamics, array.taxels[t], 40);
  Dataset data;
  data.run = number;
  data.origin = "simulated";
  data.sensor_serial = "S";
  data.scanner_serial = "C";
  data.rows = 1;
  data.columns = kTaxels;
  data.noise_v.assign(kTaxels, 0.0005);
  data.at_limit.assign(kTaxels, false);
  std::mt19937 random(static_cast<unsigned>(number) + 70);
  std::normal_distribution<double> noise(0.0, 0.0005);
  double now = 0.0;
  for (const auto& [name, repeats] : sequences) {
    SequenceData& sequence = data.sequences.emplace_back(SequenceData{name, {}});
    for (const Timed& timed : repeats) {
      Repeat& repeat = sequence.repeats.emplace_back();
      for (const double psi : timed.levels)
        for (int f = 1; f <= timed.frames; ++f) {
          now += timed.seconds;
          repeat.steps.push_back({psi, psi, now, f * timed.seconds});
          for (DynamicPlant& plant : plants)
            repeat.volts.push_back(sign * (plant.step(psi, timed.seconds) + noise(random)));
        }
    }
  }
  return data;
}

inline std::vector<double> way_along(const std::vector<double>& turns, double step) {
  std::vector<double> way{turns.front()};
  for (const double turn : turns)
    while (way.back() != turn) way.push_back(way.back() + (turn > way.back() ? step : -step));
  return way;
}

struct Runs {
  Dataset fitted, rate, creep, other;
};

inline Runs runs_of(const DynamicArray& array, double sign = 1.0) {
  const std::vector<double> down = way_along({0, 60, 0, 50, 0, 40, 0, 30, 0, 20, 0, 10, 0}, 2.0);
  const std::vector<double> up =
      way_along({0, 60, 10, 60, 0, 60, 20, 60, 0, 60, 30, 60, 0, 60, 40, 60, 0, 60, 50, 60, 0}, 2.0);
  const std::vector<double> loop = way_along({0, 60, 0}, 4.0);
  const std::vector<double> elsewhere = way_along({0, 60, 0, 46, 14, 38, 22, 56, 8, 52, 30, 44, 0}, 2.0);
  return {run_of(array, {{"descending", {{down}}}, {"ascending", {{up}}}}, 1, sign),
          run_of(array, {{"rate", {{loop, 0.8}, {loop, 2.6}, {loop, 20.0}}}}, 2, sign),
          run_of(array, {{"creep-levels", {{{0, 20, 40, 60, 40, 20, 0}, 2.0, 151}}}}, 3, sign),
          run_of(array, {{"elsewhere", {{elsewhere}}}}, 4, sign)};
}

}  // namespace synthetic
