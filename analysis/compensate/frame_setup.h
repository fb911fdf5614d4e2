// Set-up of a frame compensator: each taxel's patterns, parameters, noise and status, and the common options.
#pragma once

#include <cstddef>
#include <vector>

#include "analysis/compensate/options.h"
#include "analysis/models/elam.h"

namespace tactbench::analysis {

struct TaxelSetup {
  bool usable = false;              // false (dead, stuck, saturated, unfit): the other members are not read
  std::vector<double> ascending_v;  // pattern at FrameSetup::pressure_psi; of a falling sensor the negated output
  std::vector<double> descending_v;
  ElamParameters parameters;
  double noise_v = 0.0;  // standard deviation of a sample
  bool falling = false;  // the output falls when the pressure rises: samples are negated [A20]
  // Root mean square of what the model leaves, psi, by equal intervals of the pressures: rising, then falling. Of one
  // length in all taxels that have it; empty: not known, the uncertainty is that of noise alone.
  std::vector<double> residual_psi = {};
};

struct FrameSetup {
  std::vector<double> pressure_psi;  // common grid of the patterns, strictly increasing, at least two
  std::vector<TaxelSetup> taxels;
  double volts_per_count = 0.0;
  ElamOptions elam;
  CompensatorOptions options;  // its noise_v is not used
  bool start_unknown = true;   // else all start at rest at the lowest pressure
  int longest_gap = 10;        // frames lost in a row after which the history is unknown
  double tare_share = 0.2;     // a tare that would move a taxel by more than this share of its span is refused
};

}  // namespace tactbench::analysis
