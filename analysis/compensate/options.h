// A compensator's options on noise, turns and flat places; the same for the plain and the fast form.
#pragma once

namespace tactbench::analysis {

// The defaults were found by a random search over random reversals of 8 synthetic taxels, 1.5 to 32 mV of noise and
// 0.004 to 2 psi a sample. They are a compromise: a fixed dead band that happens to suit a noise and a speed is up to
// 22 % better there (tests/analysis/compensate/direction_slow.cpp, on other taxels). Not verified on hardware.
struct CompensatorOptions {
  double noise_v = 0.0;          // standard deviation of a sample
  double moving = 2.4;           // mean square of a sample's step, in noises squared, above which nothing is averaged
  double jump_in_noises = 5.0;   // a sample this x the noise from the mean before it starts a new mean
  int longest_mean = 8;          // samples: an output that does not move is averaged over up to this many
  double lead_in_noises = 1.75;  // the highest of many means lies above the true extreme by this x a mean's noise
  double band_in_noises =
      5.5;  // dead band = this x the mean's noise: a turn is remembered once the mean is so far back
  double rest_in_noises =
      3.0;  // an extreme within this x the noise of the place where the output came to rest was noise
  double hold_in_noises = 1.6;  // within this x the mean's noise of the extreme the output has not turned
  double flat_in_noises = 4.0;  // flat when an output this x the mean's noise off moves the estimate ...
  double flat_psi = 2.0;        // ... by more than this
  double drift_share = 0.01;    // of the output's span: within this of yu a turn's split is that of a turn at xu
  double known_psi = 0.5;       // an unknown start is over when the estimates of all histories are within this
};

// The mean square of the steps is a running one over this many samples, each counted up to a ceiling, so that a halt is
// detected soon after a fast move.
inline constexpr double kStepWindow = 24.0;
inline constexpr double kStepCeiling = 14.0;
// Stands for 1 / 0 where there is no noise: any step is a move.
inline constexpr double kNoNoise = 1e30;

// What a compensator takes, so that no number overflows in single precision, squares and the slopes of branches
// included: outputs in noises and in counts, pressures and their span in the caller's unit.
inline constexpr double kMostOutput = 1e12, kLeastOutput = 1e-3, kMostPressure = 1e9, kLeastSpan = 1e-9;
// A piece of a branch that rises by less, or by nothing once its corner's output is added, is a step: no slope.
inline constexpr double kLeastRise = 1e-20;

// Throws std::invalid_argument when an option is not within 0 and 1e9, or longest_mean is below 1.
void check_options(const CompensatorOptions& options);

}  // namespace tactbench::analysis
