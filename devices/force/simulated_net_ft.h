// Simulated Net F/T on loopback: RDT over UDP and the page netftapi2.xml over HTTP; the wrench comes from a ForcePort.
// Requests for a number of records are answered immediately, endless streams are paced in real time.
#pragma once

#include <cstdint>
#include <memory>

#include "devices/fault_injection.h"
#include "devices/force/force_sensor.h"
#include "devices/force/netft_xml.h"

namespace tactbench::devices {

struct SimulatedNetFtFaults {      // test and nightly switches, all off by default; records count from 0
  long silent_after_records = -1;  // sends this many records, then none
  long drop_record = -1;           // omits this record
  long late_record = -1;           // sends this record after the next (within one request)
  long stall_from_record = -1;     // the F/T sequence does not advance from this record on
  long status_record = -1;         // this record carries status_bits
  std::uint32_t status_bits = 0x80020000U;
  FaultInjector inject =
      {};  // for up to 64 records at once: silent, stale (the F/T sequence does not advance), saturated
};

struct SimulatedNetFtOptions {
  int rdt_port = 0;   // 0: the system chooses
  int http_port = 0;  // 0: the system chooses
  NetFtPage page;     // the page served, with the scale of the counts; endless streams run at records_per_second
  SimulatedNetFtFaults faults;
};

class SimulatedNetFt {
 public:
  // Listens on 127.0.0.1. Sends only on request, to one client at a time (the last that asked). Executes bias and stop;
  // treats buffered and multi-unit start as a real-time start. No monitor ever trips, so resetting the latch has no
  // effect. Throws Fault TB-SIM-LISTEN.
  SimulatedNetFt(SimulatedNetFtOptions options, ForcePort& port);
  ~SimulatedNetFt();  // stops the thread in bounded time
  SimulatedNetFt(const SimulatedNetFt&) = delete;
  SimulatedNetFt& operator=(const SimulatedNetFt&) = delete;
  [[nodiscard]] int rdt_port() const;
  [[nodiscard]] int http_port() const;

 private:
  class Server;
  std::unique_ptr<Server> server_;
};

}  // namespace tactbench::devices
