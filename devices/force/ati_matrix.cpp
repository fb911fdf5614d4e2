#include "devices/force/ati_matrix.h"

#include <Eigen/Geometry>
#include <numbers>

#include "devices/force/ati_calibration.h"

namespace tactbench::devices {
namespace {

Vector6 file_units(const AtiCalibration& calibration) {
  const double force = newtons_in(calibration.force_unit).value();
  const double torque = newton_millimetres_in(calibration.torque_unit).value();
  return (Vector6() << force, force, force, torque, torque, torque).finished();
}

}  // namespace

Matrix6 wrench_transform(const AtiTransform& transform) {
  constexpr double kRadians = std::numbers::pi / 180.0;
  const auto& [x, y, z] = transform.rotation_deg;
  const auto& [dx, dy, dz] = transform.displacement_mm;
  const Eigen::Matrix3d rotation = (Eigen::AngleAxisd(-z * kRadians, Eigen::Vector3d::UnitZ()) *
                                    Eigen::AngleAxisd(-y * kRadians, Eigen::Vector3d::UnitY()) *
                                    Eigen::AngleAxisd(-x * kRadians, Eigen::Vector3d::UnitX()))
                                       .toRotationMatrix();
  Eigen::Matrix3d cross;  // cross * F = D x F
  cross << 0.0, -dz, dy, dz, 0.0, -dx, -dy, dx, 0.0;
  Matrix6 matrix;
  matrix << rotation, Eigen::Matrix3d::Zero(), -rotation * cross, rotation;
  return matrix;
}

Matrix6 working_matrix(const AtiCalibration& calibration) {
  const auto& axes = calibration.user_axes ? *calibration.user_axes : calibration.axes;
  Matrix6 matrix;
  for (int row = 0; row < 6; ++row) {
    const AtiAxis& axis = axes[static_cast<std::size_t>(row)];
    matrix.row(row) = Eigen::Map<const Vector6>(axis.values.data()).transpose() / axis.scale;
  }
  matrix = file_units(calibration).asDiagonal() * matrix;
  return calibration.user_axes ? matrix : Matrix6(wrench_transform(calibration.basic) * matrix);
}

SixAxes rated_range(const AtiCalibration& calibration) {
  const auto& axes = calibration.user_axes ? *calibration.user_axes : calibration.axes;
  const Vector6 units = file_units(calibration);
  SixAxes range{};
  for (std::size_t i = 0; i < 6; ++i) range[i] = axes[i].max * units[static_cast<Eigen::Index>(i)];
  return range;
}

Vector6 compensated(const AtiTemperature& temperature, const Vector6& gauges, double thermistor_v) {
  const double change = thermistor_v - temperature.thermistor_v;
  const Eigen::Map<const Vector6> bias(temperature.bias_slope.data());
  const Eigen::Map<const Vector6> gain(temperature.gain_slope.data());
  return ((gauges + bias * change).array() / (1.0 - gain.array() * change)).matrix();
}

}  // namespace tactbench::devices
