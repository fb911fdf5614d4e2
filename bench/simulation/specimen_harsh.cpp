#include "bench/simulation/specimen_harsh.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bench/simulation/counter_noise.h"
#include "bench/simulation/specimen_film.h"

namespace tactbench::bench {
namespace {

// Streams of the sensor's seed, and of the run's.
enum HarshStream : std::uint64_t { kShape = 70, kLinks, kRun, kCycles, kWalks, kStart, kFlickerStream };

constexpr double kHalf = std::numbers::sqrt2 / 2.0;  // common and own part have half of the variance each

// What lies between two knots: weights whose squares add up to 1, so that the variance is the same everywhere.
struct Between {
  std::uint64_t knot;
  double here, next;
};

Between between_knots(double place) {
  const double knot = std::floor(place);
  const double angle = 0.5 * std::numbers::pi * (place - knot);
  return {static_cast<std::uint64_t>(knot), std::cos(angle), std::sin(angle)};
}

double relaxed(double value, double target, double kept) { return target + (value - target) * kept; }

}  // namespace

double heavy_tailed_of(std::uint64_t hash) {
  // Bailey, Mathematics of Computation 62 (1994), 779: Student's t from two uniforms.
  constexpr double kDegrees = 5.0;
  const double u = uniform_of(hash);
  const double v = uniform_of(mix64(hash ^ 0x5851F42D4C957F2DULL));
  const double t = std::sqrt(kDegrees * (std::pow(u, -2.0 / kDegrees) - 1.0)) * std::cos(2.0 * std::numbers::pi * v);
  return t * std::sqrt((kDegrees - 2.0) / kDegrees);
}

HarshFilm::HarshFilm(const SpecimenOptions& options, FilmMake& make)
    : sensor_seed_(options.sensor_seed),
      run_key_(hash_of(options.seed, kRun, options.sensor_seed)),
      links_(options, kLinks, harsh::kCoupling, harsh::kCornerCoupling) {
  for (std::size_t i = 0; i < make.amplitude_v.size(); ++i) {
    taxels_.push_back(make_taxel(make, i));
    make.amplitude_v[i] *= harsh::kAmplitude;
    make.zero_v[i] *= harsh::kZeroV / film::kZeroV;
  }
}

HarshFilm::Taxel HarshFilm::make_taxel(const FilmMake& make, std::size_t taxel) const {
  Scatter scatter(hash_of(sensor_seed_, kShape, taxel));
  const auto normal = [&] { return scatter.normal(); };
  const auto scattered = [&](double usual, double spread) { return scatter.around(usual, spread); };
  Taxel made;
  made.friction = harsh::kFriction * make.friction[taxel];
  for (std::size_t k = 0; k < made.width.size(); ++k)
    made.width[k] =
        std::min(scattered(film::kWidths[k], harsh::kWidthSpread), harsh::kWidestCap / std::max(made.friction, 1e-9));
  made.rest_share = element_shares(film::kRestCentre + harsh::kCentreSpread * normal(), film::kRestSpread);
  made.displaced_share =
      element_shares(film::kDisplacedCentre + harsh::kCentreSpread * normal(), film::kDisplacedSpread);
  const double peak = scattered(film::kFrictionPeakPsi, harsh::kPeakSpread);
  made.friction_square = 1.0 / (peak * peak);
  made.displaced_half_psi = scattered(film::kDisplacedHalfPsi, harsh::kHalfSpread);
  made.exponent = make.exponent[taxel];
  made.softness = scattered(1.0, harsh::kSoftnessSpread);
  for (double& share : made.creep_share)
    share = make.creep[taxel] * scattered(harsh::kCreepShare, harsh::kCreepShareSpread);
  made.slide_psi = scattered(harsh::kSlidePsi, harsh::kSlideSpread);
  made.slide_share = scattered(harsh::kSlideShare, harsh::kSlideShareSpread);
  return made;
}

void HarshFilm::begin(FilmMemory& state) const {
  const std::size_t count = taxels_.size();
  state.creep.assign(kHarshCreepTimes, std::vector<double>(count, 0.0));
  HarshMemory own;
  for (auto* values : {&own.load_psi, &own.sliding, &own.drag_psi, &own.zero_v, &own.gain}) values->assign(count, 0.0);
  std::ranges::fill(own.sliding, -1.0);
  walk(own, 0, harsh::kWalkBeforeS / harsh::kWalkKnotS);
  state.harsh = own;
}

// One draw for `knots` knots at once.
void HarshFilm::walk(HarshMemory& own, std::uint64_t knot, double knots) const {
  const double hours = knots * harsh::kWalkKnotS / 3600.0;
  const double zero_step = harsh::kZeroWalkV * std::sqrt(hours), gain_step = harsh::kGainWalk * std::sqrt(hours);
  const std::uint64_t key = hash_of(run_key_, kWalks, knot);
  const auto draw = [&](std::uint64_t index) { return bell_of(mix64(key ^ index)); };
  const double common_zero = draw(0), common_gain = draw(1);
  for (std::size_t i = 0; i < taxels_.size(); ++i) {
    own.zero_v[i] += zero_step * kHalf * (common_zero + draw(2 * i + 2));
    own.gain[i] += gain_step * kHalf * (common_gain + draw(2 * i + 3));
  }
}

void HarshFilm::advance(FilmMemory& state, std::span<const double> local_psi, double seconds,
                        double friction_now) const {
  HarshMemory& own = state.harsh;
  double way = 0.0;
  for (std::size_t i = 0; i < taxels_.size(); ++i) way = std::max(way, std::abs(local_psi[i] - own.load_psi[i]));
  own.path_psi += way;
  const Between cycle = between_knots(own.path_psi / harsh::kCycleKnotPsi);
  const std::uint64_t here = hash_of(run_key_, kCycles, cycle.knot);
  const std::uint64_t next = hash_of(run_key_, kCycles, cycle.knot + 1);
  const auto drawn = [&](std::uint64_t index) {
    return cycle.here * bell_of(mix64(here ^ index)) + cycle.next * bell_of(mix64(next ^ index));
  };
  const double common = drawn(0);
  std::array<double, kHarshCreepTimes> kept{};
  for (std::size_t j = 0; j < kept.size(); ++j) kept[j] = std::exp(-seconds / harsh::kCreepSeconds[j]);
  for (std::size_t i = 0; i < taxels_.size(); ++i) {
    const Taxel& taxel = taxels_[i];
    const double q = local_psi[i];
    const double cycles = 1.0 + harsh::kCycleFriction * kHalf * (common + drawn(i + 1));
    const double shape = cycles * q / (1.0 + q * (1.0 / film::kFrictionLinearPsi + q * taxel.friction_square));
    const double friction = friction_now * taxel.friction * shape;
    for (std::size_t k = 0; k < state.plays.size(); ++k) {
      double& play = state.plays[k][i];
      play = std::min(std::max(play, q), q + taxel.width[k] * friction);
    }
    const double change = q - own.load_psi[i];
    if (change != 0.0) {
      own.sliding[i] =
          relaxed(own.sliding[i], change > 0.0 ? 1.0 : -1.0, std::exp(-std::abs(change) / taxel.slide_psi));
      own.load_psi[i] = q;
    }
    own.drag_psi[i] = taxel.slide_share * shape * own.sliding[i];
    const double target = q / (q + film::kCreepHalfPsi);
    for (std::size_t j = 0; j < kept.size(); ++j) state.creep[j][i] = relaxed(state.creep[j][i], target, kept[j]);
  }
  const auto knot_of = [](double time_s) { return static_cast<std::uint64_t>(time_s / harsh::kWalkKnotS); };
  const std::uint64_t first = knot_of(own.time_s);
  own.time_s += seconds;
  for (std::uint64_t knot = first; knot < knot_of(own.time_s); ++knot) walk(own, knot + 1, 1.0);
}

double HarshFilm::response(const FilmMemory& state, std::size_t taxel) const {
  const Taxel& made = taxels_[taxel];
  double rest = 0.0, displaced = 0.0, crept = 0.0;
  for (std::size_t k = 0; k < state.plays.size(); ++k) {
    rest += made.rest_share[k] * state.plays[k][taxel];
    displaced += made.displaced_share[k] * state.plays[k][taxel];
  }
  for (std::size_t j = 0; j < kHarshCreepTimes; ++j) crept += made.creep_share[j] * (state.creep[j][taxel] - 1.0);
  const double widest = state.plays.back()[taxel];
  const double held = rest + (displaced - rest) * widest / (widest + made.displaced_half_psi);
  const double contact = held + harsh::kReversible * (state.harsh.load_psi[taxel] - held) - state.harsh.drag_psi[taxel];
  if (!(contact > 0.0)) return 0.0;
  // The divider's u / (1 + u) where softness is 1; else it saturates earlier or later.
  const double ratio = std::pow(contact / film::kHalfPsi, made.exponent);
  const double share = ratio / std::pow(1.0 + std::pow(ratio, made.softness), 1.0 / made.softness);
  return (1.0 + state.harsh.gain[taxel]) * (1.0 + crept) * share;
}

void HarshFilm::add_flicker(double time_s, std::span<double> volts) const {
  std::vector<double> sum(volts.size(), 0.0);
  double period_s = 1.0;
  for (std::uint64_t octave = 0; octave < harsh::kFlickerOctaves; ++octave, period_s *= 2.0) {
    const Between place = between_knots(time_s / period_s);
    const std::uint64_t stream = kFlickerStream + octave;
    const std::uint64_t here = hash_of(run_key_, stream, place.knot), next = hash_of(run_key_, stream, place.knot + 1);
    for (std::size_t i = 0; i < sum.size(); ++i)
      sum[i] += place.here * bell_of(mix64(here ^ i)) + place.next * bell_of(mix64(next ^ i));
  }
  for (std::size_t i = 0; i < sum.size(); ++i) volts[i] += harsh::kFlicker * sum[i] * volts[i];
}

}  // namespace tactbench::bench
