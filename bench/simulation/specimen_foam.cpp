#include "bench/simulation/specimen_foam.h"

#include <algorithm>
#include <cmath>

#include "bench/simulation/counter_noise.h"
#include "bench/simulation/specimen_film.h"

namespace tactbench::bench {
namespace {

// Streams of the sensor's seed.
enum FoamStream : std::uint64_t { kFoamShape = 90, kSkinLinks };

constexpr int kNewtonSteps = 60;
constexpr double kBalancedPsi = 1e-9;

// Secant stiffness and its slope.
struct Secant {
  double psi, slope;
};

template <typename Taxel>
Secant secant(const Taxel& taxel, double strain) {
  if (strain < 0.0) return {taxel.plateau_psi / taxel.knee, 0.0};
  const double soft = 1.0 / (strain + taxel.knee), room = 1.0 / (taxel.lock - strain);
  const double packed = taxel.densifying_psi * room * room;
  return {taxel.plateau_psi * soft + packed * strain,
          -taxel.plateau_psi * soft * soft + packed * (taxel.lock + strain) * room};
}

}  // namespace

Foam::Foam(const SpecimenOptions& options, FilmMake& make)
    : skin_(options, kSkinLinks, foam::kSkin, foam::kCornerSkin) {
  for (std::size_t i = 0; i < make.amplitude_v.size(); ++i) {
    Scatter scatter(hash_of(options.sensor_seed, kFoamShape, i));
    const auto around = [&](double usual, double spread) { return scatter.around(usual, spread); };
    // Where the sheet is thick it is less dense.
    const double thick = std::log(make.sensitivity[i]) / film::kSensitivitySpread;
    const double density = std::exp(-foam::kDensitySpread * thick);
    Taxel taxel{};
    taxel.plateau_psi = density * around(foam::kPlateauPsi, foam::kElasticSpread);
    taxel.knee = around(foam::kKnee, foam::kKneeSpread);
    taxel.densifying_psi = density * around(foam::kDensifyingPsi, foam::kElasticSpread);
    taxel.lock = foam::kLock + foam::kLockSpread * scatter.normal();
    taxel.softening_at_once = around(foam::kSofteningAtOnce, foam::kSofteningSpread);
    taxel.softening_by_travel = around(foam::kSofteningByTravel, foam::kSofteningSpread);
    taxel.solid_share = around(foam::kSolidShare, foam::kReadoutSpread);
    taxel.fixed = around(foam::kFixedCapacitance, foam::kReadoutSpread);
    const double warm = std::exp(foam::kShiftPerKelvin * (options.temperature_c - film::kReferenceCelsius));
    taxel.slowest_per_s = warm / around(foam::kSlowestSeconds, foam::kTimeSpread);
    for (std::size_t j = 0; j < kFoamBranches; ++j)
      taxel.relaxing[j] = around(foam::kRelaxing[j], foam::kRelaxingSpread);
    for (std::size_t k = 0; k < kFoamSliders; ++k) {
      taxel.friction[k] = around(foam::kFriction[k], foam::kFrictionSpread);
      taxel.stiffness[k] = taxel.friction[k] / around(foam::kSlip[k], foam::kSlipSpread);
    }
    taxels_.push_back(taxel);
    make.sensitivity[i] = around(1.0, foam::kAreaSpread);
    make.lag_share[i] = 0.0;
    make.amplitude_v[i] *= foam::kAmplitudeV / film::kAmplitudeV;
    make.zero_v[i] *= foam::kZeroV / film::kZeroV;
  }
}

void Foam::advance(FoamMemory& memory, std::vector<double>& local_psi, double seconds) const {
  skin_.couple(local_psi);
  double change = 0.0;
  for (std::size_t i = 0; i < local_psi.size(); ++i)
    change = std::max(change, std::abs(local_psi[i] - memory.taxels[i].load_psi));
  const bool held = change < foam::kCalmPsi;
  const double pieces = std::max(1.0, std::ceil(change / foam::kPiecePsi));
  for (double left = seconds; left > 0.0;) {
    double piece = held ? std::max(foam::kPieceSeconds, foam::kPieceOfCalm * memory.calm_s) : seconds / pieces;
    // No sliver at the end.
    if (left < 1.01 * piece) piece = left;
    for (std::size_t i = 0; i < local_psi.size(); ++i) {
      FoamTaxelState& state = memory.taxels[i];
      move(taxels_[i], state, state.load_psi + (local_psi[i] - state.load_psi) * piece / left, piece);
    }
    left -= piece;
    memory.calm_s = held ? memory.calm_s + piece : 0.0;
  }
}

// One piece: the strain is taken to change evenly in it, for which each branch's relaxation is exact; the strain then
// follows from the balance at its end, which rises with the strain.
void Foam::move(const Taxel& taxel, FoamTaxelState& state, double load_psi, double seconds) {
  const double softened = 1.0 - taxel.softening_at_once * state.greatest - taxel.softening_by_travel * state.worked_in;
  std::array<double, kFoamBranches> gained{};
  double kept = 0.0, gaining = 0.0;
  double times = seconds * taxel.slowest_per_s, lost = -std::expm1(-times);
  for (std::size_t j = kFoamBranches; j-- > 0;) {
    gained[j] = lost / times;
    state.unrelaxed[j] -= state.unrelaxed[j] * lost;
    kept += taxel.relaxing[j] * state.unrelaxed[j];
    gaining += taxel.relaxing[j] * gained[j];
    // The next is eight times as quick: 1 - (1 - lost)^8.
    times *= 8.0;
    for (int doubling = 0; doubling < 3; ++doubling) lost *= 2.0 - lost;
  }
  const std::array<double, kFoamSliders> friction_before = state.friction_psi;
  const double before = state.strain;
  const double normal_before = foam::kTackPsi + std::max(0.0, before) * secant(taxel, before).psi;
  double low = -0.2, high = taxel.lock, strain = before;
  for (int step = 0; step < kNewtonSteps; ++step) {
    const Secant now = secant(taxel, strain);
    const double stretched = softened * strain + kept + gaining * (strain - before);
    double excess = now.psi * stretched - load_psi;
    double slope = now.slope * stretched + now.psi * (softened + gaining);
    const bool pressed = strain > 0.0;
    const double normal = foam::kTackPsi + (pressed ? now.psi * strain : 0.0);
    const double normal_slope = pressed ? now.psi + now.slope * strain : 0.0;
    const double held = 0.5 * (normal_before + normal), held_slope = held + 0.5 * normal_slope * (strain - before);
    for (std::size_t k = 0; k < kFoamSliders; ++k) {
      const double limit = taxel.friction[k] * normal;
      const double stuck = friction_before[k] + taxel.stiffness[k] * held * (strain - before);
      const bool slips = std::abs(stuck) > limit;
      state.friction_psi[k] = slips ? std::copysign(limit, stuck) : stuck;
      excess += state.friction_psi[k];
      slope += slips ? std::copysign(taxel.friction[k], stuck) * normal_slope : taxel.stiffness[k] * held_slope;
    }
    if (std::abs(excess) < kBalancedPsi) break;
    (excess > 0.0 ? high : low) = strain;
    const double next = strain - excess / slope;
    strain = next > low && next < high ? next : 0.5 * (low + high);
  }
  for (std::size_t j = 0; j < kFoamBranches; ++j) state.unrelaxed[j] += gained[j] * (strain - before);
  state.load_psi = load_psi;
  state.strain = strain;
  const double forgotten = seconds / (seconds + foam::kRecoverySeconds);
  state.greatest = std::max(strain, state.greatest + (strain - state.greatest) * forgotten);
  const double way = std::abs(strain - before);
  state.worked_in += (state.greatest - state.worked_in) *
                     (state.worked_in < state.greatest ? way / (way + foam::kSofteningTravel) : 1.0);
}

double Foam::response(const FoamMemory& memory, std::size_t taxel) const {
  const Taxel& made = taxels_[taxel];
  const double gap = 1.0 - std::max(0.0, memory.taxels[taxel].strain);
  const double capacitance = (1.0 + made.solid_share / gap) / (gap * (1.0 + made.solid_share));
  return capacitance / (capacitance + made.fixed) - 1.0 / (1.0 + made.fixed);
}

}  // namespace tactbench::bench
