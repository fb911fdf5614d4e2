#include "devices/pressure/simulated_rtu.h"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>

#include "devices/wire/modbus/modbus_line.h"

namespace tactbench::devices {
namespace {

constexpr int kOnlyClient = 0;
// A client never pauses longer than this inside a frame; an older incomplete frame is noise.
constexpr Nanoseconds kFramePause = std::chrono::milliseconds(100);

// Bytes of the request that begins `bytes` (unit, function, ..., check sum); 0: not yet known.
std::size_t request_size(std::span<const std::uint8_t> bytes) {
  if (bytes.size() < 2) return 0;
  if (bytes[1] == 16) return bytes.size() < 7 ? 0 : 9U + bytes[6];
  if (bytes[1] == 23) return bytes.size() < 11 ? 0 : 13U + bytes[10];
  return 8;
}

}  // namespace

SimulatedModule::RtuServer::RtuServer(std::vector<SimulatedUnit> units, ChamberPort& chamber, const Clock& clock,
                                      SimulatedModuleFaults faults)
    : Server(std::move(units), chamber, clock, faults), echoes_(faults.echoes) {
  modbus_ = modbus_new_rtu(terminal_.path().c_str(), 9600, 'N', 8, 1);
  if (modbus_ == nullptr || stop_ < 0) fail_to_listen("serving " + terminal_.path(), errno);
  connected();
  start();
}

SimulatedModule::RtuServer::~RtuServer() { stop(); }

void SimulatedModule::RtuServer::serve() {
  for (;;) {
    std::array<pollfd, 2> descriptors{pollfd{stop_, POLLIN, 0}, pollfd{terminal_.master(), POLLIN, 0}};
    const int ready = work_.wait(descriptors, received_.empty() ? std::nullopt : std::optional(kFramePause));
    if (ready == 0) received_.clear();
    if (descriptors[0].revents != 0) return;
    if (ready > 0 && descriptors[1].revents != 0 && !attend()) {
      terminal_.hang_up();
      return;
    }
  }
}

// False: hang up the line.
bool SimulatedModule::RtuServer::attend() {
  std::array<std::uint8_t, MODBUS_RTU_MAX_ADU_LENGTH> bytes{};
  const ssize_t got = ::read(terminal_.master(), bytes.data(), bytes.size());
  if (got <= 0) return got < 0 && (errno == EAGAIN || errno == EINTR);
  if (echoes_) (void)!::write(terminal_.master(), bytes.data(), static_cast<std::size_t>(got));
  received_.insert(received_.end(), bytes.begin(), bytes.begin() + got);
  for (;;) {
    const std::size_t size = request_size(received_);
    if (size == 0 || received_.size() < size) return true;
    const auto frame = std::span<const std::uint8_t>(received_).first(size);
    const std::uint16_t crc = crc16_modbus(frame.first(size - 2));
    if (frame[size - 2] != (crc & 0xFFU) || frame[size - 1] != crc >> 8U) {
      received_.clear();  // a damaged request is not answered, and only silence marks where the next one begins
      return true;
    }
    if (answer(kOnlyClient, terminal_.master(), frame, 0, 2) == Answer::kDie) return false;
    received_.erase(received_.begin(), received_.begin() + static_cast<std::ptrdiff_t>(size));
  }
}

}  // namespace tactbench::devices
