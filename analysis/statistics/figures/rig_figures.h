// Figures of the rig itself, computed only from a run's pressures, forces and positions, and tracked from check to
// check: they separate changes of the rig from changes of the sensors.
#pragma once

#include <map>
#include <string>

#include "analysis/dataset.h"

namespace tactbench::analysis {

// Of a run with held levels (recipe rig-check). A level's value is the mean of its frames. All in psi unless named:
//   zero_reference_psi, zero_feedback_psi     at the set-point 0, mean
//   reference_minus_feedback_psi              of the largest magnitude over the levels, with its sign
//   reference_minus_setpoint_psi              mean over the levels above 0: a leak shows here, and a regulator's offset
//   regulator_hysteresis_psi                  largest |reference - set-point| going down minus the same going up
//   repeatability_psi                         largest standard deviation of a level's reference over the repeats
//   hold_drift_psi_per_min                    of the largest magnitude over the levels' holds (least squares)
//   hold_noise_psi                            root mean square of what the holds leave about that line
//   settling_s                                mean from the command to the pressure in band, levels above 0
//   venting_s                                 the same for the steps that end at 0
//   ramp_lag_s                                mean of (set-point - reference) / rate while the set-point moves
//   overshoot_psi                             largest excess of the reference over the level's own, in the step's
//   direction
// Void branches do not count. A figure that the run cannot give (too few levels, no trace) is left out; empty when the
// run has no frames under pressure.
std::map<std::string, double> chamber_figures(const StoredRun& run);

// Of a run with frames under an indenter: force_zero_drift_n (largest between two tares), stage_repeatability_um
// (largest standard deviation of z at one force of one branch over the repeats), force_relaxation_percent (mean of
// (force at the dwell's start - at frame time) / force), press_stiffness_n_per_mm (from the lowest force of a loading
// branch to its highest, mean over the branches: shows a wrong scale of force or position).
std::map<std::string, double> press_figures(const StoredRun& run);

}  // namespace tactbench::analysis
