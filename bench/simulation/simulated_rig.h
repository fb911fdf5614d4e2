// The whole simulated rig: one plant, and simulated instruments for all entries of a bench file, each with a real
// connection (socket or pseudo-terminal). A bench of origin "simulated" has it in its own process; `tactbench simulate`
// serves it to any client.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bench/common/private_files.h"
#include "bench/config/config.h"
#include "bench/config/instrument_kinds.h"
#include "bench/simulation/ephemeral_addresses.h"
#include "bench/simulation/plant.h"
#include "devices/pressure/simulated_module.h"

namespace tactbench::bench {

// The Modbus side of a simulated rig: which units are on which simulated line, as described by the bench file.
class SimulatedLines {
 public:
  // Starts the servers and writes their addresses into the endpoints of `config`. Plant and clock must outlive this.
  // Throws Fault.
  SimulatedLines(BenchConfig& config, Plant& plant, const devices::Clock& clock);
  // In addition to the lines of the bench file: Waveshare's output module (unit 1, channel 0) and input module (unit 2,
  // feedback on channel 0, reference on 1) on a serial line, on the same plant; the last write drives the regulator.
  void serve_waveshare(Plant& plant, const devices::Clock& clock);
  // "Modbus TCP 127.0.0.1:1502, unit 1: Beckhoff EK9000 + EL4xxx/EL3xxx", one per line.
  [[nodiscard]] const std::vector<std::string>& descriptions() const { return descriptions_; }

 private:
  void serve(std::vector<devices::SimulatedUnit> units, const std::vector<devices::ModbusEndpoint*>& endpoints,
             Plant& plant, const devices::Clock& clock, const devices::SimulatedModuleFaults& faults);
  std::vector<std::unique_ptr<devices::SimulatedModule>> servers_;
  std::vector<std::string> descriptions_;
};

class SimulatedRig {
 public:
  // Starts the simulated instruments of `config` and writes their addresses into it. `clock` must outlive this.
  // `free_running`: the clock runs by itself, and instruments send the same unsolicited data as the real ones. Throws
  // Fault, Error TB-FOLDER-UNSAFE.
  SimulatedRig(BenchConfig& config, const devices::Clock& clock, bool free_running);
  ~SimulatedRig();
  SimulatedRig(const SimulatedRig&) = delete;
  SimulatedRig& operator=(const SimulatedRig&) = delete;
  [[nodiscard]] Plant& plant() { return plant_; }
  [[nodiscard]] const std::vector<Served>& served() const { return served_; }
  // What the bench file of a client states of its instruments other than modules.
  [[nodiscard]] const std::vector<sequences::Override>& addresses() const { return addresses_; }
  [[nodiscard]] const EphemeralAddresses& ephemeral_addresses() const { return ephemeral_addresses_; }

 private:
  [[nodiscard]] devices::StageStall stall_at(devices::Nanoseconds time) const;
  Plant plant_;
  ScratchFolder sockets_{"tactbench-sim"};
  std::vector<Served> served_;
  std::vector<sequences::Override> addresses_;
  EphemeralAddresses ephemeral_addresses_;
  std::unique_ptr<SimulatedLines> lines_;
  std::vector<SimulatedEnd> ends_;
};

}  // namespace tactbench::bench
