// A serial line, as a pseudo-terminal, that answers each Modbus RTU request by a test's script: late, short, damaged,
// for another unit.
#pragma once

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <cstdint>
#include <functional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "devices/wire/ends/end_activity.h"
#include "devices/wire/ends/stream_end.h"
#include "devices/wire/modbus/modbus_link.h"
#include "devices/wire/options.h"
#include "tests/devices/scripted_server.h"
#include "tests/devices/timeouts.h"

namespace tactbench::devices {

inline ModbusEndpoint rtu_endpoint(const std::string& port, int unit, Nanoseconds timeout = kPatient) {
  ModbusEndpoint endpoint;
  endpoint.serial_port = port;
  endpoint.baud = 115200;
  endpoint.unit = unit;
  endpoint.response_timeout = timeout;
  endpoint.max_reply_delay = std::chrono::milliseconds(50);
  return endpoint;
}

// Answers a reading of `count` registers, all of them `value`.
inline Bytes rtu_reading(int unit, int function, int count, std::uint16_t value) {
  Bytes frame{static_cast<std::uint8_t>(unit), static_cast<std::uint8_t>(function),
              static_cast<std::uint8_t>(2 * count)};
  for (int i = 0; i < count; ++i) {
    frame.push_back(static_cast<std::uint8_t>(value >> 8U));
    frame.push_back(static_cast<std::uint8_t>(value & 0xFFU));
  }
  return rtu_frame(frame);
}

class ScriptedLine {
 public:
  using Script = std::function<Bytes(int number, const Bytes& request)>;
  explicit ScriptedLine(Script script) : script_(std::move(script)), stop_(::eventfd(0, 0)) {
    thread_ = work_.thread([this] { serve(); });
  }
  ~ScriptedLine() {
    const std::uint64_t one = 1;
    [[maybe_unused]] const ssize_t written = ::write(stop_, &one, sizeof one);
    thread_.join();
    ::close(stop_);
  }
  ScriptedLine(const ScriptedLine&) = delete;
  ScriptedLine& operator=(const ScriptedLine&) = delete;
  [[nodiscard]] const std::string& path() const { return terminal_.path(); }

 private:
  void serve() {
    Bytes request;
    for (int number = 0;;) {
      pollfd watched[2]{{stop_, POLLIN, 0}, {terminal_.master(), POLLIN, 0}};
      if (work_.wait(watched) < 0) continue;
      if (watched[0].revents != 0) return;
      std::uint8_t bytes[64];
      const ssize_t got = ::read(terminal_.master(), bytes, sizeof bytes);
      if (got > 0) request.insert(request.end(), bytes, bytes + got);
      if (request.size() < 8) continue;  // the scripts get reading requests only
      const Bytes answer = script_(number++, request);
      request.clear();
      [[maybe_unused]] const ssize_t written = ::write(terminal_.master(), answer.data(), answer.size());
    }
  }
  Script script_;
  PseudoTerminal terminal_;
  int stop_;
  EndActivity work_;
  std::thread thread_;
};

}  // namespace tactbench::devices
