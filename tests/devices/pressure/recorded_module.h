// A Modbus TCP module that keeps every register, coil and discrete input as written, logs each request as text, and
// deviates where a test requests it.
#pragma once

#include <fmt/format.h>

#include <array>
#include <functional>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "devices/pressure/analog_module.h"
#include "tests/devices/scripted_server.h"
#include "tests/devices/timeouts.h"

namespace tactbench::devices {

class RecordedModule {
 public:
  using Notes = std::vector<std::string>;

  RecordedModule() : server_([this](int, int socket, const Bytes& request) { serve(socket, request); }) {}

  [[nodiscard]] ModbusEndpoint endpoint() const { return {"127.0.0.1", server_.port(), 1, kPatient}; }
  // The requests since the last call: function, address in hexadecimal, count or what is written.
  [[nodiscard]] Notes notes() {
    const std::lock_guard lock(mutex_);
    return std::exchange(notes_, {});
  }
  [[nodiscard]] std::uint16_t at(std::size_t address) {
    const std::lock_guard lock(mutex_);
    return registers_.at(address);
  }
  void set(std::size_t address, const std::vector<std::uint16_t>& words) {
    const std::lock_guard lock(mutex_);
    for (std::size_t i = 0; i < words.size(); ++i) registers_.at(address + i) = words[i];
  }
  void set_inputs(std::set<std::size_t> on) {
    const std::lock_guard lock(mutex_);
    discrete_ = std::move(on);
  }
  [[nodiscard]] std::size_t connections() {
    const std::lock_guard lock(mutex_);
    return sockets_.size();
  }
  // Called with each note, before the request is carried out: an exception's number refuses it, 0 breaks the
  // connection, a negative number answers without carrying it out. It must not call the module.
  void interfere(std::function<std::optional<int>(const std::string& note)> how) {
    const std::lock_guard lock(mutex_);
    interfere_ = std::move(how);
  }

 private:
  void serve(int socket, const Bytes& request) {
    const std::lock_guard lock(mutex_);
    sockets_.insert(socket);
    const auto word = [&](std::size_t i) { return static_cast<std::size_t>(request[i] << 8U | request[i + 1]); };
    const int function = request[7];
    const std::size_t address = word(8);
    std::string note = fmt::format("{} {:04X}", function, address);
    std::vector<std::uint16_t> written;
    const bool both = function == 23;
    if (function == 16 || both) {
      const std::size_t count = word(both ? 14 : 10), first = both ? 17 : 13;
      for (std::size_t i = 0; i < count; ++i) written.push_back(static_cast<std::uint16_t>(word(first + 2 * i)));
    } else if (function == 5 || function == 6) {
      written.push_back(static_cast<std::uint16_t>(word(10)));
    }
    if (function <= 4 || both) note += fmt::format(" {}", word(10));
    if (both) note += fmt::format(" {:04X}", word(12));
    for (const std::uint16_t value : written) note += fmt::format(" <{}", value);
    notes_.push_back(note);
    const std::optional<int> other = interfere_ ? interfere_(note) : std::nullopt;
    if (other == 0) {
      ::shutdown(socket, SHUT_RDWR);
      return;
    }
    if (other && *other > 0) {
      ScriptedServer::send(socket, {request[0], request[1], 0, 0, 0, 3, request[6],
                                    static_cast<std::uint8_t>(function | 0x80), static_cast<std::uint8_t>(*other)});
      return;
    }
    if (!other && function != 5) {
      for (std::size_t i = 0; i < written.size(); ++i) registers_.at((both ? word(12) : address) + i) = written[i];
    }
    ScriptedServer::send(socket, answer(request, function, address, word(10)));
  }

  [[nodiscard]] Bytes answer(const Bytes& request, int function, std::size_t address, std::size_t count) const {
    if (function == 2) {
      Bytes reply(request.begin(), request.begin() + 8);
      reply[5] = static_cast<std::uint8_t>(3 + (count + 7) / 8);
      reply.push_back(static_cast<std::uint8_t>((count + 7) / 8));
      reply.resize(9 + (count + 7) / 8);
      for (std::size_t i = 0; i < count; ++i) {
        if (discrete_.contains(address + i))
          reply[9 + i / 8] = static_cast<std::uint8_t>(reply[9 + i / 8] | 1U << i % 8);
      }
      return reply;
    }
    if (function == 5 || function == 6) return request;
    if (function == 16) {
      Bytes reply(request.begin(), request.begin() + 12);
      reply[4] = 0;
      reply[5] = 6;
      return reply;
    }
    std::vector<std::uint16_t> values;
    for (std::size_t i = 0; i < count; ++i) values.push_back(registers_.at(address + i));
    return ScriptedServer::answer(request, values);
  }

  std::mutex mutex_;
  Notes notes_;
  std::array<std::uint16_t, 0x10000> registers_{};
  std::set<std::size_t> discrete_;
  std::set<int> sockets_;  // the server closes none before its end
  std::function<std::optional<int>(const std::string&)> interfere_;
  ScriptedServer server_;
};

}  // namespace tactbench::devices
