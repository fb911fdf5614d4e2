// Simulated source of the frame-source protocol: a TCP server on 127.0.0.1; counts come from a TactilePort. Answers
// requests; clients that subscribe get frames in real time.
#pragma once

#include <memory>

#include "devices/clock.h"
#include "devices/tactile/frame_protocol.h"
#include "devices/tactile/simulated_scanner.h"

namespace tactbench::devices {

struct SimulatedFrameSourceFaults {  // test and nightly switches, all off by default; scans are counted from 0
  long silent_after_scans = -1;      // answers this many scans, then none
  long corrupt_scan = -1;            // flips a bit in the answer
  long drop_scan = -1;               // computes the frame but does not send it
  long repeat_scan = -1;             // answers with the previous frame under the new tag
  long double_scan = -1;             // sends the answer twice
  long cut_scan = -1;                // sends half the answer, then closes the connection
  FaultInjector inject = {};         // silent, stale, corrupt, torn (as cut_scan); unplugged: connections close
};

struct SimulatedFrameSourceOptions {
  frame_protocol::Description description;
  int port = 0;                    // 0: the system chooses
  double free_running_hz = 100.0;  // to subscribers, in real time
  SimulatedFrameSourceFaults faults = {};
};

class SimulatedFrameSource {
 public:
  // Serves up to 16 clients. Throws Fault TB-SIM-LISTEN; std::invalid_argument for a description that the protocol
  // cannot encode.
  SimulatedFrameSource(SimulatedFrameSourceOptions options, TactilePort& port, const Clock& clock);
  ~SimulatedFrameSource();  // stops the thread in bounded time
  SimulatedFrameSource(const SimulatedFrameSource&) = delete;
  SimulatedFrameSource& operator=(const SimulatedFrameSource&) = delete;
  [[nodiscard]] int port() const;

 private:
  class Server;
  std::unique_ptr<Server> server_;
};

}  // namespace tactbench::devices
