// Modbus TCP and RTU through libmodbus, without its pitfalls. TCP: any error closes the connection, so that a late
// reply is never mistaken for the answer to a later request; transaction, protocol, unit, function and length of each
// answer are checked here, because libmodbus does not check all of them. RTU has no transaction id: the line is flushed
// before each request; after an error it is closed and not used for `max_reply_delay`; and successive readings request
// register counts that differ by one if the register map allows it, so that a stale answer has the wrong length. Not
// thread-safe: one owner per line.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "devices/clock.h"
#include "devices/wire/options.h"

namespace tactbench::devices {

class ModbusLine;  // one connection or one serial port, shared by the units on it

class ModbusLink {
 public:
  // Does not connect yet. `device` is the instrument's name in faults.
  ModbusLink(ModbusEndpoint endpoint, std::string device, Clock& clock);
  // Another unit on the same line as `other`.
  ModbusLink(const ModbusLink& other, int unit, std::string device);
  ~ModbusLink();
  ModbusLink(const ModbusLink&) = delete;
  ModbusLink& operator=(const ModbusLink&) = delete;

  // Each of these is one exchange and blocks for at most response_timeout (plus the same again to connect; RTU plus
  // max_reply_delay after an error; a host name is resolved once, at the first connect, without a time limit). A
  // request to a busy device (exceptions 5 and 6) is repeated for busy_time. This is safe because every request sends
  // absolute values, so a repetition changes nothing, and because the owner waits here, so no newer value is overtaken.
  // Throws Fault TB-MODBUS-CONNECT (no connection, or it broke), TB-MODBUS-TIMEOUT (no reply, or no connection, in
  // time; process time has then advanced by response_timeout), TB-MODBUS-EXCEPTION (the device refused),
  // TB-MODBUS-BUSY (for longer than busy_time), TB-MODBUS-ECHO (RTU: the adapter echoes the request, or local_echo is
  // set and it does not) or TB-MODBUS-PROTOCOL (the answer does not match, or no frame can hold the request).
  // `readable`: number of registers that may be read from `address` on; more than into.size() lets RTU alternate.
  void read_input_registers(int address, std::span<std::uint16_t> into, std::size_t readable = 0);    // FC 4
  void read_holding_registers(int address, std::span<std::uint16_t> into, std::size_t readable = 0);  // FC 3
  [[nodiscard]] std::vector<bool> read_discrete_inputs(int address, int count);                       // FC 2
  void write_coil(int address, bool value);                                                           // FC 5
  void write_register(int address, std::uint16_t value);                                              // FC 6
  void write_registers(int address, std::span<const std::uint16_t> values);                           // FC 16
  void write_and_read_registers(int write_address, std::span<const std::uint16_t> values, int read_address,
                                std::span<std::uint16_t> into);  // FC 23, writes first

  void close() noexcept;
  [[nodiscard]] std::uint64_t exchanges() const { return exchanges_; }
  [[nodiscard]] const ModbusEndpoint& endpoint() const;
  [[nodiscard]] std::string take_busy_report() const;  // ModbusLine's
  // "analog module at 127.0.0.1:502 unit 1", the name in faults.
  [[nodiscard]] std::string peer() const;

 private:
  struct Request;
  std::vector<std::uint8_t> exchange(const Request& request);
  [[noreturn]] void fail_without_answer(const std::string& what, std::size_t sent);
  void read_registers(int function, int address, std::span<std::uint16_t> into, std::size_t readable);
  std::shared_ptr<ModbusLine> line_;
  int unit_;
  std::string device_;
  std::uint64_t exchanges_ = 0;
  bool longer_ = false;  // the next RTU reading requests one register more
};

// One Modbus connection or serial port of libmodbus: opened when needed, closed by any error. Used by modbus_link.cpp.
class ModbusLine {
 public:
  ModbusLine(ModbusEndpoint endpoint, Clock& clock);
  ~ModbusLine();
  ModbusLine(const ModbusLine&) = delete;
  ModbusLine& operator=(const ModbusLine&) = delete;

  // Sends unit and PDU and returns unit and PDU of the answer without header and checksum. Empty: the exchange failed,
  // `error()` is the reason (an errno value or one of libmodbus), and the line is then closed.
  std::vector<std::uint8_t> exchange(std::span<const std::uint8_t> request);
  // The echo of an exchange that failed on a serial line: as expected; received although none is expected; missing.
  enum class Echo { kAsExpected, kCame, kMissing };
  [[nodiscard]] Echo echo() const { return echo_; }
  [[nodiscard]] bool is_open() const { return context_ != nullptr; }
  // To be called only while closed. Throws Fault TB-MODBUS-CONNECT or TB-MODBUS-TIMEOUT on behalf of `device`.
  void open(const std::string& device, const std::string& peer);
  void close() noexcept;              // on the caller's request
  void close_after_error() noexcept;  // RTU: then silence for max_reply_delay
  [[nodiscard]] int error() const { return error_; }
  [[nodiscard]] bool is_rtu() const { return !endpoint_.serial_port.empty(); }
  [[nodiscard]] const ModbusEndpoint& endpoint() const { return endpoint_; }
  // Counts how often a device on this line was busy; `words` describes the last occurrence. take_busy_report() returns
  // that text after the first, second, fourth, eighth ... time, otherwise an empty text.
  void note_busy(std::string words);
  [[nodiscard]] std::string take_busy_report();
  [[nodiscard]] Clock& clock() { return clock_; }

 private:
  struct Context;
  void look_up(const std::string& device, const std::string& peer);
  [[noreturn]] void fail(int error, const std::string& device, const std::string& peer);
  void wait_for_gap();
  int receive(std::span<std::uint8_t> answer);
  std::size_t read(std::span<std::uint8_t> into, Nanoseconds timeout);
  [[nodiscard]] bool take_echo(std::span<const std::uint8_t> sent);
  [[nodiscard]] bool is_echo(std::span<const std::uint8_t> sent, std::span<std::uint8_t> came);
  ModbusEndpoint endpoint_;
  Clock& clock_;
  std::string address_;  // the numeric address of the host, once known
  std::unique_ptr<Context> context_;
  std::uint16_t transaction_ = 0;  // of the last request on this connection
  int error_ = 0;
  Echo echo_ = Echo::kAsExpected;
  long busy_ = 0, next_busy_report_ = 1;
  std::string busy_text_;
  // No request before this time; real time, since bytes on a line take real time.
  std::chrono::steady_clock::time_point quiet_until_{};
};

// Check sum of Modbus over serial line 1.02, section 6.2.2: polynomial 0xA001 reflected, start 0xFFFF; check value of
// "123456789" is 0x4B37. For frames that libmodbus does not send: simulated ends, and the Digital F/T's own functions.
std::uint16_t crc16_modbus(std::span<const std::uint8_t> bytes);
// `body` (unit, function, data) with its CRC, low byte first.
std::vector<std::uint8_t> rtu_frame(std::span<const std::uint8_t> body);

}  // namespace tactbench::devices
