// Makes and owns a bench's devices as the bench file states them: pressure source, scanner, stage and force sensor by
// the entry of their kind in a registry (instrument_kinds.h, pressure_kinds.h), analog modules, pressure reference and
// environment sensors directly. On a simulated bench it also starts the simulated instruments, and the same drivers
// talk to them over real sockets and pseudo-terminals.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bench/config/config.h"
#include "bench/guard/dead_man_process.h"
#include "bench/guard/guard.h"
#include "bench/guard/guard_devices.h"
#include "bench/rig/device_records.h"
#include "db/record.h"
#include "devices/clock.h"
#include "devices/force/force_sensor.h"
#include "devices/pressure/pressure_source.h"
#include "devices/stage/stage.h"
#include "devices/tactile/tactile_array.h"

namespace tactbench::devices {
class AnalogModule;
class ModbusGauge;
class ModbusLink;
}  // namespace tactbench::devices

namespace tactbench::bench {

class Plant;
class SimulatedRig;

struct EnvironmentReading {
  std::string quantity;  // temperature_c | supply_bar
  double value = 0.0;
};

class Rig {
 public:
  // Starts simulated ends and makes the drivers; talks to no instrument yet. Throws Fault, and Error TB-BENCH-FILL-IN
  // for a hardware bench file that still says FILL-IN.
  explicit Rig(const BenchConfig& config);
  ~Rig();
  Rig(const Rig&) = delete;
  Rig& operator=(const Rig&) = delete;

  // Connects and arms the pressure side (module bring-up, watchdog set and verified) and opens the scanner. Stage and
  // force sensor are opened where they are needed. Throws Fault.
  void open();
  void open_array();  // identifies the scanner
  void close_array() { array_.reset(); }
  [[nodiscard]] devices::ForceSensor* force() { return force_.get(); }  // null: not opened
  void close_force() { force_.reset(); }
  devices::ForceSensor& open_force();  // reads its calibration; throws std::logic_error when the bench has none
  // The present readings of the environment's sensors; one exchange each. Throws Fault.
  [[nodiscard]] std::vector<EnvironmentReading> environment();
  [[nodiscard]] EnvironmentReading environment(std::size_t sensor);  // as config().environment

  // Waiting on it feeds the dead-man.
  [[nodiscard]] devices::Clock& clock() { return *clock_; }
  // Behind the guard, as stage_gate(), reference() and the force sensor are.
  [[nodiscard]] devices::PressureSource& source() { return *source_; }
  [[nodiscard]] devices::PressureReference& reference() { return *reference_; }
  // Throws std::logic_error before open().
  [[nodiscard]] devices::TactileArray& array();
  // The module of the bench and its output words; empty: it cannot read them back. Writes nothing. Throws Fault.
  [[nodiscard]] std::pair<devices::Identity, std::vector<std::uint16_t>> inspect_module();
  void look();  // reads what is on the wires of the pressure source, and writes nothing; throws Fault
  // Null: the bench has none. All moves go through stage_gate(); stage() is for reading and for benchmarks.
  [[nodiscard]] devices::Stage* stage_gate() { return stage_gate_.get(); }
  [[nodiscard]] devices::Stage* stage() { return stage_.get(); }
  [[nodiscard]] Guard& guard() { return *guard_; }
  // Starts at the first arming, on hardware and external simulators; null before, and where there is none.
  [[nodiscard]] DeadManProcess* dead_man() { return dead_man_.get(); }
  void feed_dead_man() { guard_->feed(); }  // for long work that does not wait on the clock
  // To be called when the safe state is proved: ends the dead-man. Otherwise it makes the bench safe when the rig is
  // destroyed.
  void dismiss_dead_man();
  [[nodiscard]] bool has_array() const { return array_ != nullptr; }
  [[nodiscard]] const BenchConfig& config() const { return config_; }
  // For a run that presses: from now on devices() includes stage and force sensor. Identifies both, moves nothing, and
  // leaves the force sensor as it was, open or closed. Throws as open_force(), and the stage's wire faults; an axis
  // that does not answer has no firmware then.
  void name_press_instruments();
  // With the calibration that scales each device's raw counts.
  [[nodiscard]] std::vector<db::DeviceRecord> devices() const;
  [[nodiscard]] std::vector<std::uint64_t> relay_operations() const {  // TactileArray::relay_operations()
    return array_ ? array_->relay_operations() : std::vector<std::uint64_t>();
  }
  [[nodiscard]] std::uint64_t exchanges() const;                       // on all wires so far
  [[nodiscard]] std::vector<std::string> take_busy_report() const;     // ModbusLine::take_busy_report() of each line
  [[nodiscard]] Plant* plant();                                        // null: not simulated in this process
  [[nodiscard]] std::string as_stored(const std::string& text) const;  // with names of simulated ends that last

 private:
  void make_guard();
  void make_pressure();
  void prepare_arming();
  std::unique_ptr<devices::ModbusLink> link_to(const devices::ModbusEndpoint& endpoint, bool own_line,
                                               const std::string& device);
  BenchConfig config_;
  std::unique_ptr<devices::Clock> own_clock_;
  std::unique_ptr<SimulatedRig> simulated_;
  std::unique_ptr<Guard> guard_;
  std::unique_ptr<DeadManProcess> dead_man_;
  std::unique_ptr<ProcessTimeWatcher> watcher_;          // in its place on a bench simulated in this process
  std::unique_ptr<devices::Clock> clock_;                // own_clock_, feeding
  std::unique_ptr<devices::AnalogModule> module_;        // null: the bench has none
  std::unique_ptr<devices::AnalogModule> input_module_;  // null: module_ reads the inputs too
  std::unique_ptr<GuardedSource> source_;
  std::unique_ptr<devices::PressureReference> reference_;
  const devices::ModbusGauge* gauge_ = nullptr;                    // inside reference_
  std::vector<std::unique_ptr<devices::ModbusLink>> environment_;  // as config().environment
  std::unique_ptr<devices::TactileArray> array_;
  std::unique_ptr<devices::Stage> stage_;
  std::unique_ptr<GuardedStage> stage_gate_;
  std::unique_ptr<devices::ForceSensor> force_;
  std::optional<ForceIdentity> press_force_;  // the run presses
};

}  // namespace tactbench::bench
