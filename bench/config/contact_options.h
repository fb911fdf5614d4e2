// Parameters of the simulated contact: an object under the z stage, the fabric, and how the sensor is mounted.
#pragma once

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

}  // namespace tactbench::bench
