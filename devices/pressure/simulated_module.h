// The module's side of the wire: a real Modbus TCP server (libmodbus) on loopback with an EK9000-like map, its
// watchdog on process time, asking a ChamberPort for volts. Any client may talk to it (FC 3, 4, 6, 16, 23).
#pragma once

#include <memory>

#include "devices/clock.h"
#include "devices/pressure/analog_module.h"
#include "devices/pressure/chamber_port.h"

namespace tactbench::devices {

struct SimulatedModuleFaults {      // test and nightly switches, all off by default
  long silent_after_requests = -1;  // answers that many requests, then none (the connection stays open)
  long dead_after_requests = -1;    // closes connections and refuses new ones
};

class SimulatedModule {
 public:
  // Listens on 127.0.0.1; port 0 lets the system choose. Throws Fault TB-SIM-LISTEN.
  SimulatedModule(const ModuleProfile& profile, int port, ChamberPort& chamber, const Clock& clock,
                  SimulatedModuleFaults faults = {});
  ~SimulatedModule();  // stops the thread, bounded
  SimulatedModule(const SimulatedModule&) = delete;
  SimulatedModule& operator=(const SimulatedModule&) = delete;
  [[nodiscard]] int port() const;

 private:
  class Server;
  std::unique_ptr<Server> server_;
};

}  // namespace tactbench::devices
