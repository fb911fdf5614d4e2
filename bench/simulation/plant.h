// One plant couples the simulated ends: chamber and specimen behind the ports that the simulated module and the
// simulated scanner ask. Moves lazily to the clock's time at each question, in fixed inner steps, under one lock; the
// clock stands still while a request is open, so the same seeds give the same answers.
#pragma once

#include <cstdint>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "bench/simulation/chamber.h"
#include "bench/simulation/specimen.h"
#include "devices/clock.h"
#include "devices/pressure/chamber_port.h"
#include "devices/tactile/simulated_scanner.h"

namespace tactbench::bench {

struct ScannerFrontEnd {
  double volts_per_count = 5.0 / 65535.0;  // 16 bit over 0-5 V
  double noise_v = 0.0015;                 // standard deviation per sample
  double relay_settle_s = 0.004;           // waited after a row's relay closes
  double relay_time_constant_s = 0.0006;   // what is left of the row before decays with this
};

struct PlantOptions {
  std::uint64_t seed = 1;                  // noise
  ChamberOptions chamber;
  SpecimenOptions specimen;
  ScannerFrontEnd scanner;
};

class Plant final : public devices::ChamberPort, public devices::TactilePort {
 public:
  Plant(const PlantOptions& options, const devices::Clock& clock);

  void drive(devices::Volts command, devices::Nanoseconds hold_until, devices::Volts fallback) override;
  [[nodiscard]] devices::Volts feedback() override;
  [[nodiscard]] devices::Volts reference() override;
  void scan(std::span<std::uint16_t> counts, std::span<std::uint8_t> status) override;

  // Truth, for tests and reports on the simulation; never seen by drivers.
  [[nodiscard]] devices::Psi true_pressure();
  [[nodiscard]] std::string specimen_state();
  void set_specimen_state(const std::string& text);

 private:
  void advance_to(devices::Nanoseconds time);
  double noise();
  PlantOptions options_;
  const devices::Clock& clock_;
  std::mutex mutex_;
  Chamber chamber_;
  Specimen specimen_;
  devices::Nanoseconds time_{0};
  devices::Nanoseconds hold_until_{0};
  devices::Volts fallback_{0.0};
  bool held_ = false;
  std::uint64_t noise_counter_ = 0;
  std::vector<double> volts_;
};

}  // namespace tactbench::bench
