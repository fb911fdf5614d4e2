// The Modbus side of a simulated rig: which units are on which simulated line, as described by the bench file.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bench/config/config.h"
#include "bench/simulation/plant.h"
#include "devices/pressure/simulated_module.h"

namespace tactbench::bench {

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

}  // namespace tactbench::bench
