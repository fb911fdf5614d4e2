// Simulated scanner: a SOCK_SEQPACKET server of the reports in scan_report.h; counts come from a TactilePort. Sends
// only on request.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "devices/clock.h"
#include "devices/fault_injection.h"
#include "devices/tactile/options.h"
#include "devices/tactile/scan_report.h"

namespace tactbench::devices {

// Interface from the simulated scanner to the physics; called from the scanner's thread while the clock does not
// advance.
class TactilePort {
 public:
  virtual ~TactilePort() = default;
  // One scan of the whole array: rows x columns counts, row-major, with noise and relay settling. Returns the
  // status byte of each row through `status` (size rows).
  virtual void scan(std::span<std::uint16_t> counts, std::span<std::uint8_t> status) = 0;
};

class SimulatedScanner {
 public:
  // Binds `path` (a socket file; its folder must exist) and serves one client after another. Throws Fault
  // TB-SIM-LISTEN.
  SimulatedScanner(std::string path, IdentityReport identity, TactilePort& port, const Clock& clock,
                   SimulatedScannerFaults faults = {});
  ~SimulatedScanner();  // stops the thread in bounded time; removes the socket file
  SimulatedScanner(const SimulatedScanner&) = delete;
  SimulatedScanner& operator=(const SimulatedScanner&) = delete;

 private:
  class Server;
  std::unique_ptr<Server> server_;
};

}  // namespace tactbench::devices
