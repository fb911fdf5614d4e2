// A model in a device's integers against its stream in doubles, on a stored run's outputs made a dense noisy stream.
#pragma once

#include <cstdint>
#include <string>

namespace tactbench::bench {

struct FixedStudyOptions {
  std::string model, store;  // files
  int run = 1, every = 16;   // taxels
  std::uint64_t seed = 1;    // of the noise
  double rate_hz = 76.0, conditioned_s = 70.0;
};

// Outputs and pressures of the run interpolated to `rate_hz`, the noise of one scan added, rounded to counts, and both
// streams given these. One row of a table: mean errors in psi, their ratio, and how far the two are apart in % of the
// range (median, 90, 99 and 99.9 %, share above 0.3 %). Throws AnalysisError.
std::string study_fixed(const FixedStudyOptions& options);

}  // namespace tactbench::bench
