// The matrices of an ATI calibration: from gauge volts to newtons and N*mm, and from one frame to another. Not verified
// on hardware.
#pragma once

#include <Eigen/Core>

#include "devices/force/ati_calibration.h"
#include "devices/force/options.h"

namespace tactbench::devices {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

// Maps a wrench (N, N*mm) from one frame to the frame that `transform` describes: F' = R F, T' = R (T - D x F). R is
// Rz(-z) Ry(-y) Rx(-x), as in ATI's library: R[0][1] = sx sy cz + cx sz, R[2][0] = sy.
Matrix6 wrench_transform(const AtiTransform& transform);
// Newtons and N*mm per volt, Fx to Tz, in the transducer's frame.
Matrix6 working_matrix(const AtiCalibration& calibration);
// Rated range of each axis, N and N*mm, in the transducer's frame.
SixAxes rated_range(const AtiCalibration& calibration);
// Gauge volts corrected to the calibration's temperature: (G + bs dT) / (1 - gs dT), where dT is the thermistor's volts
// minus those at calibration. Software bias is taken and removed after this.
Vector6 compensated(const AtiTemperature& temperature, const Vector6& gauges, double thermistor_v);

}  // namespace tactbench::devices
