// Builds and owns a bench's devices from its configuration; the one place that names drivers. On a simulated bench it
// also starts the simulated ends, and the same drivers talk to them over real wires.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bench/config.h"
#include "bench/simulation/simulated_rig.h"
#include "db/record.h"
#include "devices/clock.h"
#include "devices/force/force_sensor.h"
#include "devices/pressure/analog_module.h"
#include "devices/pressure/pressure_source.h"
#include "devices/stage/zaber_stage.h"
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

  // Connects and arms the pressure side (module bring-up, watchdog set and verified) and opens the scanner. Stage and
  // force sensor are opened by who needs them. Throws Fault.
  void open();
  void open_array();  // identifies the scanner
  void close_array() { array_.reset(); }
  devices::ForceSensor& open_force();  // reads its calibration; throws std::logic_error when the bench has none
  // What the environment's sensors tell now; one exchange each. Throws Fault.
  [[nodiscard]] std::vector<EnvironmentReading> environment();
  [[nodiscard]] EnvironmentReading environment(std::size_t sensor);  // as config().environment

  [[nodiscard]] devices::Clock& clock() { return *clock_; }
  [[nodiscard]] devices::PressureSource& source() { return *source_; }
  [[nodiscard]] devices::PressureReference& reference() { return *reference_; }
  // Throws std::logic_error before open().
  [[nodiscard]] devices::TactileArray& array();
  [[nodiscard]] devices::AnalogModule& module() { return *module_; }
  [[nodiscard]] devices::ZaberStage* stage() { return stage_.get(); }  // null: the bench has none
  [[nodiscard]] bool has_array() const { return array_ != nullptr; }
  [[nodiscard]] const BenchConfig& config() const { return config_; }
  // With the calibration that scales each device's raw counts.
  [[nodiscard]] std::vector<db::DeviceRecord> devices() const;
  // How often each row's relay closed in this run; empty where the scanner does not count.
  [[nodiscard]] std::vector<std::uint64_t> relay_operations() const;
  [[nodiscard]] std::uint64_t exchanges() const;                                        // on all wires so far
  [[nodiscard]] Plant* plant() { return simulated_ ? &simulated_->plant() : nullptr; }  // null outside this process

 private:
  void make_pressure();
  std::unique_ptr<devices::ModbusLink> link_to(const devices::ModbusEndpoint& endpoint, bool own_line,
                                               const std::string& device);
  BenchConfig config_;
  std::unique_ptr<devices::Clock> clock_;
  std::unique_ptr<SimulatedRig> simulated_;
  std::unique_ptr<devices::AnalogModule> module_;
  std::unique_ptr<devices::AnalogModule> input_module_;  // null: module_ reads the inputs too
  std::unique_ptr<devices::PressureSource> source_;
  std::unique_ptr<devices::PressureReference> reference_;
  const devices::ModbusGauge* gauge_ = nullptr;                    // inside reference_
  std::vector<std::unique_ptr<devices::ModbusLink>> environment_;  // as config().environment
  std::unique_ptr<devices::TactileArray> array_;
  std::unique_ptr<devices::ZaberStage> stage_;
  std::unique_ptr<devices::ForceSensor> force_;
};

}  // namespace tactbench::bench
