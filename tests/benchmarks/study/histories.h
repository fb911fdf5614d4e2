// Pressure histories as a sensor in use meets them, and the outputs of a simulated sensor along them: directly from the
// plant, behind an ideal regulator, so that neither the bench nor a regulator's limits affect them.
#pragma once

#include <cstdint>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "bench/config/plant_options.h"
#include "sequences/random_points.h"

namespace tactbench::bench {

// Straight to a pressure in so long; scans evenly on the way, the last at its end.
struct Leg {
  double psi = 0.0, seconds = 0.0;
  int scans = 1;
};
using Legs = std::vector<Leg>;

class Draw {
 public:
  explicit Draw(std::uint64_t seed) : generator_(seed) {}
  double between(double low, double high) {
    return low + (high - low) * static_cast<double>(generator_() >> 11U) * 0x1p-53;
  }
  // By the function that draws those of recipes; sizes in psi, on a grid of `step`.
  std::vector<double> points(sequences::RandomKind kind, double step, double low, double high, int count,
                             double most = 6.0);

 private:
  std::mt19937_64 generator_;
};

struct HistoryKind {
  const char* name;
  Legs (*legs)(Draw& draw);
  std::vector<std::string> set = {};  // KEY=VALUE of the bench file: another mount, another day
  bool unknown_start = false;         // the stream starts in mid-history
  double conditioned_psi = 60.0;      // highest pressure that the film has seen
  [[nodiscard]] bool known_here() const { return !unknown_start && set.empty(); }
};
const std::vector<HistoryKind>& history_kinds();

struct Recording {
  double worked_s = 0.0;             // conditioning before the first scan
  std::vector<double> seconds, psi;  // of each scan: since the one before, and the plant's pressure
  std::vector<double> volts;         // scans x `taxels`
};
// `plant` as a run of this sensor has it; its seed is taken from `seed`, as the history's draws are.
Recording record(const HistoryKind& kind, PlantOptions plant, std::uint64_t seed, std::span<const std::size_t> taxels);

}  // namespace tactbench::bench
