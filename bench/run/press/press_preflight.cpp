#include "bench/run/press/press_preflight.h"

#include <fmt/format.h>

#include <algorithm>

namespace tactbench::bench {

double overshoot_n(double speed_mm_per_s, double force_latency_s, double stop_time_s, double stiffness_n_per_mm) {
  return speed_mm_per_s * (force_latency_s + stop_time_s) * stiffness_n_per_mm;
}

namespace {

bool inside(double value, const std::pair<double, double>& limits) {  // NaN is outside
  return value >= limits.first && value <= limits.second;
}

void check_forces(const PressPlanned& planned, const PressOptions& options, const PressEnvelope& envelope,
                  std::vector<std::string>& complaints) {
  const double over =
      overshoot_n(options.servo_mm_per_s, options.force_latency_s, options.stop_time_s, options.stiffest_n_per_mm);
  const double range_n = envelope.overload_share * envelope.force_range[2];
  for (const double force_n : planned.forces_n) {
    if (!(force_n + options.tolerance(force_n) + over <= range_n)) {
      complaints.push_back(
          fmt::format("{:g} N, with its tolerance and {:.2f} N of overshoot ({:g} mm/s x {:g} s x {:g} N/mm), exceed "
                      "the range of Fz in the loaded calibration, {:g} N",
                      force_n, over, options.servo_mm_per_s, options.force_latency_s + options.stop_time_s,
                      options.stiffest_n_per_mm, range_n));
    }
    if (!(force_n + options.tolerance(force_n) + over <= options.force_limit_n)) {
      complaints.push_back(
          fmt::format("{:g} N, with its tolerance and {:.2f} N of overshoot, are beyond the bench's "
                      "force limit of {:g} N",
                      force_n, over, options.force_limit_n));
    }
    if (!(force_n >= options.contact_n)) {
      complaints.push_back(
          fmt::format("{:g} N are less than the {:g} N that count as contact", force_n, options.contact_n));
    }
  }
  if (!(options.force_limit_n <= range_n)) {
    complaints.push_back(
        fmt::format("the bench's force limit of {:g} N exceeds the {:g} N of the loaded calibration: passing it would "
                    "not be detected",
                    options.force_limit_n, range_n));
  }
  if (planned.forces_n.empty()) return;
  // The approach presses too: between two readings of the force, and then until the stage has stopped.
  const double lowest_n = *std::min_element(planned.forces_n.begin(), planned.forces_n.end());
  const double search_n =
      options.contact_n + overshoot_n(options.approach_mm_per_s, options.poll_interval_s + options.force_latency_s,
                                      options.stop_time_s, options.stiffest_n_per_mm);
  if (!(search_n <= options.force_limit_n)) {
    complaints.push_back(
        fmt::format("the search at {:g} mm/s may press {:.1f} N at {:g} N/mm before it stops, beyond "
                    "the bench's force limit of {:g} N",
                    options.approach_mm_per_s, search_n, options.stiffest_n_per_mm, options.force_limit_n));
  }
  const double step_n = options.resolution_mm * options.stiffest_n_per_mm;
  if (!(step_n <= options.tolerance(lowest_n))) {
    complaints.push_back(
        fmt::format("the smallest move of z changes the force by {:.3f} N at {:g} N/mm, more than the "
                    "tolerance of {:.3f} N at {:g} N",
                    step_n, options.stiffest_n_per_mm, options.tolerance(lowest_n), lowest_n));
  }
}

void check_places(const PressPlanned& planned, const PressOptions& options, const PressEnvelope& envelope,
                  std::vector<std::string>& complaints) {
  const auto check = [&](const std::string& what, double value, std::size_t axis) {
    const auto& limits = envelope.axes_mm.at(axis);
    if (inside(value, limits)) return;
    complaints.push_back(
        fmt::format("{} = {:g} mm is outside the axis' {:g} to {:g} mm", what, value, limits.first, limits.second));
  };
  for (const auto& [x_mm, y_mm] : planned.positions_mm) {
    check("x", x_mm, 0);
    check("y", y_mm, 1);
  }
  for (const auto& [key, speed] :
       {std::pair("approach_mm_per_s", options.approach_mm_per_s), std::pair("servo_mm_per_s", options.servo_mm_per_s)})
    if (!(speed <= options.travel_mm_per_s))
      complaints.push_back(
          fmt::format("{} = {:g} is more than the {:g} mm/s allowed for z", key, speed, options.travel_mm_per_s));
  check("clear z", options.clear_z_mm, 2);
  check("deepest z", options.max_z_mm, 2);
  if (!(options.clear_z_mm < options.max_z_mm)) complaints.emplace_back("clear z is not above the deepest z");
}

}  // namespace

std::vector<std::string> press_complaints(const PressPlanned& planned, const PressOptions& options,
                                          const PressEnvelope& envelope) {
  std::vector<std::string> complaints;
  check_forces(planned, options, envelope, complaints);
  check_places(planned, options, envelope, complaints);
  return complaints;
}

}  // namespace tactbench::bench
