// Simulated pressure controller on a pseudo-terminal (controller_lines.h); the pressure comes from a ChamberPort, whose
// span of 10 V is the full scale. It answers only requests, has no watchdog, and keeps its set-point if the line fails.
// Its exhaust is the port's dump valve. Works with any client.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <thread>

#include "devices/fault_injection.h"
#include "devices/pressure/chamber_port.h"
#include "devices/pressure/controller_lines.h"
#include "devices/pressure/options.h"
#include "devices/wire/ends/end_activity.h"
#include "devices/wire/ends/stream_end.h"

namespace tactbench::devices {

class SimulatedController {
 public:
  // `inject`: silent, late, corrupt (the first number is damaged), refused ("?", not carried out), unplugged (hangs
  // up). Uses only the letter, the decimals and `exhausts` of `options`. Throws Fault TB-SIM-LISTEN.
  SimulatedController(const SerialControllerOptions& options, Psi full_scale, ChamberPort& chamber,
                      FaultInjector inject = {});
  ~SimulatedController();  // stops the thread in bounded time
  SimulatedController(const SimulatedController&) = delete;
  SimulatedController& operator=(const SimulatedController&) = delete;
  [[nodiscard]] const std::string& path() const { return end_.address(); }  // what a client opens
  [[nodiscard]] std::uint64_t requests() const { return requests_; }
  void unplug();   // the client loses the connection; set-point and valves are unchanged
  void plug_in();  // under a new path()

 private:
  void start();
  void stop();
  void serve();
  void answer(const std::string& line);
  bool carry_out(const ControllerRequest& request);  // false: refused
  const SerialControllerOptions options_;
  const Psi full_scale_;
  ChamberPort& chamber_;
  const FaultInjector inject_;
  StreamEnd end_{""};
  double setpoint_ = 0.0;
  bool exhausting_ = false;
  std::string line_, late_;
  std::atomic<std::uint64_t> requests_{0};
  int stop_ = -1;  // readable: end
  std::optional<EndActivity> work_;
  std::thread thread_;
};

}  // namespace tactbench::devices
