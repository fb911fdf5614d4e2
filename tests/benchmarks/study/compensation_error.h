// How far compensated pressures are from the truth on the simulated sensors of each specimen: the dynamic compensator
// beside ELAM's stream, both identified on the same runs, on sensors and trajectories that nothing was chosen on.
#pragma once

#include <string>
#include <vector>

#include "bench/config/specimen_options.h"
#include "tests/benchmarks/study/figure.h"

namespace tactbench::bench {

// Mean error in psi over all taxels and frames of all `sensor_seeds`, by specimen; runs are made in `folder`.
// `all_models`: the others too, as they are and on the linearised output, by the one rule of comparison, every eighth
// taxel.
std::vector<Figure> benchmark_compensation_error(const std::vector<SpecimenKind>& specimens,
                                                 const std::vector<unsigned>& sensor_seeds, const std::string& folder,
                                                 bool all_models = false);

}  // namespace tactbench::bench
