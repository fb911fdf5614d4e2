// The harsh film: effects that the paper's specimen does not have, so that models and compensation are tested on a
// sensor that was not tuned to one paper's figures. Equations and measured figures: bench/simulation/README.md.
// Everything is determined by the sensor's seed (constants) and the noise's seed (differences from run to run): the
// same seeds give the same outputs.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "bench/config/plant_options.h"
#include "bench/simulation/neighbour_links.h"

namespace tactbench::bench {

struct FilmMake;
struct FilmMemory;

inline constexpr std::size_t kHarshCreepTimes = 6;

// Constants set by hand with sensor seeds 1 to 3; the tests use others.
namespace harsh {
// Spread over taxels of constants that are equal for all taxels of the paper's specimen (of the logarithm, or in units
// of the widths).
inline constexpr double kWidthSpread = 0.25;
inline constexpr double kCentreSpread = 0.3;
inline constexpr double kHalfSpread = 0.3;
inline constexpr double kPeakSpread = 0.15;
inline constexpr double kSoftnessSpread = 0.25;
inline constexpr double kCreepShareSpread = 0.3;
inline constexpr double kSlideSpread = 0.15;
inline constexpr double kSlideShareSpread = 0.1;
// Friction of all taxels relative to the paper's specimen; the widest element times friction stays below the cap, so
// that its upper bound rises with the load.
inline constexpr double kFriction = 0.93;
inline constexpr double kWidestCap = 5.5;
inline constexpr double kAmplitude = 1.14;
inline constexpr double kZeroV = 0.06;
// Sliding: drag = share * f(q) * s, and s approaches +1 or -1 within some psi of loading or unloading. It has no memory
// of turning points, so inner loops do not close, which no Preisach model with any readout can reproduce.
inline constexpr double kSlidePsi = 15.0;
inline constexpr double kSlideShare = 0.25;
// Share of the contact that follows the load immediately: more than sliding removes after a turn, so that no output
// falls while the load rises.
inline constexpr double kReversible = 0.2;
// Friction from cycle to cycle: drawn anew at each knot of the load's path length.
inline constexpr double kCycleFriction = 0.07;
inline constexpr double kCycleKnotPsi = 100.0;
// Creep: equal shares at relaxation times ten times apart add up to a straight line over the logarithm of time.
inline constexpr std::array<double, kHarshCreepTimes> kCreepSeconds = {0.1, 1.0, 10.0, 100.0, 1e3, 1e4};
inline constexpr double kCreepShare = 0.06;
// Random walks: standard deviation over an hour, and their duration before the run begins.
inline constexpr double kZeroWalkV = 0.0035;
inline constexpr double kGainWalk = 0.003;
inline constexpr double kWalkKnotS = 10.0;
inline constexpr double kWalkBeforeS = 4.0 * 3600.0;
// Electrical coupling of neighbours in row and column, and across a corner; each link differs by up to half of it.
inline constexpr double kCoupling = 0.02;
inline constexpr double kCornerCoupling = 0.005;
// 1/f noise of the film, as a share of its output: equal variance in each octave of periods from 1 s to 34 min.
inline constexpr int kFlickerOctaves = 12;
inline constexpr double kFlicker = 0.0003;
}  // namespace harsh

struct HarshMemory {
  std::vector<double> load_psi;      // local pressure of the last advance, per taxel
  std::vector<double> sliding;       // -1..1
  std::vector<double> drag_psi;      // pressure that sliding removes from the contact
  std::vector<double> zero_v, gain;  // present values of the random walks
  double path_psi = 0.0;             // path length of the load, both directions
  double time_s = 0.0;               // simulated time so far
};

class HarshFilm {
 public:
  // Uses the spread of `make` and scales its amplitude and zero.
  HarshFilm(const SpecimenOptions& options, FilmMake& make);

  // A new film at the start of a run.
  void begin(FilmMemory& state) const;
  // local_psi: one value per taxel, 0 or more. friction_now: the virgin film's factor.
  void advance(FilmMemory& state, std::span<const double> local_psi, double seconds, double friction_now) const;
  // Output of a taxel as a share of its amplitude, including the random walk of the gain.
  [[nodiscard]] double response(const FilmMemory& state, std::size_t taxel) const;
  // Moves the outputs of neighbours toward each other.
  void couple(std::span<double> volts) const { links_.couple(volts); }
  // Adds the film's 1/f noise at `time_s` of process time.
  void add_flicker(double time_s, std::span<double> volts) const;

 private:
  struct Taxel {
    std::array<double, 6> width{}, rest_share{}, displaced_share{};
    std::array<double, kHarshCreepTimes> creep_share{};
    double friction = 0.0, friction_square = 0.0, displaced_half_psi = 0.0, exponent = 0.0, softness = 0.0;
    double slide_psi = 0.0, slide_share = 0.0;
  };
  [[nodiscard]] Taxel make_taxel(const FilmMake& make, std::size_t taxel) const;
  void walk(HarshMemory& own, std::uint64_t knot, double knots) const;

  std::uint64_t sensor_seed_, run_key_;
  NeighbourLinks links_;
  std::vector<Taxel> taxels_;
};

// Noise of one sample: Student's t with 5 degrees of freedom, scaled to standard deviation 1 (kurtosis 9).
double heavy_tailed_of(std::uint64_t hash);

}  // namespace tactbench::bench
