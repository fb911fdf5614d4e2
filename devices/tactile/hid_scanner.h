// Driver of the HID scanner over any ReportLink: assembles frames from row reports, detects gaps, duplicates and damage
// by sequence number, tag and CRC, and discards queued reports before each request. Reports with other ids, which other
// functions of the same device send unsolicited, are ignored.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "devices/tactile/options.h"
#include "devices/tactile/scan_report.h"
#include "devices/tactile/tactile_array.h"
#include "devices/wire/report_link.h"
#include "devices/wire/wait.h"

namespace tactbench::devices {

class HidScanner final : public TactileArray {
 public:
  // Identifies the scanner. Throws Fault TB-SCANNER-TIMEOUT, TB-SCANNER-LOST, TB-SCANNER-GEOMETRY,
  // TB-SCANNER-SERIAL.
  HidScanner(std::unique_ptr<ReportLink> link, HidScannerOptions options, Clock& clock);
  [[nodiscard]] ScanSet read(int scans) override;
  [[nodiscard]] int rows() const override { return options_.rows; }
  [[nodiscard]] int columns() const override { return options_.columns; }
  [[nodiscard]] Volts volts_per_count() const override { return Volts(described_.volts_per_count); }
  [[nodiscard]] std::uint64_t exchanges() const override { return exchanges_; }
  [[nodiscard]] Identity identity() const override;

 private:
  std::uint16_t send(ScanCommand command);  // drains, sends, returns the tag that the answers carry
  std::size_t receive(std::span<std::uint8_t> into, RealTime end, std::uint8_t id);
  void identify();
  void read_scan(ScanSet& set, int index);
  [[noreturn]] void timed_out(const std::string& asked, const std::string& came);
  std::unique_ptr<ReportLink> link_;
  HidScannerOptions options_;
  Clock& clock_;
  IdentityReport described_;
  std::uint16_t next_tag_ = 1;
  std::uint64_t exchanges_ = 0;
};

}  // namespace tactbench::devices
