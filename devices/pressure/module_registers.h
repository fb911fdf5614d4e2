// Register map of one unit of the simulated module: outputs and inputs at the profile's addresses, the EK9000's
// watchdog on process time and its write lock, Moxa's safe mode, further quantities. No sockets; used only by
// simulated_module.cpp.
//
// Beckhoff: read 0x1020 watchdog time left in ms, 0x1021 fallbacks so far, 0x1022 connections, 0x1120-0x1124 (FC 3);
// after a fallback, writes to outputs are refused (exception 4) until 0xBECF, 0xAFFE are written to 0x1121. The bus
// stop (0x1123 = 2) is refused as not simulated. Where the manuals state nothing (direction of 0x1020, the exception
// numbers, which client feeds the watchdog if the lock is off, that a channel in safe mode ignores writes), this is our
// interpretation, not verified on hardware.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "devices/clock.h"
#include "devices/pressure/analog_module.h"
#include "devices/pressure/chamber_port.h"
#include "devices/pressure/simulated_module.h"

namespace tactbench::devices {

// Modbus exception codes; kNone: carried out.
enum class Refusal { kNone = 0, kFunction = 1, kAddress = 2, kValue = 3, kFailure = 4, kBusy = 6 };

class ModuleRegisters {
 public:
  ModuleRegisters(SimulatedUnit unit, ChamberPort& chamber, const Clock& clock);
  ModuleRegisters(const ModuleRegisters&) = delete;
  ModuleRegisters& operator=(const ModuleRegisters&) = delete;
  [[nodiscard]] int unit() const { return unit_.unit; }

  // Lets the watchdog fall back if its time has expired; to be called before each request.
  void turn();
  // `function` is 3 (also for FC 23) or 4; `client` is the requesting client (the watchdog has one master).
  [[nodiscard]] Refusal check_read(int function, int address, std::size_t count) const;
  [[nodiscard]] Refusal read(int client, int function, int address, std::span<std::uint16_t> into);
  [[nodiscard]] Refusal write(int client, int address, std::span<const std::uint16_t> values);
  [[nodiscard]] Refusal read_bits(int address, std::span<std::uint8_t> into) const;  // FC 2
  [[nodiscard]] Refusal write_bit(int address, bool value);                          // FC 5
  void connected() { ++connections_; }
  void disconnected(int client);

 private:
  [[nodiscard]] bool outputs_hold(int address, std::size_t count) const;
  [[nodiscard]] bool inputs_hold(int address, std::size_t count) const;
  [[nodiscard]] const SimulatedQuantity* quantity_at(int function, int address, std::size_t count) const;
  [[nodiscard]] Refusal write_setting(int offset, std::uint16_t value);
  [[nodiscard]] std::uint16_t read_one(int function, int address);
  [[nodiscard]] std::uint16_t read_input(int offset);
  void feed(bool by_write);
  void drive();

  static constexpr int kNobody = -1;
  SimulatedUnit unit_;
  const ModuleOutputs& out_;
  const ModuleInputs& in_;
  int watchdog_at_;  // -1: none
  ChamberPort& chamber_;
  const Clock& clock_;
  std::vector<std::uint16_t> outputs_;
  std::array<std::uint16_t, 5> settings_{1000, 0, 1, 0, 1};  // 0x1120: time ms, reset, type, fallback, write lock
  int connections_ = 0;
  int master_ = kNobody;  // client that wrote process data first; only its telegrams feed the watchdog
  bool armed_ = false;
  bool tripped_ = false;
  bool reset_begun_ = false;
  std::uint16_t fallbacks_ = 0;
  Nanoseconds deadline_{0};
  std::vector<std::uint8_t> safe_mode_;  // one per output
};

}  // namespace tactbench::devices
