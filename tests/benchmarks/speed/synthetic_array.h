// Synthetic taxels of the paper's shape for the benchmarks, and a run of them: no simulated rig, whose steps would take
// the time, and the same data each time.
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "analysis/dataset.h"
#include "analysis/models/elam.h"

namespace tactbench::speed {

// Spread gains, bends and splits; 31 knots over 0-60 psi.
analysis::ElamModel taxel_like_the_paper(std::mt19937& random);

// Both sequences of Table 1 at steps of 2 psi (211 + 451 samples), free running, with a play of 6 psi that no ELAM can
// follow, 4 mV of noise, 0.03 psi of noise on the reference. One scan per frame.
analysis::Dataset synthetic_dataset(int rows, int columns, int repeats);

// The same as a completed run of a sensor of its own: as simulated frames of 16 bit.
std::int64_t store_run(db::RunStore& store, const analysis::Dataset& dataset);

}  // namespace tactbench::speed
