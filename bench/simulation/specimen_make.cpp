#include <algorithm>
#include <cmath>
#include <numeric>

#include "bench/simulation/counter_noise.h"
#include "bench/simulation/specimen_film.h"

namespace tactbench::bench {
namespace {

// Streams of the sensor seed.
enum Stream : std::uint64_t { kThickness = 1, kSensitivity, kExponent, kLiftOff, kFriction, kZero, kCreep, kLag, kAge };

// Inverse of the normal distribution on (0, 1), by bisection: exact to rounding and quick enough for one array.
double normal_quantile(double probability) {
  double low = -8.0;
  double high = 8.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (0.5 * std::erfc(-middle / std::sqrt(2.0)) < probability ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

// One standard normal, truncated at +-kTruncation, per taxel: one value from each of `taxels` equal shares of the
// distribution, dealt out in the order of `keys`.
std::vector<double> deal_normals(const std::vector<double>& keys, std::uint64_t seed, std::uint64_t stream) {
  const std::size_t taxels = keys.size();
  std::vector<std::size_t> order(taxels);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return keys[a] < keys[b]; });
  const double tail = 0.5 * std::erfc(film::kTruncation / std::sqrt(2.0));
  std::vector<double> values(taxels);
  for (std::size_t rank = 0; rank < taxels; ++rank) {
    const double within = uniform_of(hash_of(seed, stream + 1000, rank));
    const double share = (static_cast<double>(rank) + within) / static_cast<double>(taxels);
    values[order[rank]] = normal_quantile(tail + share * (1.0 - 2.0 * tail));
  }
  return values;
}

std::vector<double> white_keys(std::size_t taxels, std::uint64_t seed, std::uint64_t stream) {
  std::vector<double> keys(taxels);
  for (std::size_t i = 0; i < taxels; ++i) keys[i] = bell_of(hash_of(seed, stream, i));
  return keys;
}

// Spin-coated: half of the variance of the film's thickness is a bowl and a tilt across the array.
std::vector<double> thickness_keys(const SpecimenOptions& options) {
  const auto taxels = static_cast<std::size_t>(options.rows) * static_cast<std::size_t>(options.columns);
  std::vector<double> keys = white_keys(taxels, options.sensor_seed, kThickness);
  const auto draw = [&](std::uint64_t index) {
    return bell_of(hash_of(options.sensor_seed, kThickness + 2000, index));
  };
  const double tilt_x = draw(0);
  const double tilt_y = draw(1);
  const double bowl = 1.5 * draw(2);
  std::size_t taxel = 0;
  for (int r = 0; r < options.rows; ++r) {
    for (int c = 0; c < options.columns; ++c, ++taxel) {
      const double y = options.rows > 1 ? 2.0 * r / (options.rows - 1) - 1.0 : 0.0;
      const double x = options.columns > 1 ? 2.0 * c / (options.columns - 1) - 1.0 : 0.0;
      keys[taxel] += tilt_x * x + tilt_y * y + bowl * (x * x + y * y - 0.7);
    }
  }
  return keys;
}

}  // namespace

std::array<double, kFrictionElements> element_shares(double centre, double spread) {
  std::array<double, kFrictionElements> shares{};
  double sum = 0.0;
  for (std::size_t k = 0; k < shares.size(); ++k) {
    const double distance = (film::kWidths[k] - centre) / spread;
    shares[k] = std::exp(-0.5 * distance * distance);
    sum += shares[k];
  }
  for (double& share : shares) share /= sum;
  return shares;
}

FilmMake make_film(const SpecimenOptions& options) {
  const auto taxels = static_cast<std::size_t>(options.rows) * static_cast<std::size_t>(options.columns);
  const std::uint64_t seed = options.sensor_seed;
  const auto white = [&](std::uint64_t stream) { return deal_normals(white_keys(taxels, seed, stream), seed, stream); };
  const auto thickness = deal_normals(thickness_keys(options), seed, kThickness);
  const auto sensitivity = white(kSensitivity);
  const auto exponent = white(kExponent);
  const auto lift_off = white(kLiftOff);
  const auto friction = white(kFriction);
  const auto zero = white(kZero);
  const auto creep = white(kCreep);
  const auto lag = white(kLag);

  FilmMake make;
  make.age_drift = white(kAge);
  make.rest_share = element_shares(film::kRestCentre, film::kRestSpread);
  make.displaced_share = element_shares(film::kDisplacedCentre, film::kDisplacedSpread);
  const auto blend = [](double correlation, double shared, double own) {
    return correlation * shared + std::sqrt(1.0 - correlation * correlation) * own;
  };
  for (std::size_t i = 0; i < taxels; ++i) {
    const double s = blend(film::kAmplitudeSensitivity, thickness[i], sensitivity[i]);
    const double n = blend(film::kSensitivityExponent, s, exponent[i]);
    make.amplitude_v.push_back(film::kAmplitudeV * (1.0 + film::kAmplitudeSpread * thickness[i]));
    make.sensitivity.push_back(std::exp(film::kSensitivitySpread * s));
    make.exponent.push_back(std::max(film::kExponentFloor, film::kExponent + film::kExponentSpread * n));
    make.friction.push_back(std::exp(film::kFrictionSpread * friction[i]));
    make.lift_off_psi.push_back(options.effects.lift_off_psi * std::exp(film::kLiftOffSpread * lift_off[i]));
    make.zero_v.push_back(film::kZeroV * (1.0 + film::kZeroSpread * zero[i]));
    make.creep.push_back(1.0 + film::kCreepSpread * creep[i]);
    make.lag_share.push_back(film::kLagShare * (1.0 + film::kLagSpread * lag[i]));
  }
  return make;
}

}  // namespace tactbench::bench
