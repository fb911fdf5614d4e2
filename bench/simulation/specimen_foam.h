// The foam: a sheet of cellular elastomer between electrodes, read by its capacitance. Nonlinear elasticity, relaxing
// overstress and dry friction act in parallel on one compression, for which the balance with the pressure is solved:
// other physics than the two films. Equations, sources and measured figures: bench/simulation/README.md.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "bench/config/plant_options.h"
#include "bench/simulation/neighbour_links.h"

namespace tactbench::bench {

struct FilmMake;

inline constexpr std::size_t kFoamBranches = 5;  // number of relaxing branches
inline constexpr std::size_t kFoamSliders = 5;

// Set by hand from published data on foams (README).
namespace foam {
// Elastic stress e * c(e), e the compression as a share of the thickness; secant stiffness
// c(e) = plateau / (e + knee) + densifying * e / (lock - e)^2.
inline constexpr double kPlateauPsi = 5.0;
inline constexpr double kKnee = 0.12;
inline constexpr double kDensifyingPsi = 8.0;
inline constexpr double kLock = 0.75;
// Relaxing branches: shares of the secant stiffness, acting on the part of the compression that has not yet relaxed.
// Successive time constants differ by a factor of eight, from 0.1 s to 7 min (given). The spread over taxels scales all
// of them together.
inline constexpr double kSlowestSeconds = 410.0;
inline constexpr std::array<double, kFoamBranches> kRelaxing = {0.14, 0.08, 0.04, 0.02, 0.012};
inline constexpr double kShiftPerKelvin = 0.08;  // relaxation is faster when warm
// Friction of walls on walls and on the electrodes: sliders that slip at share * (tack + elastic stress). Their
// stiffness also rises with that stress, because more asperities touch; under a constant stress they slip after a
// compression of kSlip.
inline constexpr std::array<double, kFoamSliders> kFriction = {0.03, 0.04, 0.05, 0.05, 0.05};
inline constexpr std::array<double, kFoamSliders> kSlip = {0.003, 0.008, 0.02, 0.045, 0.1};
inline constexpr double kTackPsi = 0.6;
// Softening by the greatest compression so far: a part immediately, a part with the distance travelled; it recovers
// slowly.
inline constexpr double kSofteningAtOnce = 0.15;
inline constexpr double kSofteningByTravel = 0.10;
inline constexpr double kSofteningTravel = 0.8;
inline constexpr double kRecoverySeconds = 8.0 * 3600.0;
// Ratio of the capacitance to its value at rest, measured in a bridge with a fixed capacitance.
inline constexpr double kSolidShare = 0.75;  // permittivity 1 + kSolidShare / (1 - e)
inline constexpr double kFixedCapacitance = 3.0;
inline constexpr double kAmplitudeV = 12.5;
inline constexpr double kZeroV = 0.05;
// The skin transfers a share of a pressure difference to a neighbour.
inline constexpr double kSkin = 0.02;
inline constexpr double kCornerSkin = 0.006;
// Spread over taxels, of the logarithm; for the locking strain, of the compression. Density follows the sheet's
// thickness.
inline constexpr double kDensitySpread = 0.10;
inline constexpr double kElasticSpread = 0.06;
inline constexpr double kKneeSpread = 0.15;
inline constexpr double kLockSpread = 0.01;
inline constexpr double kRelaxingSpread = 0.15;
inline constexpr double kTimeSpread = 0.25;
inline constexpr double kFrictionSpread = 0.2;
inline constexpr double kSlipSpread = 0.25;
inline constexpr double kSofteningSpread = 0.2;
inline constexpr double kReadoutSpread = 0.05;
inline constexpr double kAreaSpread = 0.04;
// The longest pieces into which a call is divided.
inline constexpr double kPiecePsi = 0.5;
inline constexpr double kPieceSeconds = 0.1;
inline constexpr double kPieceOfCalm = 0.5;  // share of the time for which the load has been held
inline constexpr double kCalmPsi = 0.01;
}  // namespace foam

struct FoamTaxelState {
  double load_psi = 0.0;                          // local pressure
  double strain = 0.0;                            // compression, share of the thickness
  double greatest = 0.0;                          // greatest strain; recovers slowly
  double worked_in = 0.0;                         // follows `greatest` with the distance travelled
  std::array<double, kFoamBranches> unrelaxed{};  // part of the strain
  std::array<double, kFoamSliders> friction_psi{};
};

struct FoamMemory {
  std::vector<FoamTaxelState> taxels;
  double calm_s = 0.0;  // since the load last changed
};

class Foam {
 public:
  // Draws the constants of each taxel; the remaining constants in `make` are scaled to the foam.
  Foam(const SpecimenOptions& options, FilmMake& make);

  [[nodiscard]] FoamMemory begin() const { return {std::vector<FoamTaxelState>(taxels_.size()), 0.0}; }
  // Ramps to `local_psi` linearly within `seconds`. `local_psi` is changed to the pressure after coupling through the
  // skin.
  void advance(FoamMemory& memory, std::vector<double>& local_psi, double seconds) const;
  // Output of a taxel as a share of its amplitude.
  [[nodiscard]] double response(const FoamMemory& memory, std::size_t taxel) const;

 private:
  struct Taxel {
    double plateau_psi, knee, densifying_psi, lock, softening_at_once, softening_by_travel, solid_share, fixed,
        slowest_per_s;
    std::array<double, kFoamBranches> relaxing{};
    std::array<double, kFoamSliders> friction{}, stiffness{};  // stiffness: per psi of normal stress
  };
  static void move(const Taxel& taxel, FoamTaxelState& state, double load_psi, double seconds);
  NeighbourLinks skin_;
  std::vector<Taxel> taxels_;
};

}  // namespace tactbench::bench
