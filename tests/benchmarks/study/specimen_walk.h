// Drives a specimen along pressures directly, for the figures about it: no rig, no clock.
#pragma once

#include <initializer_list>
#include <span>
#include <vector>

#include "bench/simulation/specimen.h"

namespace tactbench::bench {

inline constexpr double kTopPsi = 60.0;
inline constexpr int kLevels = 31;  // of a branch of loop()

class SpecimenWalk {
 public:
  explicit SpecimenWalk(const SpecimenOptions& options);
  // As the bench goes: 2 psi in 0.4 s, then 2 s dwell.
  void condition();  // three cycles
  // Outputs of one cycle 0-60-0 psi: 31 levels up, then 30 down.
  std::vector<std::vector<double>> loop();
  // In 0.25 psi pieces at 40 psi/s.
  void jump(double to_psi);
  // At a speed at which only friction follows.
  void at_once(std::initializer_list<double> turning_points);
  void condition_at_once();  // until nothing of the new film is left
  void hold(double seconds);
  // An object on the taxels at no chamber pressure, in four pieces.
  void press(std::span<const double> contact_psi);
  [[nodiscard]] std::vector<double> output() const;

 private:
  void go(double to_psi, double piece_psi, double seconds_a_piece);
  void step(double to_psi);
  Specimen specimen_;
  double pressure_ = 0.0;
};

}  // namespace tactbench::bench
