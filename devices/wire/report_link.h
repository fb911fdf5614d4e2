// A transport of numbered HID reports. The real side is hidapi on hidraw; the simulated side is a local SOCK_SEQPACKET
// socket. Drivers work with both.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "devices/clock.h"
#include "devices/wire/options.h"

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

// ReportLink over hidapi (hidraw backend). Not verified on hardware; verified on a kernel's uhid device in a virtual
// machine (tests/vm).
struct HidInfo {
  std::uint16_t vendor_id = 0;
  std::uint16_t product_id = 0;
  std::string serial, product, path;
};
[[nodiscard]] std::vector<HidInfo> list_hid_devices();

// Opens the device. Throws Fault TB-HID-OPEN, listing the HID devices present.
std::unique_ptr<ReportLink> open_hid_link(const HidAddress& address);

// ReportLink over a local SOCK_SEQPACKET socket: one packet is one report.
// Connects to the socket file `path`. Throws Fault TB-HID-OPEN.
std::unique_ptr<ReportLink> open_packet_link(const std::string& path);

}  // namespace tactbench::devices
