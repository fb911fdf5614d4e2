// Simulated Digital F/T on a pseudo-terminal: calibration registers and a stream paced in real time; the wrench comes
// from a ForcePort.
#pragma once

#include <memory>
#include <string>

#include "devices/fault_injection.h"
#include "devices/force/digital_record.h"
#include "devices/force/force_sensor.h"

namespace tactbench::devices {

struct SimulatedDigitalFtFaults {  // test and nightly switches, all off by default; samples count from 0
  long silent_after_samples = -1;
  long damaged_sample = -1;   // this sample loses a byte
  long error_sample = -1;     // this sample carries the status error
  bool echoes = false;        // the line echoes what the client sends
  FaultInjector inject = {};  // for the samples of one wrench: silent, saturated (the status error)
};

class SimulatedDigitalFt {
 public:
  // The wrench is requested at each start of the stream and, free-running, then every 100 samples. On a manual clock,
  // which does not advance during a reading, a stream repeats its first sample: the number of samples sent before the
  // stop arrives depends on real time, and the same seed must give the same readings. The calibration's matrix must be
  // invertible. Throws Fault TB-SIM-LISTEN.
  SimulatedDigitalFt(const DigitalCalibration& calibration, ForcePort& port, bool free_running,
                     SimulatedDigitalFtFaults faults = {});
  ~SimulatedDigitalFt();  // stops the thread in bounded time
  SimulatedDigitalFt(const SimulatedDigitalFt&) = delete;
  SimulatedDigitalFt& operator=(const SimulatedDigitalFt&) = delete;
  [[nodiscard]] const std::string& path() const;  // the path that a client opens

 private:
  class Server;
  std::unique_ptr<Server> server_;
};

}  // namespace tactbench::devices
