// One plant couples the simulated ends: chamber and specimen behind the ports that the simulated module and the
// simulated scanner ask. Moves lazily to the clock's time at each question, on a fixed grid of process time, under one
// lock; asking changes nothing but the noise drawn, so the same seeds and questions give the same answers.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "bench/simulation/chamber.h"
#include "bench/simulation/specimen.h"
#include "devices/clock.h"
#include "devices/force/force_sensor.h"
#include "devices/pressure/chamber_port.h"
#include "devices/stage/stage_view.h"
#include "devices/tactile/simulated_scanner.h"

namespace tactbench::bench {

struct ScannerFrontEnd {
  double volts_per_count = 5.0 / 65535.0;  // 16 bit over 0-5 V
  double noise_v = 0.0015;                 // standard deviation per sample
  double relay_settle_s = 0.004;           // waited after a row's relay closes
  double relay_time_constant_s = 0.0006;   // what is left of the row before decays with this
};

struct ContactOptions {        // indenter and specimen, an elastic half of the truth until the contact mechanics come
  double surface_z_mm = 30.0;  // where the indenter touches
  double stiffness_n_per_mm = 20.0;  // of specimen and support
  double force_noise_n = 0.005;      // standard deviation, each axis
  double torque_noise_nmm = 0.02;
};

struct PlantOptions {
  std::uint64_t seed = 1;  // noise
  ChamberOptions chamber;
  SpecimenOptions specimen;
  ScannerFrontEnd scanner;
  ContactOptions contact;
  double supply_bar = 8.0;  // compressed air in front of the regulator
};

class Plant final : public devices::ChamberPort, public devices::TactilePort, public devices::ForcePort {
 public:
  // The pressure starts at 0 with nothing driven. `clock` has to outlive the plant.
  Plant(const PlantOptions& options, const devices::Clock& clock);

  void drive(devices::Volts command, devices::Nanoseconds hold_until, devices::Volts fallback) override;
  // Monitor output: what the regulator believes, 0-10 V over its span. Noise included; not clipped.
  [[nodiscard]] devices::Volts feedback() override;
  // The truth with the transducer's noise, 0-10 V over its span; not clipped.
  [[nodiscard]] devices::Volts reference() override;
  // What a digital gauge on the chamber tells: the truth with the transducer's noise.
  [[nodiscard]] devices::Psi reference_pressure();
  [[nodiscard]] double temperature_c() const { return options_.specimen.temperature_c; }
  [[nodiscard]] double supply_bar() const { return options_.supply_bar; }
  // Throws std::invalid_argument when a span does not fit the array.
  void scan(std::span<std::uint16_t> counts, std::span<std::uint8_t> status) override;

  // The indenter's sensor: pressing on the specimen is a negative Fz. Without a stage it hangs free.
  [[nodiscard]] devices::Wrench wrench() override;
  // `stage` has to outlive what asks wrench(); null takes it away.
  void set_stage(const devices::StageView* stage) { stage_ = stage; }

  // Truth, for tests and reports on the simulation; never seen by drivers.
  [[nodiscard]] devices::Psi true_pressure();
  [[nodiscard]] std::string specimen_state();
  void set_specimen_state(const std::string& text);

 private:
  void advance_to(devices::Nanoseconds time);  // whole cells of the grid
  void step_to(devices::Nanoseconds time);     // exactly
  void follow(double seconds);                 // the specimen follows the chamber
  void move_specimen(double pressure_psi, double seconds);
  PlantOptions options_;
  const devices::Clock& clock_;
  std::mutex mutex_;
  Chamber chamber_;
  Specimen specimen_;
  devices::Nanoseconds time_{0};
  devices::Nanoseconds hold_until_{0};
  devices::Volts command_{0.0};
  devices::Volts fallback_{0.0};
  bool held_ = false;  // a command with a time limit is in force

  // Time since the specimen last moved, which it has still to live through at the chamber's pressure.
  double pending_s_ = 0.0;
  double calm_s_ = 0.0;        // since the pressure last moved the specimen
  double moved_psi_ = 0.0;     // pressure that the specimen last saw
  double previous_psi_ = 0.0;  // pressure one cell ago
  int direction_ = 0;

  std::uint64_t feedback_counter_ = 0;
  std::uint64_t reference_counter_ = 0;
  std::uint64_t scan_counter_ = 0;
  std::uint64_t wrench_counter_ = 0;
  std::atomic<const devices::StageView*> stage_{nullptr};
  bool volts_fresh_ = false;
  std::vector<double> volts_;
};

}  // namespace tactbench::bench
