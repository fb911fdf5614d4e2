// Contact mechanics of the second platform: an object under the z stage presses through a fabric layer on the array.
// Pure physics in process time; equations in bench/simulation/README. Invented constants but for the array's pitch,
// not compared with hardware.
#pragma once

#include <array>
#include <vector>

namespace tactbench::bench {

enum class Footprint { kRing, kPoint, kFlat };

struct ContactOptions {
  Footprint object = Footprint::kRing;
  double outer_diameter_mm = 15.0;  // of the ring
  double inner_diameter_mm = 10.0;
  double point_diameter_mm = 2.0;
  double surface_z_mm = 30.0;          // where the object touches the fabric
  double stiffness_n_per_mm = 20.0;    // of fabric, film and support, at first touch
  double stiffening_n_per_mm2 = 10.0;  // F = stiffness d + stiffening d^2
  double friction_share = 0.04;        // the fabric's own hysteresis: so much more while loading, less unloading
  double relaxation_share = 0.06;      // of the force, lost at a held position: half with each time constant
  double relaxation_s = 1.5;           // the slower time constant is ten times that
  double backlash_mm = 0.01;           // the tip stays so long when z turns back
  double fabric_spread_mm = 0.6;       // standard deviation by which the fabric blurs the footprint
  double pitch_mm = 2.54;              // of the array
  double centre_x_mm = 30.0;           // stage position at which the object stands over the array's centre
  double centre_y_mm = 30.0;
  double misplaced_x_mm = 0.0;  // the sensor as it was really put there: what registration has to find
  double misplaced_y_mm = 0.0;
  double misplaced_deg = 0.0;    // counter-clockwise
  double force_noise_n = 0.005;  // standard deviation, each axis
  double torque_noise_nmm = 0.02;
};

struct ContactState {
  bool placed = false;
  double tip_mm = 0.0;                // z of the object
  double friction = 0.0;              // -1 unloading .. 1 loading
  std::array<double, 2> relaxed_n{};  // what the fabric has given in to
  double force_n = 0.0;               // on the specimen, 0 or more
};

class Contact {
 public:
  // Throws std::invalid_argument for an object without an area.
  Contact(const ContactOptions& options, int rows, int columns);
  // The z stage comes to `z_mm` and stays there for `seconds` (>= 0).
  void advance(ContactState& state, double z_mm, double seconds) const;
  // True: nothing happens as long as z stays.
  [[nodiscard]] bool quiet(const ContactState& state) const;
  // Pressure on each taxel, rows x columns, row-major, for 1 N with the stage at x, y: with the whole object on the
  // array, the sum of pressure times pitch^2 is 1 N. Columns grow along x, rows along y. Valid until the next call.
  const std::vector<double>& psi_per_newton(double x_mm, double y_mm);
  [[nodiscard]] const ContactOptions& options() const { return options_; }

 private:
  [[nodiscard]] double density(double distance_mm) const;  // relative pressure so far from the object's axis
  ContactOptions options_;
  int rows_, columns_;
  double whole_mm2_ = 0.0;  // integral of density() over the plane
  double x_mm_, y_mm_;      // of psi_per_newton_
  std::vector<double> psi_per_newton_;
};

}  // namespace tactbench::bench
