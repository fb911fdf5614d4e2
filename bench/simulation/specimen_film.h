// Internals of the specimen: its constants (FilmMake, fixed by the sensor seed), the film's memory (FilmMemory) and the
// physics between them. Structure of arrays over taxels; equations in bench/simulation/README.md.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bench/simulation/specimen.h"
#include "bench/simulation/specimen_foam.h"
#include "bench/simulation/specimen_harsh.h"

namespace tactbench::bench {

inline constexpr int kFrictionElements = 6;
inline constexpr int kCreepTimes = 4;

// Constants of the film's manufacturing process: the same for every sensor. The constants from kRestCentre to
// kSensitivityExponent were found by a random search (12000 trials, step sizes adapted) for the paper's figures on
// sensor seeds 1 to 5 at once: hysteresis of the mean taxel 25.3 % FS max and 10.0 % mean, full scale 3.49 V, a fall
// of 1.4 % FS from 60 to 50 psi, the thirteen cells of Table 6, and loosely the paper's outer curves. The others were
// set by hand.
namespace film {
// Friction elements: half-open plays [q, q + width * friction(q)]; widths in units of the local friction.
inline constexpr std::array<double, kFrictionElements> kWidths = {0.0, 0.35, 0.7, 1.1, 1.6, 2.3};
// Shares of the elements in the contact pressure: Gaussian functions of the width, one for a film at rest, one for a
// film with a far displaced widest element.
inline constexpr double kRestCentre = -0.48;
inline constexpr double kRestSpread = 0.88;
inline constexpr double kDisplacedCentre = 2.41;
inline constexpr double kDisplacedSpread = 0.76;
inline constexpr double kDisplacedHalfPsi = 32.0;
// friction(q) = q / (1 + q/kFrictionLinear + (q/kFrictionPeak)^2): rises with the load, falls at full contact. Its
// steepest fall, times the widest play and the roughest virgin taxel, stays below 1, so that q + width * friction(q)
// still rises everywhere.
inline constexpr double kFrictionLinearPsi = 66.0;
inline constexpr double kFrictionPeakPsi = 16.54;
// Conductance against contact pressure, read by a divider: A u^n / (1 + u^n), u = x / kHalfPsi.
inline constexpr double kAmplitudeV = 3.89;
inline constexpr double kHalfPsi = 17.82;
inline constexpr double kExponent = 2.05;
inline constexpr double kExponentFloor = 0.8;
inline constexpr double kZeroV = 0.02;
// Spread over taxels (standard deviations before truncation) and correlations.
inline constexpr double kAmplitudeSpread = 0.083;
inline constexpr double kSensitivitySpread = 0.3;
inline constexpr double kExponentSpread = 0.75;
inline constexpr double kFrictionSpread = 0.4645;
inline constexpr double kLiftOffSpread = 0.26;
inline constexpr double kAmplitudeSensitivity = 0.8;
inline constexpr double kSensitivityExponent = -0.387;
inline constexpr double kTruncation = 2.1;
inline constexpr double kZeroSpread = 0.1;
inline constexpr double kCreepSpread = 0.2;
// Creep: shares and relaxation times; the target rises with the local pressure as q / (q + kCreepHalfPsi).
inline constexpr std::array<double, kCreepTimes> kCreepSeconds = {0.5, 4.0, 32.0, 256.0};
inline constexpr std::array<double, kCreepTimes> kCreepShares = {0.016, 0.015, 0.013, 0.009};
inline constexpr double kCreepHalfPsi = 6.0;
// Membrane: a share of the pressure reaches the film with a delay.
inline constexpr double kLagSeconds = 1.2;
inline constexpr double kLagShare = 0.07;
inline constexpr double kLagSpread = 0.25;
// First cycles: the virgin film's remaining effect decays by exp(-kConditioningRate) with each load to 60 psi.
inline constexpr double kConditioningRate = 2.0;
inline constexpr double kVirginGainLoss = 0.07;
inline constexpr double kVirginFriction = 0.25;
inline constexpr double kFullLoadPsi = 60.0;
inline constexpr double kRailV = 5.0;
inline constexpr double kNoisyV = 0.05;
inline constexpr double kReferenceCelsius = 23.0;
}  // namespace film

struct FilmMake {
  std::vector<double> amplitude_v, sensitivity, exponent, friction, lift_off_psi, zero_v, creep, lag_share;
  std::vector<double> age_drift;  // gain drift with age, standard normal
  std::array<double, kFrictionElements> rest_share{}, displaced_share{};
};

// `taxels` values of each kind. The distributions belong to the process and are met exactly by every sensor
// (stratified quantiles); which taxel gets which value belongs to the seed.
FilmMake make_film(const SpecimenOptions& options);
// Shares of the friction elements, adding up to 1: a Gaussian bump over their widths.
std::array<double, kFrictionElements> element_shares(double centre, double spread);

// Ratio of local to chamber pressure, one value per taxel of the film: non-uniformity, tilt, mount, edge outside the
// membrane.
std::vector<double> shares_of_chamber(const SpecimenOptions& options);
// The film's taxel that each taxel of the scanner reads; throws std::invalid_argument.
std::vector<std::size_t> turned_wiring(const SpecimenOptions& options);

struct FilmMemory {
  std::array<std::vector<double>, kFrictionElements> plays;  // psi, per taxel
  std::vector<std::vector<double>> creep;                    // 0..1, by relaxation time and taxel
  double pressure_psi = 0.0;                                 // chamber, last advance
  double lag_psi = 0.0;                                      // pressure that has passed through the membrane
  double virgin = 1.0;                                       // 1 new, 0 conditioned
  double travel_psi = 0.0;                                   // sum of all pressure rises so far
  HarshMemory harsh;                                         // empty for other films
  FoamMemory foam;                                           // the foam's only memory
};

struct Specimen::Film {
  explicit Film(const SpecimenOptions& given);
  // contact_psi: empty, or one value per taxel.
  void advance(FilmMemory& state, double pressure_psi, double seconds, std::span<const double> contact_psi) const;
  void output(const FilmMemory& state, std::span<double> volts) const;

  SpecimenOptions options;
  int taxels;
  FilmMake make;
  std::vector<double> share_of_chamber;
  std::vector<std::size_t> wiring;
  std::vector<double> noise_v;
  std::optional<HarshFilm> harsh;
  std::optional<Foam> foam;
  FilmMemory memory;

 private:
  [[nodiscard]] std::vector<double> local_psi(double pressure_psi, double lag_psi,
                                              std::span<const double> contact_psi) const;
  void turn(std::span<double> values) const;
  void apply_defects(std::span<double> volts) const;
  void apply_crosstalk(std::span<double> volts) const;
};

std::string write_state(const FilmMemory& memory, const SpecimenOptions& options);
FilmMemory read_state(const std::string& text, const SpecimenOptions& options);

}  // namespace tactbench::bench
