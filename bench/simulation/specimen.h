// The simulated sensor: 16 x 16 piezoresistive taxels. Its behaviour (rate dependence, creep, non-congruent minor
// loops, first-cycle conditioning) is outside every class of model that is fitted, so that no fit is judged on its own
// model. The harsh specimen (specimen_harsh.h) deviates more; the foam (specimen_foam.h) has other physics. Equations
// and measured figures: bench/simulation/README.md. Pure physics in process time: no wire, no clock, no thread.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bench/config/plant_options.h"

namespace tactbench::bench {

class Specimen {
 public:
  // Throws std::invalid_argument for a defect outside the array, a shape that is not positive, or a turn that is
  // impossible for a non-square array.
  explicit Specimen(const SpecimenOptions& options);
  ~Specimen();
  Specimen(const Specimen&) = delete;
  Specimen& operator=(const Specimen&) = delete;

  // Holds the chamber at `pressure_psi` for `seconds` (> 0): updates plays, creep and conditioning. The result of a
  // ramp depends on how finely it is divided into calls; Plant always divides it in the same way. `contact_psi`, one
  // value per taxel or empty, is the pressure of an object, added to the chamber's: it does not pass through the
  // membrane, and does not condition the film, which needs a load on the whole array.
  void advance(double pressure_psi, double seconds, std::span<const double> contact_psi = {});
  // Present output voltages, rows x columns row-major, with defects and crosstalk, without noise.
  void output(std::span<double> volts) const;
  // The result of output() after advance() with these arguments, without changing the memory. seconds >= 0.
  void output_after(double pressure_psi, double seconds, std::span<double> volts,
                    std::span<const double> contact_psi = {}) const;
  // Extra noise of taxel i (kNoisy), standard deviation in volts.
  [[nodiscard]] double noise_v(int taxel) const;
  // White noise of one sample, standard deviation 1: heavy-tailed in the harsh specimen, bounded in the others.
  [[nodiscard]] double white_noise(std::uint64_t hash) const;
  // Adds the film's own noise at `time_s` of process time to outputs: 1/f noise in the harsh specimen, none in the
  // others.
  void add_film_noise(double time_s, std::span<double> volts) const;
  // The memory of the film as text (JSON), and back: --specimen-state. Throws std::invalid_argument, also for the state
  // of another sensor; the memory is then unchanged.
  [[nodiscard]] std::string state() const;
  void set_state(const std::string& text);
  [[nodiscard]] const SpecimenOptions& options() const;

 private:
  struct Film;
  std::unique_ptr<Film> film_;
};

}  // namespace tactbench::bench
