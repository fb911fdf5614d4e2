// The simulated module on a serial line: Modbus RTU on a pseudo-terminal. Used only by simulated_module.cpp.
#pragma once

#include "devices/pressure/simulated_server.h"
#include "devices/wire/ends/pseudo_terminal.h"

namespace tactbench::devices {

class SimulatedModule::RtuServer final : public SimulatedModule::Server {
 public:
  RtuServer(std::vector<SimulatedUnit> units, ChamberPort& chamber, const Clock& clock, SimulatedModuleFaults faults);
  ~RtuServer() override;
  RtuServer(const RtuServer&) = delete;
  RtuServer& operator=(const RtuServer&) = delete;
  [[nodiscard]] std::string serial_port() const override { return terminal_.path(); }

 private:
  void serve() override;
  [[nodiscard]] bool attend();
  PseudoTerminal terminal_;
  bool echoes_;
  std::vector<std::uint8_t> received_;
};

}  // namespace tactbench::devices
