// One Modbus TCP connection through libmodbus, with its traps closed: any error closes the socket, so that a late
// reply can never be taken for the answer to a later request (libmodbus blocks or lies otherwise); the next request
// connects anew. Not thread-safe: one owner.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "devices/clock.h"

namespace tactbench::devices {

struct ModbusEndpoint {
  std::string host = "127.0.0.1";
  int port = 502;
  int unit = 1;
  Nanoseconds response_timeout = std::chrono::milliseconds(500);
};

class ModbusLink {
 public:
  // Does not connect yet. `device` names the instrument in faults.
  ModbusLink(ModbusEndpoint endpoint, std::string device, Clock& clock);
  ~ModbusLink();
  ModbusLink(const ModbusLink&) = delete;
  ModbusLink& operator=(const ModbusLink&) = delete;

  // Each of these is one exchange, blocks at most response_timeout (plus the same again to connect) and throws Fault
  // TB-MODBUS-CONNECT, TB-MODBUS-TIMEOUT, TB-MODBUS-EXCEPTION or TB-MODBUS-PROTOCOL.
  void read_input_registers(int address, std::span<std::uint16_t> into);      // FC 4
  void read_holding_registers(int address, std::span<std::uint16_t> into);    // FC 3
  void write_registers(int address, std::span<const std::uint16_t> values);   // FC 16
  void write_and_read_registers(int write_address, std::span<const std::uint16_t> values, int read_address,
                                std::span<std::uint16_t> into);               // FC 23, writes first

  void close() noexcept;
  [[nodiscard]] std::uint64_t exchanges() const { return exchanges_; }
  [[nodiscard]] const ModbusEndpoint& endpoint() const { return endpoint_; }

 private:
  struct Context;
  void connect();
  template <class Request>
  void exchange(const char* what, int address, int expected, Request&& request);
  ModbusEndpoint endpoint_;
  std::string device_;
  Clock& clock_;
  std::unique_ptr<Context> context_;
  std::uint64_t exchanges_ = 0;
};

}  // namespace tactbench::devices
