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

  // Each of these is one exchange, blocks at most response_timeout (plus the same again to connect; a host given by
  // name is looked up once, at the first connect, in the resolver's time) and throws Fault
  // TB-MODBUS-CONNECT (no connection, or it broke), TB-MODBUS-TIMEOUT (no reply, or no connection, in time; process
  // time has then spent response_timeout), TB-MODBUS-EXCEPTION (the device refused) or TB-MODBUS-PROTOCOL (an answer
  // that does not fit, or a request that no frame can hold).
  void read_input_registers(int address, std::span<std::uint16_t> into);     // FC 4
  void read_holding_registers(int address, std::span<std::uint16_t> into);   // FC 3
  void write_registers(int address, std::span<const std::uint16_t> values);  // FC 16
  void write_and_read_registers(int write_address, std::span<const std::uint16_t> values, int read_address,
                                std::span<std::uint16_t> into);  // FC 23, writes first

  void close() noexcept;
  [[nodiscard]] std::uint64_t exchanges() const { return exchanges_; }
  [[nodiscard]] const ModbusEndpoint& endpoint() const { return endpoint_; }
  // "analog module at 127.0.0.1:502 unit 1", as faults name it.
  [[nodiscard]] std::string peer() const;

 private:
  struct Context;
  struct Request;
  void connect();
  void look_up();
  template <class Call>
  void exchange(const Request& request, Call&& call);
  [[noreturn]] void fail_connect(int error);
  [[noreturn]] void fail_exchange(const Request& request, int result, int error);
  ModbusEndpoint endpoint_;
  std::string device_;
  Clock& clock_;
  std::string address_;  // the host in numbers, once known
  std::unique_ptr<Context> context_;
  std::uint64_t exchanges_ = 0;
};

}  // namespace tactbench::devices
