// The paper's scanner: 16 columns on analog inputs of an NI USB-6259, 16 rows closed in turn by electro-mechanical
// relays on digital lines (paper section 2). Not verified on hardware.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "devices/tactile/options.h"
#include "devices/tactile/tactile_array.h"
#include "devices/wire/daqmx/daqmx_api.h"

namespace tactbench::devices {

// Counts: the driver's calibrated volts, averaged over samples_per_row and rounded to range / 65535; below 0 V they are
// 0. The status bit for the converter's limit is set by a sample at the range, and by a column more than 1 % of the
// range below 0 V, which indicates wrong wiring rather than noise.
class DaqmxScanner final : public TactileArray {
 public:
  // Opens all relays. Throws the faults of DaqmxApi, and TB-SCANNER-GEOMETRY when the numbers of channels and lines
  // differ from those of columns and rows.
  DaqmxScanner(DaqmxScannerOptions options, Clock& clock);
  ~DaqmxScanner() override;  // opens all relays
  DaqmxScanner(const DaqmxScanner&) = delete;
  DaqmxScanner& operator=(const DaqmxScanner&) = delete;

  // The settling time is process time: a manual clock advances by rows x settle per scan. All relays are open when this
  // returns or throws. Also throws TB-SCANNER-TIMEOUT, TB-SCANNER-LOST, TB-SCANNER-CORRUPT (samples lost). Device time
  // is process time, because the card has no clock that can be read.
  [[nodiscard]] ScanSet read(int scans) override;
  [[nodiscard]] int rows() const override { return options_.rows; }
  [[nodiscard]] int columns() const override { return options_.columns; }
  [[nodiscard]] Volts volts_per_count() const override { return options_.range * (1.0 / 65535.0); }
  // Writes and acquisitions requested from the driver.
  [[nodiscard]] std::uint64_t exchanges() const override { return exchanges_; }
  [[nodiscard]] Identity identity() const override;
  // Number of times each row's relay has closed since construction; relays wear out.
  [[nodiscard]] std::vector<std::uint64_t> relay_operations() const override { return relay_operations_; }
  [[nodiscard]] const std::vector<std::string>& warnings() const { return api_.warnings(); }

 private:
  void set_relays(int closed_row);  // -1: all open
  void open_relays() noexcept;
  void read_row(ScanSet& set, int row);
  DaqmxScannerOptions options_;
  Clock& clock_;
  DaqmxApi api_;
  DaqmxDevice device_;
  DaqmxTask inputs_;
  DaqmxTask relays_;
  std::vector<std::uint8_t> levels_;
  std::vector<double> volts_;
  std::vector<std::uint64_t> relay_operations_;
  std::uint32_t frame_ = 0;
  std::uint64_t exchanges_ = 0;
};

}  // namespace tactbench::devices
