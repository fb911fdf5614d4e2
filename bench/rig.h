// Builds and owns a bench's devices from its configuration; the one place that names drivers. On a simulated bench it
// also starts the simulated ends, and the same drivers talk to them over real wires.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bench/config.h"
#include "bench/simulation/plant.h"
#include "db/record.h"
#include "devices/clock.h"
#include "devices/pressure/analog_module.h"
#include "devices/pressure/pressure_source.h"
#include "devices/pressure/simulated_module.h"
#include "devices/tactile/simulated_scanner.h"
#include "devices/tactile/tactile_array.h"

namespace tactbench::bench {

class Rig {
 public:
  // Starts simulated ends and makes the drivers; talks to no instrument yet. Throws Fault.
  explicit Rig(const BenchConfig& config);
  ~Rig();
  Rig(const Rig&) = delete;
  Rig& operator=(const Rig&) = delete;

  // Connects: module bring-up (watchdog set and verified), scanner identified. Throws Fault.
  void open();

  [[nodiscard]] devices::Clock& clock() { return *clock_; }
  [[nodiscard]] devices::PressureSource& source() { return *source_; }
  [[nodiscard]] devices::PressureReference& reference() { return *reference_; }
  // Throws std::logic_error before open().
  [[nodiscard]] devices::TactileArray& array();
  [[nodiscard]] bool has_array() const { return array_ != nullptr; }
  [[nodiscard]] const BenchConfig& config() const { return config_; }
  // With the calibration that scales each device's raw counts.
  [[nodiscard]] std::vector<db::DeviceRecord> devices() const;
  [[nodiscard]] std::uint64_t exchanges() const;         // on all wires so far
  [[nodiscard]] Plant* plant() { return plant_.get(); }  // null on hardware

 private:
  BenchConfig config_;
  std::string socket_folder_;
  std::unique_ptr<devices::Clock> clock_;
  std::unique_ptr<Plant> plant_;
  std::unique_ptr<devices::SimulatedModule> simulated_module_;
  std::unique_ptr<devices::SimulatedScanner> simulated_scanner_;
  std::unique_ptr<devices::AnalogModule> module_;
  std::unique_ptr<devices::PressureSource> source_;
  std::unique_ptr<devices::PressureReference> reference_;
  std::unique_ptr<devices::TactileArray> array_;
};

}  // namespace tactbench::bench
