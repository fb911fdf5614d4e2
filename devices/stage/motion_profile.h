// Motion of one simulated axis: pieces of constant acceleration, ending at rest exactly at the target. Any unit of
// length; time in seconds since the profile began.
#pragma once

#include <vector>

namespace tactbench::devices {

class MotionProfile {
 public:
  explicit MotionProfile(double rest_position = 0.0) : start_(rest_position), end_(rest_position) {}
  // Starts at `position` with `velocity`; `speed` and `acceleration` above 0. First slows down or reverses if needed.
  static MotionProfile to(double position, double velocity, double target, double speed, double acceleration);
  static MotionProfile to_rest(double position, double velocity, double acceleration);

  [[nodiscard]] double duration() const { return duration_; }
  [[nodiscard]] double end() const { return end_; }
  [[nodiscard]] double position(double seconds) const;
  [[nodiscard]] double velocity(double seconds) const;

 private:
  struct Piece {
    double duration;
    double acceleration;
  };
  void add(double duration, double acceleration);

  double start_;
  double start_velocity_ = 0.0;
  double end_;
  double duration_ = 0.0;
  std::vector<Piece> pieces_;
};

}  // namespace tactbench::devices
