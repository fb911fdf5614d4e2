// Simulated stage: a daisy chain of T-Series devices on a pseudo-terminal or a socket, moving in process time. It never
// advances the clock. Works with any client.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "devices/clock.h"
#include "devices/fault_injection.h"
#include "devices/stage/chain_device.h"
#include "devices/stage/stage.h"

namespace tactbench::devices {

// As in the paper: x and y T-LA60A, z T-NA08A50, numbered 1, 2, 3 from the computer's end.
[[nodiscard]] std::vector<ChainDeviceOptions> paper_chain();

struct SimulatedChainOptions {
  std::vector<ChainDeviceOptions> devices = paper_chain();
  std::array<std::size_t, kAxes> axes{0, 1, 2};  // which device is x, y, z
  std::string listen;                            // "" a pseudo-terminal, "tcp:PORT" (0: any), "unix:PATH"
  // True with a clock that runs by itself: ends of moves are sent when due. False with a manual clock: they are sent
  // before the next request is answered.
  bool free_running = false;
};

struct SimulatedChainFaults {       // test and nightly switches, all off by default; requests and replies count from 0
  long silent_after_requests = -1;  // answers this many requests, then none
  long unplug_after_requests = -1;
  long corrupt_reply = -1;                 // this reply carries another device's number
  long cut_reply = -1;                     // only three bytes of this reply are sent
  long late_reply = -1;                    // this reply is sent after the one that follows it
  FaultInjector inject = {};               // silent, late, corrupt, torn; unplugged hangs up
  std::function<StageStall()> stall = {};  // called at any time, under the chain's lock
};

class SimulatedChain final : public StageView {
 public:
  // Throws Fault TB-SIM-LISTEN.
  SimulatedChain(SimulatedChainOptions options, const Clock& clock, SimulatedChainFaults faults = {});
  ~SimulatedChain() override;  // stops the thread in bounded time
  SimulatedChain(const SimulatedChain&) = delete;
  SimulatedChain& operator=(const SimulatedChain&) = delete;

  [[nodiscard]] Millimetres position(Axis axis) const override;
  [[nodiscard]] std::array<Millimetres, kAxes> places(Nanoseconds time) const override;
  [[nodiscard]] bool at_rest_since(Nanoseconds time) const override;
  [[nodiscard]] std::string address() const;  // argument for open_serial()
  [[nodiscard]] std::uint64_t bytes_received() const;
  [[nodiscard]] std::vector<ZaberFrame> requests() const;  // all complete requests, as sent with message ids

  // Events that may happen at any time; callable from any thread.
  void unplug();   // returns once the client has lost the connection; the devices keep power and continue moving
  void plug_in();  // a pseudo-terminal then has a new address
  void power_cycle();
  void refuse_next(ZaberCommand command,
                   std::int32_t error);  // error for the next instruction of this kind, on any device
  void inject(const ZaberFrame& frame);  // sent unchanged before the next reply

 private:
  class Server;
  std::unique_ptr<Server> server_;
};

}  // namespace tactbench::devices
