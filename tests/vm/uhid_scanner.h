// The HID scanner's side of the wire as a device of this kernel's: made, answered and unplugged through /dev/uhid, so
// that hidraw and hidapi meet it like one on USB. Answers the reports of devices/tactile/scan_report.h.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <span>
#include <thread>
#include <vector>

#include "devices/tactile/scan_report.h"

namespace tactbench::tests {

class UhidScanner {
 public:
  static constexpr std::uint16_t kVendor = 0x5443;  // invented
  static constexpr std::uint16_t kProduct = 0x0016;
  using Report = std::array<std::uint8_t, devices::kScanReportBytes>;
  // Change of a scan's answer, in the scanner's thread, before it is sent; none by default.
  using Mishap = std::function<void(UhidScanner&, std::vector<Report>&)>;

  // Throws std::runtime_error when the kernel refuses.
  explicit UhidScanner(const char* serial);
  ~UhidScanner();  // unplugs, stops the thread
  UhidScanner(const UhidScanner&) = delete;
  UhidScanner& operator=(const UhidScanner&) = delete;

  void at_next_scan(Mishap mishap);  // for one scan; call it while none is under way
  void send(const Report& report);   // unasked; any thread
  void unplug();                     // once; any thread
  [[nodiscard]] std::chrono::steady_clock::time_point unplugged_at() const { return unplugged_at_; }

  // Sample of a taxel in scan n, from 0.
  static std::uint16_t sample(long scan, std::size_t taxel) {
    return static_cast<std::uint16_t>((257U * static_cast<unsigned>(scan) + 3U * taxel) & 0xFFFFU);
  }

 private:
  void create();
  void serve();
  void answer(std::span<const std::uint8_t> output);

  devices::IdentityReport identity_;
  int device_ = -1;
  int stop_ = -1;
  long scans_ = 0;
  std::uint16_t sequence_ = 0;
  Mishap mishap_;
  std::atomic<bool> plugged_{false};
  std::atomic<std::chrono::steady_clock::time_point> unplugged_at_{};
  std::thread thread_;
};

}  // namespace tactbench::tests
