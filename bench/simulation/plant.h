// One plant couples the simulated instruments: chamber, stage, contact and specimen behind the ports that they query.
// It advances lazily to the clock's time at each query, on a fixed grid of process time, under one lock; a query
// changes nothing but the noise drawn, so the same seeds and queries give the same answers.
#pragma once

#include <algorithm>
#include <cstdint>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/config/plant_options.h"
#include "bench/simulation/chamber.h"
#include "bench/simulation/contact.h"
#include "bench/simulation/faults.h"
#include "bench/simulation/instrument_errors.h"
#include "bench/simulation/specimen.h"
#include "devices/clock.h"
#include "devices/force/force_sensor.h"
#include "devices/pressure/chamber_port.h"
#include "devices/stage/stage.h"
#include "devices/tactile/simulated_scanner.h"

namespace tactbench::bench {

class Plant final : public devices::ChamberPort, public devices::TactilePort, public devices::ForcePort {
 public:
  // The pressure starts at 0 with nothing driven. `clock` has to outlive the plant.
  Plant(const PlantOptions& options, const devices::Clock& clock);

  void drive(devices::Volts command, devices::Nanoseconds hold_until, devices::Volts fallback) override;
  void dump(bool open) override;
  // Monitor output: what the regulator believes, 0-10 V over its span. Noise included; not clipped.
  [[nodiscard]] devices::Volts feedback() override;
  // The truth with the transducer's noise and errors, 0-10 V over its span; not clipped.
  [[nodiscard]] devices::Volts reference() override;
  // Reading of a digital gauge on the chamber: the truth with the transducer's noise and errors.
  [[nodiscard]] devices::Psi reference_pressure();
  // Reading of the thermometer.
  [[nodiscard]] double temperature_c() const { return options_.specimen.temperature_c + instruments_.thermometer_c(); }
  [[nodiscard]] double supply_bar();
  // Throws std::invalid_argument when a span does not fit the array.
  void scan(std::span<std::uint16_t> counts, std::span<std::uint8_t> status) override;

  // The sensor between z stage and object: pressing on the specimen is a negative Fz. Without a stage it hangs free.
  [[nodiscard]] devices::Wrench wrench() override;
  // `stage` has to live until another, or null, takes its place. The plant asks it while holding its own lock.
  void set_stage(const devices::StageView* stage);
  void forget_stage();  // at once, with nothing brought up to date: when the rig is taken down

  // From now on, whatever starts the fault; without a value the usual one. Chamber and contact feel it from the next
  // 10 ms on. `times`: answers or levels that it spoils, 0 all until clear().
  void inject(FaultKind kind, std::optional<double> value = std::nullopt, long times = 0);
  void clear(FaultKind kind);
  // What the simulated ends ask for each request.
  [[nodiscard]] devices::InjectedFault injected(Instrument instrument);
  [[nodiscard]] const Faults& faults() const { return faults_; }

  // Truth, for tests and reports on the simulation; never seen by drivers.
  [[nodiscard]] devices::Psi true_pressure();
  [[nodiscard]] devices::Newtons true_force();           // of the object on the specimen, 0 or more
  [[nodiscard]] std::vector<double> true_contact_psi();  // by taxel, without the chamber's
  // Outputs of all taxels in volts as a scan now would find them, without noise, relays and converter. The walks and
  // the cycles of the harsh specimen are in it: they are the sensor's.
  [[nodiscard]] std::vector<double> true_output();
  [[nodiscard]] std::string specimen_state();
  void set_specimen_state(const std::string& text);

 private:
  struct Load {
    double chamber_psi = 0.0;
    double force_n = 0.0;
  };
  void advance_to(devices::Nanoseconds time);  // whole cells of the grid
  void step_to(devices::Nanoseconds time);     // exactly
  void follow_stage(double seconds);           // contact up to time_
  void follow(double seconds);                 // the specimen follows the load
  void move_specimen(const Load& load, double seconds);
  void apply_faults();               // applies the faults that are active at time_
  [[nodiscard]] Load load() const {  // a vacuum does not load the specimen
    return {std::max(0.0, chamber_.pressure().value()), contact_state_.force_n};
  }
  [[nodiscard]] double peak_psi(double force_n) const { return force_n * peak_psi_per_newton_; }
  // Pressure by taxel of the object; empty without contact. Valid until the next call.
  [[nodiscard]] std::span<const double> contact_psi(double force_n);
  [[nodiscard]] ContactState contact_now();
  void read_specimen();  // into volts_, at clock_'s time

  PlantOptions options_;
  const devices::Clock& clock_;
  std::mutex mutex_;
  Faults faults_;
  Chamber chamber_;
  Contact contact_;
  Specimen specimen_;
  InstrumentErrors instruments_;
  devices::Nanoseconds time_{0};
  devices::Nanoseconds hold_until_{0};
  devices::Volts command_{0.0};
  devices::Volts fallback_{0.0};
  bool dumping_ = false;
  bool held_ = false;  // a command with a time limit is in force

  const devices::StageView* stage_ = nullptr;
  bool stage_rests_ = false;  // over the span of time being gone through
  ContactState contact_state_;
  std::vector<double> psi_per_newton_;  // where the object now presses; kept while it does not
  double peak_psi_per_newton_ = 0.0;
  bool shifted_ = false;  // the object has gone along the array since the specimen last moved
  std::vector<double> contact_psi_;

  // Time since the specimen last moved, which it has still to live through at the present load.
  double pending_s_ = 0.0;
  double calm_s_ = 0.0;  // since the load last moved the specimen
  Load moved_;           // load that the specimen last saw
  Load previous_;        // load one cell ago
  int direction_ = 0;
  int contact_direction_ = 0;

  std::uint64_t feedback_counter_ = 0;
  std::uint64_t reference_counter_ = 0;
  std::uint64_t scan_counter_ = 0;
  std::uint64_t wrench_counter_ = 0;
  bool volts_fresh_ = false;
  std::vector<double> volts_;
  std::vector<std::uint16_t> stuck_counts_;  // of the row that is stuck
};

}  // namespace tactbench::bench
