#include "bench/run/press/registration.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <stdexcept>

#include "analysis/json_io.h"
#include "devices/device.h"

namespace tactbench::bench {

using devices::Fault;
using Eigen::Matrix2d;
using Eigen::Vector2d;
using Points = Eigen::Matrix<double, 2, Eigen::Dynamic>;

namespace {

constexpr const char* kDevice = "sensor mount";

struct PlaneFit {
  Matrix2d turn;  // orthogonal, determinant as asked
  double scale = 1.0;
  Vector2d offset;
  double rms = 0.0;
};

// Least squares of to = scale turn from + offset over orthogonal `turn` with that determinant.
PlaneFit fit(const Points& from, const Points& to, double determinant) {
  const auto count = static_cast<double>(from.cols());
  const Vector2d from_mean = from.rowwise().mean();
  const Vector2d to_mean = to.rowwise().mean();
  const Points a = from.colwise() - from_mean;
  const Points b = to.colwise() - to_mean;
  const Eigen::JacobiSVD<Matrix2d> svd(b * a.transpose(), Eigen::ComputeFullU | Eigen::ComputeFullV);
  Vector2d signs(1.0, determinant * svd.matrixU().determinant() * svd.matrixV().determinant() > 0.0 ? 1.0 : -1.0);
  PlaneFit result;
  result.turn = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
  result.scale = svd.singularValues().dot(signs) / a.squaredNorm();
  result.offset = to_mean - result.scale * result.turn * from_mean;
  result.rms = std::sqrt((b - result.scale * result.turn * a).squaredNorm() / count);
  return result;
}

// Root mean square distance of the points from the line that fits them best.
double spread(const Points& points) {
  const Points centred = points.colwise() - Vector2d(points.rowwise().mean());
  const Eigen::JacobiSVD<Matrix2d> svd(centred * centred.transpose());
  return std::sqrt(svd.singularValues()[1] / static_cast<double>(points.cols()));
}

}  // namespace

std::array<double, 2> touch_centre_mm(std::span<const double> frame, std::span<const double> baseline, int rows,
                                      int columns, double pitch_mm, double least, double threshold) {
  const auto taxels = static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns);
  if (frame.size() != taxels || baseline.size() != taxels) {
    throw std::invalid_argument("touch_centre_mm: frame and baseline do not fit the array");
  }
  std::vector<double> rise(taxels);
  std::transform(frame.begin(), frame.end(), baseline.begin(), rise.begin(), std::minus<>());
  const auto peak = std::max_element(rise.begin(), rise.end());
  if (!(*peak >= least)) {
    throw Fault("TB-MOUNT-NO-TOUCH", kDevice,
                fmt::format("no taxel rose by {:g} over its baseline, the highest by {:.4g}", least, *peak));
  }
  const auto at = static_cast<int>(peak - rise.begin());
  const int row = at / columns;
  const int column = at % columns;
  if (row == 0 || row == rows - 1 || column == 0 || column == columns - 1) {
    throw Fault("TB-MOUNT-EDGE", kDevice,
                fmt::format("the touch is strongest at row {}, column {}, on the array's edge", row, column));
  }
  double sum = 0.0, x = 0.0, y = 0.0;
  for (std::size_t i = 0; i < taxels; ++i) {
    const double weight = std::max(0.0, rise[i] - threshold * *peak);
    sum += weight;
    const std::size_t down = i / static_cast<std::size_t>(columns), along = i % static_cast<std::size_t>(columns);
    x += weight * static_cast<double>(along);
    y += weight * static_cast<double>(down);
  }
  return {pitch_mm * x / sum, pitch_mm * y / sum};
}

std::array<double, 2> MountRegistration::stage_mm(const std::array<double, 2>& taxel_mm) const {
  const double angle = angle_deg * std::numbers::pi / 180.0;
  const double x = scale * taxel_mm[0];
  const double y = scale * (flipped ? -taxel_mm[1] : taxel_mm[1]);
  return {offset_mm[0] + std::cos(angle) * x - std::sin(angle) * y,
          offset_mm[1] + std::sin(angle) * x + std::cos(angle) * y};
}

std::string MountRegistration::json() const {
  nlohmann::ordered_json made = {{"angle_deg", angle_deg},
                                 {"offset_mm", offset_mm},
                                 {"flipped", flipped},
                                 {"scale", scale},
                                 {"pitch_mm", pitch_mm},
                                 {"rms_mm", rms_mm},
                                 {"other_flip_rms_mm", other_rms_mm}};
  made["touches"] = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < touches.size(); ++i) {
    made["touches"].push_back({{"stage_mm", {touches[i].x_mm, touches[i].y_mm}},
                               {"taxel_mm", touches[i].taxel_mm},
                               {"residual_mm", residual_mm.at(i)}});
  }
  return analysis::json_line(made);
}

MountRegistration register_mount(const std::vector<Touch>& touches, double pitch_mm,
                                 const RegistrationOptions& options) {
  if (touches.size() < 3) {
    throw Fault("TB-MOUNT-TOUCHES", kDevice, fmt::format("{} touches were made, 3 are needed", touches.size()));
  }
  Points taxel(2, touches.size());
  Points stage(2, touches.size());
  for (std::size_t i = 0; i < touches.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    taxel.col(column) << touches[i].taxel_mm[0], touches[i].taxel_mm[1];
    stage.col(column) << touches[i].x_mm, touches[i].y_mm;
  }
  const double narrow_mm = std::min(spread(taxel), spread(stage));
  if (!(narrow_mm >= options.min_spread_mm)) {
    throw Fault(
        "TB-MOUNT-COLLINEAR", kDevice,
        fmt::format("the touches are within {:.2f} mm (rms) of one line, {:g} mm are needed: a flip could not be "
                    "recognised",
                    narrow_mm, options.min_spread_mm));
  }
  const PlaneFit straight = fit(taxel, stage, 1.0);
  const PlaneFit mirrored = fit(taxel, stage, -1.0);
  MountRegistration made;
  made.flipped = mirrored.rms < straight.rms;
  const PlaneFit& best = made.flipped ? mirrored : straight;
  // The first column of turn is where the taxels' x goes, with either flip.
  made.angle_deg = std::atan2(best.turn(1, 0), best.turn(0, 0)) * 180.0 / std::numbers::pi;
  made.offset_mm = {best.offset[0], best.offset[1]};
  made.scale = best.scale;
  made.pitch_mm = pitch_mm;
  made.rms_mm = best.rms;
  made.other_rms_mm = made.flipped ? straight.rms : mirrored.rms;
  made.touches = touches;
  for (const Touch& touch : touches) {
    const std::array<double, 2> place = made.stage_mm(touch.taxel_mm);
    made.residual_mm.push_back(std::hypot(place[0] - touch.x_mm, place[1] - touch.y_mm));
  }
  if (!(made.rms_mm <= options.max_rms_mm)) {
    throw Fault("TB-MOUNT-RESIDUAL", kDevice,
                fmt::format("the touches are {:.3f} mm (rms) from their places, {:g} mm is allowed; angle {:.2f} deg, "
                            "scale {:.4f}",
                            made.rms_mm, options.max_rms_mm, made.angle_deg, made.scale));
  }
  return made;
}

}  // namespace tactbench::bench
