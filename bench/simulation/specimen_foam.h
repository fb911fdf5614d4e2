// The foam: a sheet of cellular elastomer between electrodes, read by its capacitance. Nonlinear elasticity, relaxing
// overstress and dry friction act side by side on one compression, for which the balance with the pressure is solved:
// other physics than the two films'. Equations, sources and measured figures: bench/simulation/README.md.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "bench/config/plant_options.h"
#include "bench/simulation/neighbour_links.h"

namespace tactbench::bench {

struct FilmMake;

inline constexpr std::size_t kFoamBranches = 5;  // of relaxation
inline constexpr std::size_t kFoamSliders = 5;

// Set by hand, from what is published of foams (README).
namespace foam {
// Elastic stress e * c(e), e the compression as a share of the thickness; secant stiffness
// c(e) = plateau / (e + knee) + densifying * e / (lock - e)^2.
inline constexpr double kPlateauPsi = 5.0;
inline constexpr double kKnee = 0.12;
inline constexpr double kDensifyingPsi = 8.0;
inline constexpr double kLock = 0.75;
// Relaxing branches: shares of the secant stiffness, on what they have not yet relaxed of the compression.
// Their times are eight times apart, the slowest given: 0.1 s to 7 min. A taxel has all of them longer or shorter.
inline constexpr double kSlowestSeconds = 410.0;
inline constexpr std::array<double, kFoamBranches> kRelaxing = {0.14, 0.08, 0.04, 0.02, 0.012};
inline constexpr double kShiftPerKelvin = 0.08;  // relaxation is quicker when warm
// Friction of walls on walls and on the electrodes: sliders that slip at share * (tack + elastic stress). Their
// stiffness rises with that stress, too, as more asperities touch: under a constant one they slip after a compression
// of kSlip.
inline constexpr std::array<double, kFoamSliders> kFriction = {0.03, 0.04, 0.05, 0.05, 0.05};
inline constexpr std::array<double, kFoamSliders> kSlip = {0.003, 0.008, 0.02, 0.045, 0.1};
inline constexpr double kTackPsi = 0.6;
// Softening by the greatest compression so far: a part at once, a part with the way gone; it recovers slowly.
inline constexpr double kSofteningAtOnce = 0.15;
inline constexpr double kSofteningByTravel = 0.10;
inline constexpr double kSofteningTravel = 0.8;
inline constexpr double kRecoverySeconds = 8.0 * 3600.0;
// Capacitance against its own at rest, read against a fixed one: a bridge.
inline constexpr double kSolidShare = 0.75;  // permittivity 1 + kSolidShare / (1 - e)
inline constexpr double kFixedCapacitance = 3.0;
inline constexpr double kAmplitudeV = 12.5;
inline constexpr double kZeroV = 0.05;
// The skin carries a share of a difference in pressure to a neighbour.
inline constexpr double kSkin = 0.02;
inline constexpr double kCornerSkin = 0.006;
// Spread over taxels, of the logarithm; of the lock, in compression. Density follows the sheet's thickness.
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
// The longest pieces that a call is cut into.
inline constexpr double kPiecePsi = 0.5;
inline constexpr double kPieceSeconds = 0.1;
inline constexpr double kPieceOfCalm = 0.5;  // of the time that the load has been held
inline constexpr double kCalmPsi = 0.01;
}  // namespace foam

struct FoamTaxelState {
  double load_psi = 0.0;                          // local pressure
  double strain = 0.0;                            // compression, share of the thickness
  double greatest = 0.0;                          // strain, recovering
  double worked_in = 0.0;                         // follows `greatest` with the way gone
  std::array<double, kFoamBranches> unrelaxed{};  // of the strain
  std::array<double, kFoamSliders> friction_psi{};
};

struct FoamMemory {
  std::vector<FoamTaxelState> taxels;
  double calm_s = 0.0;  // since the load last changed
};

class Foam {
 public:
  // Draws the constants of each taxel; what stays of `make` is scaled to the foam.
  Foam(const SpecimenOptions& options, FilmMake& make);

  [[nodiscard]] FoamMemory begin() const { return {std::vector<FoamTaxelState>(taxels_.size()), 0.0}; }
  // Goes to `local_psi` evenly within `seconds`. It is changed to what arrives through the skin.
  void advance(FoamMemory& memory, std::vector<double>& local_psi, double seconds) const;
  // Output of a taxel as a share of its amplitude.
  [[nodiscard]] double response(const FoamMemory& memory, std::size_t taxel) const;

 private:
  struct Taxel {
    double plateau_psi, knee, densifying_psi, lock, softening_at_once, softening_by_travel, solid_share, fixed,
        slowest_per_s;
    std::array<double, kFoamBranches> relaxing{};
    std::array<double, kFoamSliders> friction{}, stiffness{};  // stiffness: per psi of the stress that presses
  };
  static void move(const Taxel& taxel, FoamTaxelState& state, double load_psi, double seconds);
  NeighbourLinks skin_;
  std::vector<Taxel> taxels_;
};

}  // namespace tactbench::bench
