// A transport of numbered HID reports. The real side is hidapi on hidraw (hid_link.h); the simulated side is a local
// SOCK_SEQPACKET socket (packet_link.h). Drivers work with both.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "devices/clock.h"

namespace tactbench::devices {

class ReportLink {
 public:
  virtual ~ReportLink() = default;
  // Sends one report; its first byte is the report id. Throws Fault TB-HID-WRITE.
  virtual void write(std::span<const std::uint8_t> report) = 0;
  // Waits for one report; 0 when none came before `timeout`. Retries EINTR. Throws Fault TB-HID-LOST when the device
  // is gone (the link never recovers: make a new one).
  [[nodiscard]] virtual std::size_t read(std::span<std::uint8_t> into, Nanoseconds timeout) = 0;
  // Discards the queued reports, so that no stale one is used; returns their number.
  virtual std::size_t drain() = 0;
  [[nodiscard]] virtual std::string description() const = 0;
};

}  // namespace tactbench::devices
