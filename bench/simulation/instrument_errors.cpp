#include "bench/simulation/instrument_errors.h"

#include <algorithm>
#include <cmath>

#include "bench/simulation/counter_noise.h"

namespace tactbench::bench {

namespace {

constexpr double kSpanPsi = 60.0;          // where the certificate's span part is whole
constexpr double kPlayPsi = 3.0;           // way over which the transducer's hysteresis turns
constexpr double kUsualC = 23.0;           // at which the reference was calibrated
constexpr double kWarmK = 5.0;             // away from it the limit of its temperature holds
constexpr double kForceFullScaleN = 35.0;  // of the simulated Nano17, along z

enum InstrumentStream : std::uint64_t { kNormal = 201, kEven };

class ErrorDraw {
 public:
  explicit ErrorDraw(std::uint64_t seed) : seed_(seed) {}
  double normal() { return bell_of(hash_of(seed_, kNormal, counter_++)); }
  double even(double half_width) { return half_width * (2.0 * uniform_of(hash_of(seed_, kEven, counter_++)) - 1.0); }

 private:
  std::uint64_t seed_, counter_ = 0;
};

}  // namespace

// The order of the draws is part of what a seed means.
InstrumentErrors::InstrumentErrors(const InstrumentOptions& options) : options_(options) {
  if (options.seed == 0) return;
  ErrorDraw draw(options.seed);
  zero_share_ = draw.normal();
  span_share_ = draw.normal();
  constant_psi_ = draw.even(options.reference.drift) + draw.even(options.reference.input) + draw.even(options.zero_psi);
  hysteresis_psi_ = std::abs(draw.even(options.hysteresis_psi));
  temperature_psi_ = draw.even(options.temperature_psi);
  const DrawnLimits &force = options.force_n, &thermometer = options.thermometer_c;
  force_share_ =
      (force.certificate_u * draw.normal() + draw.even(force.drift) + draw.even(force.input)) / kForceFullScaleN;
  thermometer_c_ =
      thermometer.certificate_u * draw.normal() + draw.even(thermometer.drift) + draw.even(thermometer.input);
}

void InstrumentErrors::follow(double pressure_psi) {
  followed_psi_ = std::clamp(followed_psi_, pressure_psi - kPlayPsi, pressure_psi + kPlayPsi);
}

double InstrumentErrors::certificate_u(double pressure_psi) const {
  const std::vector<double>&at = options_.reading_psi, &u = options_.certificate_u_psi;
  if (u.empty()) return 0.0;
  const auto above = static_cast<std::size_t>(std::ranges::upper_bound(at, pressure_psi) - at.begin());
  if (above == 0) return u.front();
  if (above == at.size()) return u.back();
  return std::lerp(u[above - 1], u[above], (pressure_psi - at[above - 1]) / (at[above] - at[above - 1]));
}

double InstrumentErrors::reference_psi(double pressure_psi, double temperature_c) const {
  if (options_.seed == 0) return 0.0;
  const double span = std::clamp(pressure_psi / kSpanPsi, 0.0, 1.0), zero = 1.0 - span;
  const double drawn = (zero * zero_share_ + span * span_share_) / std::hypot(zero, span);
  const double warm = std::clamp((temperature_c - kUsualC) / kWarmK, -1.0, 1.0);
  return certificate_u(pressure_psi) * drawn + constant_psi_ -
         hysteresis_psi_ * (pressure_psi - followed_psi_) / kPlayPsi + temperature_psi_ * warm;
}

double InstrumentErrors::force_n(double force_n) const { return force_share_ * force_n; }

}  // namespace tactbench::bench
