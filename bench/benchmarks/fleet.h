// Pushing to a fleet against the same rows by psql's \copy, and pushing again what is there.
#pragma once

#include <string>
#include <vector>

#include "bench/benchmarks/figure.h"

namespace tactbench::bench {

struct FleetSizes {
  int runs = 5, side = 16;  // taxels a side
};
// Each round pushes a new store of runs with 662 frames, sends the same rows by psql \copy (binary) into a table of the
// same shape, and pushes the store again; the best of `rounds` counts. Runs cannot be taken away, so that the fleet at
// `conninfo` has to be one without runs, made for this: else Error TB-USAGE. psql has to be in PATH.
std::vector<Figure> benchmark_fleet(int rounds, const std::string& conninfo, const std::string& folder,
                                    const FleetSizes& sizes = {});

// The best times over all rounds.
struct FleetTimes {
  double frames = 0.0;  // of one round's runs
  double push_s = 0.0, copy_s = 0.0, again_s = 0.0;
  int runs = FleetSizes().runs;
};
std::vector<Figure> figures_of(const FleetTimes& times);

}  // namespace tactbench::bench
