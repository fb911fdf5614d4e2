// The whole simulated rig: one plant, and simulated instruments for all entries of a bench file, each on a real wire. A
// bench of origin "simulated" has it in its own process; `tactbench simulate` serves it to any client.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bench/common/private_files.h"
#include "bench/config/config.h"
#include "bench/pressure/pressure_kinds.h"
#include "bench/simulation/ephemeral_addresses.h"
#include "bench/simulation/plant.h"
#include "bench/simulation/simulated_lines.h"
#include "devices/force/simulated_digital_ft.h"
#include "devices/force/simulated_net_ft.h"
#include "devices/stage/simulated_chain.h"
#include "devices/tactile/simulated_frame_source.h"
#include "devices/tactile/simulated_scanner.h"

namespace tactbench::bench {

struct Served {
  std::string what;   // "tactile scanner, frame-source protocol"
  std::string where;  // "127.0.0.1:40001"
};

class SimulatedRig {
 public:
  // Starts the ends that `config` names and writes where they are into it. `clock` outlives this. `free_running`: the
  // clock runs by itself, and instruments say unasked what the real ones do. Throws Fault, Error
  // TB-FOLDER-UNSAFE.
  SimulatedRig(BenchConfig& config, const devices::Clock& clock, bool free_running);
  ~SimulatedRig();
  SimulatedRig(const SimulatedRig&) = delete;
  SimulatedRig& operator=(const SimulatedRig&) = delete;
  [[nodiscard]] Plant& plant() { return plant_; }
  [[nodiscard]] const std::vector<Served>& served() const { return served_; }
  [[nodiscard]] const EphemeralAddresses& ephemeral_addresses() const { return ephemeral_addresses_; }

 private:
  devices::FaultInjector injector_of(Instrument instrument);
  void serve_pressure(BenchConfig& config);
  void serve_scanner(BenchConfig& config);
  void serve_stage(BenchConfig& config);
  void serve_force(BenchConfig& config);
  const devices::Clock& clock_;
  bool free_running_;
  Plant plant_;
  ScratchFolder sockets_{"tactbench-sim"};
  std::vector<Served> served_;
  EphemeralAddresses ephemeral_addresses_;
  std::unique_ptr<SimulatedLines> lines_;
  std::vector<PressureEnd> pressure_ends_;
  std::unique_ptr<devices::SimulatedScanner> scanner_;
  std::unique_ptr<devices::SimulatedFrameSource> frame_source_;
  std::unique_ptr<devices::SimulatedChain> chain_;
  std::unique_ptr<devices::SimulatedNetFt> net_ft_;
  std::unique_ptr<devices::SimulatedDigitalFt> digital_ft_;
};

}  // namespace tactbench::bench
