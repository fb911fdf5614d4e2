// Builds and owns a bench's devices from its configuration; the one place that names drivers. On a simulated bench it
// also starts the simulated ends, and the same drivers talk to them over real wires.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bench/config.h"
#include "bench/simulation/plant.h"
#include "bench/simulation/simulated_lines.h"
#include "db/record.h"
#include "devices/clock.h"
#include "devices/pressure/analog_module.h"
#include "devices/pressure/pressure_source.h"
#include "devices/tactile/simulated_scanner.h"
#include "devices/tactile/tactile_array.h"

namespace tactbench::bench {

struct EnvironmentReading {
  std::string quantity;  // temperature_c | supply_bar
  double value = 0.0;
};

class Rig {
 public:
  // Starts simulated ends and makes the drivers; talks to no instrument yet. Throws Fault.
  explicit Rig(const BenchConfig& config);
  ~Rig();
  Rig(const Rig&) = delete;
  Rig& operator=(const Rig&) = delete;

  // Connects and arms: module bring-up (watchdog set and verified), scanner identified. Throws Fault.
  void open();
  // What the environment's sensors tell now; one exchange each. Throws Fault.
  [[nodiscard]] std::vector<EnvironmentReading> environment();

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
  void make_pressure();
  std::unique_ptr<devices::ModbusLink> link_to(const devices::ModbusEndpoint& endpoint, bool own_line,
                                               const std::string& device);
  BenchConfig config_;
  std::string socket_folder_;
  std::unique_ptr<devices::Clock> clock_;
  std::unique_ptr<Plant> plant_;
  std::unique_ptr<SimulatedLines> simulated_lines_;
  std::unique_ptr<devices::SimulatedScanner> simulated_scanner_;
  std::unique_ptr<devices::AnalogModule> module_;
  std::unique_ptr<devices::AnalogModule> input_module_;  // null: module_ reads the inputs too
  std::unique_ptr<devices::PressureSource> source_;
  std::unique_ptr<devices::PressureReference> reference_;
  const devices::ModbusGauge* gauge_ = nullptr;                    // inside reference_
  std::vector<std::unique_ptr<devices::ModbusLink>> environment_;  // as config().environment
  std::unique_ptr<devices::TactileArray> array_;
};

}  // namespace tactbench::bench
