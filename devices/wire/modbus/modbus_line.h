// One Modbus connection or serial port of libmodbus: opened when needed, closed by any error. Used by modbus_link.cpp.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "devices/wire/modbus/modbus_link.h"

namespace tactbench::devices {

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
