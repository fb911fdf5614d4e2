#include "bench/simulation/contact.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace tactbench::bench {
namespace {

constexpr double kPsiPerNewtonPerMm2 = 145.038;
constexpr double kFrictionTravelMm = 0.05;  // of the tip, from full friction one way to none
constexpr double kSlower = 10.0;
constexpr double kRelaxedN = 1e-6;  // less is nothing
constexpr int kEdgeSamples = 6;     // a taxel's side: the blurred edge is wide against pitch / kEdgeSamples
constexpr int kRings = 4000;
constexpr double kReach = 8.0;  // standard deviations beyond the edge: nothing is left there

}  // namespace

Contact::Contact(const ContactOptions& options, int rows, int columns)
    : options_(options), rows_(rows), columns_(columns), x_mm_(std::numeric_limits<double>::quiet_NaN()), y_mm_(x_mm_) {
  const auto taxels = static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns);
  psi_per_newton_.assign(taxels, 0.0);
  if (!(options.fabric_spread_mm > 0.0 && options.pitch_mm > 0.0)) {
    throw std::invalid_argument("contact: fabric_spread_mm and pitch_mm must be above 0");
  }
  if (options.object == Footprint::kRing && !(options.outer_diameter_mm > options.inner_diameter_mm)) {
    throw std::invalid_argument("contact: outer_diameter_mm must be above inner_diameter_mm");
  }
  const double outer = options.object == Footprint::kRing ? options.outer_diameter_mm : options.point_diameter_mm;
  const double reach = 0.5 * outer + kReach * options.fabric_spread_mm;
  const double step = reach / kRings;
  for (int i = 0; i < kRings; ++i) {
    const double r = (i + 0.5) * step;
    whole_mm2_ += 2.0 * std::numbers::pi * r * density(r) * step;
  }
}

// The footprint's edge blurred as a straight one: exact where the radius is large against the spread.
double Contact::density(double distance_mm) const {
  const double blur = std::numbers::sqrt2 * options_.fabric_spread_mm;
  const auto inside = [&](double diameter) { return 0.5 * std::erfc((distance_mm - 0.5 * diameter) / blur); };
  if (options_.object == Footprint::kPoint) return inside(options_.point_diameter_mm);
  const double hole = options_.inner_diameter_mm > 0.0 ? inside(options_.inner_diameter_mm) : 0.0;
  return inside(options_.outer_diameter_mm) - hole;
}

void Contact::advance(ContactState& state, double z_mm, double seconds) const {
  if (!state.placed) {
    state.placed = true;
    state.tip_mm = z_mm;
  }
  // Backlash: pushed at once, pulled back only once the screw has taken up its play.
  const double tip = std::clamp(state.tip_mm, z_mm, z_mm + options_.backlash_mm);
  state.friction = std::clamp(state.friction + (tip - state.tip_mm) / kFrictionTravelMm, -1.0, 1.0);
  state.tip_mm = tip;
  const double depth = std::max(0.0, tip - options_.surface_z_mm);
  const double elastic = (options_.stiffness_n_per_mm + options_.stiffening_n_per_mm2 * depth) * depth;
  double given_in = 0.0;
  double time_constant = options_.relaxation_s;
  for (double& relaxed : state.relaxed_n) {
    if (elastic > 0.0 || relaxed > 0.0) relaxed = elastic + (relaxed - elastic) * std::exp(-seconds / time_constant);
    if (elastic == 0.0 && relaxed < kRelaxedN) relaxed = 0.0;
    given_in += 0.5 * options_.relaxation_share * relaxed;
    time_constant *= kSlower;
  }
  state.force_n = std::max(0.0, elastic * (1.0 + options_.friction_share * state.friction) - given_in);
}

bool Contact::quiet(const ContactState& state) const {
  return state.placed && state.tip_mm <= options_.surface_z_mm && state.relaxed_n[0] == 0.0 &&
         state.relaxed_n[1] == 0.0;
}

const std::vector<double>& Contact::psi_per_newton(double x_mm, double y_mm) {
  if (x_mm == x_mm_ && y_mm == y_mm_) return psi_per_newton_;
  x_mm_ = x_mm;
  y_mm_ = y_mm;
  const double pitch = options_.pitch_mm;
  if (options_.object == Footprint::kFlat) {
    const double area = pitch * pitch * static_cast<double>(psi_per_newton_.size());
    std::fill(psi_per_newton_.begin(), psi_per_newton_.end(), kPsiPerNewtonPerMm2 / area);
    return psi_per_newton_;
  }
  // The object's axis as the array sees it, from the array's centre.
  const double turn = -options_.misplaced_deg * std::numbers::pi / 180.0;
  const double dx = x_mm - options_.centre_x_mm - options_.misplaced_x_mm;
  const double dy = y_mm - options_.centre_y_mm - options_.misplaced_y_mm;
  const double axis_x = std::cos(turn) * dx - std::sin(turn) * dy;
  const double axis_y = std::sin(turn) * dx + std::cos(turn) * dy;
  const double scale = kPsiPerNewtonPerMm2 / (whole_mm2_ * kEdgeSamples * kEdgeSamples);
  std::size_t taxel = 0;
  for (int row = 0; row < rows_; ++row) {
    for (int column = 0; column < columns_; ++column, ++taxel) {
      double sum = 0.0;
      for (int down = 0; down < kEdgeSamples; ++down) {
        const double in_y = (down + 0.5) / kEdgeSamples - 0.5;
        for (int along = 0; along < kEdgeSamples; ++along) {
          const double in_x = (along + 0.5) / kEdgeSamples - 0.5;
          sum += density(std::hypot((column - 0.5 * (columns_ - 1) + in_x) * pitch - axis_x,
                                    (row - 0.5 * (rows_ - 1) + in_y) * pitch - axis_y));
        }
      }
      psi_per_newton_[taxel] = scale * sum;
    }
  }
  return psi_per_newton_;
}

}  // namespace tactbench::bench
