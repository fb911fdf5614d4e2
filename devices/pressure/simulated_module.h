// Simulated analog module: a real Modbus server (libmodbus) on loopback TCP or, as RTU, on a pseudo-terminal, with the
// register map of one or several units and the watchdog on process time; volts come from a ChamberPort. For any client
// (FC 2, 3, 4, 5, 6, 16, 23).
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "devices/clock.h"
#include "devices/pressure/chamber_port.h"
#include "devices/pressure/module_profile.h"
#include "devices/pressure/options.h"

namespace tactbench::devices {

struct SimulatedQuantity {  // a gauge's or a thermometer's registers
  ModbusQuantity at;
  std::function<double()> read;  // physical value, called from the server's thread while the clock does not advance
};

struct SimulatedUnit {
  int unit = 0;  // 0: answers every unit number (TCP only)
  ModuleProfile profile;
  std::vector<SimulatedQuantity> quantities;
  bool starts_in_safe_mode = false;
  int output_channel = 0;  // how the chamber is wired to this unit
  int feedback_channel = 0;
  int reference_channel = 1;
};

class SimulatedModule {
 public:
  // TCP: listens on 127.0.0.1; port 0 lets the system choose. RTU: makes a pseudo-terminal. Throws Fault
  // TB-SIM-LISTEN.
  SimulatedModule(const ModuleProfile& profile, int port, ChamberPort& chamber, const Clock& clock,
                  SimulatedModuleFaults faults = {});
  enum class Wire { kTcp, kRtu };
  SimulatedModule(std::vector<SimulatedUnit> units, Wire wire, int port, ChamberPort& chamber, const Clock& clock,
                  SimulatedModuleFaults faults = {});
  ~SimulatedModule();  // stops the thread in bounded time
  SimulatedModule(const SimulatedModule&) = delete;
  SimulatedModule& operator=(const SimulatedModule&) = delete;
  [[nodiscard]] int port() const;                 // TCP
  [[nodiscard]] std::string serial_port() const;  // RTU: the terminal that a client opens

 private:
  class Server;
  class TcpServer;
  class RtuServer;
  std::unique_ptr<Server> server_;
};

}  // namespace tactbench::devices
