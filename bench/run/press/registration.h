// Registers the position of the array on the stage: touches of a point indenter at known x, y, the centroid of each
// frame, and the least-squares transform between the two. Pure functions; the caller stores the result with the mount.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

namespace tactbench::bench {

// Taxel coordinates: x along the columns, y along the rows, mm from the centre of taxel (0, 0), by the nominal pitch.
struct Touch {
  double x_mm = 0.0, y_mm = 0.0;  // stage position
  std::array<double, 2> taxel_mm{};
};

// Centroid of a frame over its baseline: each taxel is weighted by its excess over `threshold` of the peak. Row-major
// rows x columns, any unit. Throws Fault TB-MOUNT-NO-TOUCH when no taxel exceeds the baseline by `least`, and
// TB-MOUNT-EDGE when the array's edge cuts off neighbours of the centre, which would bias it inward.
[[nodiscard]] std::array<double, 2> touch_centre_mm(std::span<const double> frame, std::span<const double> baseline,
                                                    int rows, int columns, double pitch_mm, double least,
                                                    double threshold = 0.1);

struct RegistrationOptions {
  double max_rms_mm = 0.5;
  double min_spread_mm = 2.0;  // least spread of the touches, perpendicular to their longest line
};

// stage = scale x R(angle) x F x taxel + offset, F the identity, or the mirror (x, -y) if the sensor is flipped.
struct MountRegistration {
  double angle_deg = 0.0;
  std::array<double, 2> offset_mm{};
  bool flipped = false;
  double scale = 1.0;         // relative to the nominal pitch: 1 if pitch and stage agree
  double pitch_mm = 0.0;      // nominal
  double rms_mm = 0.0;        // of the residuals
  double other_rms_mm = 0.0;  // residual of the rejected transform with the opposite flip
  std::vector<Touch> touches;
  std::vector<double> residual_mm;  // one per touch
  [[nodiscard]] std::array<double, 2> stage_mm(const std::array<double, 2>& taxel_mm) const;
  [[nodiscard]] std::string json() const;
};

// At least 3 touches. Umeyama's closed form (IEEE PAMI 13, 1991, 376), for both signs of the determinant; the better
// fit is returned. Throws Fault TB-MOUNT-TOUCHES (fewer than 3), TB-MOUNT-COLLINEAR, TB-MOUNT-RESIDUAL.
[[nodiscard]] MountRegistration register_mount(const std::vector<Touch>& touches, double pitch_mm,
                                               const RegistrationOptions& options = {});

}  // namespace tactbench::bench
