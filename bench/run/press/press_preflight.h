// Checks before any motion whether a press plan fits force sensor, bench and axes, including the overshoot.
#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "bench/run/press/press_axis.h"

namespace tactbench::bench {

// Rise of the force from passing a threshold until the stage has stopped: speed x (force latency + stop time) x
// stiffness.
[[nodiscard]] double overshoot_n(double speed_mm_per_s, double force_latency_s, double stop_time_s,
                                 double stiffness_n_per_mm);

struct PressPlanned {
  std::vector<std::pair<double, double>> positions_mm;  // x, y
  std::vector<double> forces_n;
};

struct PressEnvelope {
  std::array<double, 6> force_range{};                 // ForceSensor::range()
  double overload_share = 1.0;                         // share of the range at which the sensor's driver throws a fault
  std::array<std::pair<double, double>, 3> axes_mm{};  // low and high of x, y, z, inclusive
};

// Checks `planned` with `options`: one sentence per problem, empty if there is none. NaN is a problem.
[[nodiscard]] std::vector<std::string> press_complaints(const PressPlanned& planned, const PressOptions& options,
                                                        const PressEnvelope& envelope);

}  // namespace tactbench::bench
