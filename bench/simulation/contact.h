// Contact mechanics of the second platform: an object under the z stage presses through a fabric layer on the array.
// Pure physics in process time; equations in bench/simulation/README.md. Except for the array's pitch, the constants
// are invented and not compared with hardware.
#pragma once

#include <array>
#include <vector>

#include "bench/config/plant_options.h"

namespace tactbench::bench {

struct ContactState {
  bool placed = false;
  double tip_mm = 0.0;                // z of the object
  double friction = 0.0;              // -1 unloading .. 1 loading
  std::array<double, 2> relaxed_n{};  // force lost by relaxation of the fabric
  double force_n = 0.0;               // on the specimen, 0 or more
};

class Contact {
 public:
  // Throws std::invalid_argument for an object without an area.
  Contact(const ContactOptions& options, int rows, int columns);
  // The z stage moves to `z_mm` and stays there for `seconds` (>= 0).
  void advance(ContactState& state, double z_mm, double seconds) const;
  // True: the state does not change as long as z stays.
  [[nodiscard]] bool quiet(const ContactState& state) const;
  // Pressure on each taxel, rows x columns, row-major, for 1 N with the stage at x, y: with the whole object on the
  // array, the sum of pressure times pitch^2 is 1 N. Columns grow along x, rows along y. Valid until the next call.
  const std::vector<double>& psi_per_newton(double x_mm, double y_mm);
  [[nodiscard]] const ContactOptions& options() const { return options_; }

 private:
  [[nodiscard]] double density(double distance_mm) const;  // relative pressure at this distance from the object's axis
  ContactOptions options_;
  int rows_, columns_;
  double whole_mm2_ = 0.0;  // integral of density() over the plane
  double x_mm_, y_mm_;      // of psi_per_newton_
  std::vector<double> psi_per_newton_;
};

}  // namespace tactbench::bench
