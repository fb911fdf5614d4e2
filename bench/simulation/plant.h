// The plant couples the simulated instruments: they query its chamber, stage, contact and specimen.
// It advances lazily to the clock's time at each query, on a fixed grid of process time, under one lock; a query
// changes nothing else but the state of the noise, so the same seeds and queries give the same answers.
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
  // The pressure starts at 0 with no command. `clock` must outlive the plant.
  Plant(const PlantOptions& options, const devices::Clock& clock);

  void drive(devices::Volts command, devices::Nanoseconds hold_until, devices::Volts fallback) override;
  void dump(bool open) override;
  // Monitor output: the pressure measured by the regulator, 0-10 V over its span. Includes noise; not clipped.
  [[nodiscard]] devices::Volts feedback() override;
  // The true pressure with the transducer's noise and errors, 0-10 V over its span; not clipped.
  [[nodiscard]] devices::Volts reference() override;
  // Reading of a digital gauge on the chamber: the true pressure with the transducer's noise and errors.
  [[nodiscard]] devices::Psi reference_pressure();
  // Reading of the thermometer.
  [[nodiscard]] double temperature_c() const { return options_.specimen.temperature_c + instruments_.thermometer_c(); }
  [[nodiscard]] double supply_bar();
  // Throws std::invalid_argument when a span does not fit the array.
  void scan(std::span<std::uint16_t> counts, std::span<std::uint8_t> status) override;

  // The sensor between z stage and object: pressing on the specimen is a negative Fz. Without a stage it is not loaded.
  [[nodiscard]] devices::Wrench wrench() override;
  // `stage` must exist until another one, or null, replaces it. The plant queries it while holding its own lock.
  void set_stage(const devices::StageView* stage);
  void forget_stage();  // immediately, without advancing the plant: for the teardown of the rig

  // Starts the fault now; without a value the default one. It acts on chamber and contact from the next 10 ms on.
  // `times`: number of affected answers or levels; 0: all until clear().
  void inject(FaultKind kind, std::optional<double> value = std::nullopt, long times = 0);
  void clear(FaultKind kind);
  // Queried by the simulated instruments at each request.
  [[nodiscard]] devices::InjectedFault injected(Instrument instrument);
  [[nodiscard]] const Faults& faults() const { return faults_; }

  // True values for tests and reports on the simulation; hidden from drivers.
  [[nodiscard]] devices::Psi true_pressure();
  [[nodiscard]] devices::Newtons true_force();           // force of the object on the specimen, >= 0
  [[nodiscard]] std::vector<double> true_contact_psi();  // per taxel, without the chamber's pressure
  // Outputs of all taxels in volts as a scan would measure them now, without noise, relays and converter. Includes the
  // random walks and cycle effects of the harsh specimen, which are properties of the sensor.
  [[nodiscard]] std::vector<double> true_output();
  [[nodiscard]] std::string specimen_state();
  void set_specimen_state(const std::string& text);

 private:
  struct Load {
    double chamber_psi = 0.0;
    double force_n = 0.0;
  };
  void advance_to(devices::Nanoseconds time);  // advances by whole cells of the grid
  void step_to(devices::Nanoseconds time);     // advances exactly to the time
  void follow_stage(double seconds);           // advances the contact to time_
  void follow(double seconds);                 // the specimen follows the load
  void move_specimen(const Load& load, double seconds);
  void apply_faults();               // applies the faults that are active at time_
  [[nodiscard]] Load load() const {  // a vacuum does not load the specimen
    return {std::max(0.0, chamber_.pressure().value()), contact_state_.force_n};
  }
  [[nodiscard]] double peak_psi(double force_n) const { return force_n * peak_psi_per_newton_; }
  // Pressure of the object per taxel; empty without contact. Valid until the next call.
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
  bool stage_rests_ = false;  // during the time span that is simulated
  ContactState contact_state_;
  std::vector<double> psi_per_newton_;  // at the present place of the object; kept while it does not press
  double peak_psi_per_newton_ = 0.0;
  bool shifted_ = false;  // the object has moved along the array since the specimen was last advanced
  std::vector<double> contact_psi_;

  // Time since the specimen was last advanced, still to be simulated at the present load.
  double pending_s_ = 0.0;
  double calm_s_ = 0.0;  // since the load last changed the specimen
  Load moved_;           // load at the specimen's last advance
  Load previous_;        // load one cell ago
  int direction_ = 0;
  int contact_direction_ = 0;

  std::uint64_t feedback_counter_ = 0;
  std::uint64_t reference_counter_ = 0;
  std::uint64_t scan_counter_ = 0;
  std::uint64_t wrench_counter_ = 0;
  bool volts_fresh_ = false;
  std::vector<double> volts_;
  std::vector<std::uint16_t> stuck_counts_;  // counts of the stuck row
};

}  // namespace tactbench::bench
