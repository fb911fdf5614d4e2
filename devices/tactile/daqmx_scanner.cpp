#include "devices/tactile/daqmx_scanner.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "devices/tactile/scan_report.h"

namespace tactbench::devices {
namespace {

constexpr const char* kDaqmxDevice = "tactile scanner";
constexpr double kFullCount = 65535.0;
constexpr double kBelowZero = -0.01;  // of the range

void require_geometry(bool holds, const std::string& what) {
  if (holds) return;
  throw Fault("TB-SCANNER-GEOMETRY", kDaqmxDevice, what,
              "Correct channels, lines, rows and columns in the bench file.");
}

// The driver's refusal as a fault of this interface; other faults stay as they are.
[[noreturn]] void rethrow(const Fault& fault) {
  const auto* error = dynamic_cast<const DaqmxError*>(&fault);
  const char* id = fault.id() == "TB-DAQMX-SHORT" ? "TB-SCANNER-CORRUPT"
                   : error == nullptr             ? fault.id().c_str()
                   : error->timed_out()           ? "TB-SCANNER-TIMEOUT"
                   : error->device_gone()         ? "TB-SCANNER-LOST"
                   : error->samples_lost()        ? "TB-SCANNER-CORRUPT"
                                                  : fault.id().c_str();
  throw Fault(id, kDaqmxDevice, fault.what(), fault.remedy());
}

}  // namespace

DaqmxScanner::DaqmxScanner(DaqmxScannerOptions options, Clock& clock)
    : options_(std::move(options)),
      clock_(clock),
      api_(options_.library),
      device_(api_.device(options_.device, options_.expected_serial)),
      inputs_(api_),
      relays_(api_) {
  require_geometry(options_.rows > 0 && options_.columns > 0 && options_.samples_per_row > 0 &&
                       options_.sample_rate_hz > 0 && options_.range.value() > 0,
                   "rows, columns, samples, rate and range are above 0");
  // Opens the relays first, so that they are open whatever fails afterwards.
  relays_.add_output_lines(options_.row_lines);
  const int lines = relays_.channels();
  require_geometry(lines == options_.rows,
                   fmt::format("{} rows need as many lines; {} makes {}", options_.rows, options_.row_lines, lines));
  levels_.resize(static_cast<std::size_t>(options_.rows));
  relay_operations_.resize(static_cast<std::size_t>(options_.rows));
  set_relays(-1);
  inputs_.add_voltages(options_.column_channels, options_.terminal, options_.range);
  const int channels = inputs_.channels();
  require_geometry(channels == options_.columns, fmt::format("{} columns need as many analog inputs; {} makes {}",
                                                             options_.columns, options_.column_channels, channels));
  volts_.resize(static_cast<std::size_t>(options_.columns) * static_cast<std::size_t>(options_.samples_per_row));
  inputs_.finite_samples(options_.sample_rate_hz, options_.samples_per_row);
  if (options_.convert_rate_hz > 0) inputs_.convert_rate(options_.convert_rate_hz);
  inputs_.commit();
}

DaqmxScanner::~DaqmxScanner() { open_relays(); }

void DaqmxScanner::set_relays(int closed_row) {
  const std::uint8_t open = options_.relays_active_low ? 1 : 0;
  std::fill(levels_.begin(), levels_.end(), open);
  if (closed_row >= 0) {
    levels_[static_cast<std::size_t>(closed_row)] = open ^ 1U;
    ++relay_operations_[static_cast<std::size_t>(closed_row)];
  }
  ++exchanges_;
  relays_.write_lines(levels_);
}

void DaqmxScanner::open_relays() noexcept {
  try {
    set_relays(-1);
  } catch (const std::exception&) {
    // The failure that led here is reported.
  }
}

ScanSet DaqmxScanner::read(int scans) {
  ScanSet set;
  set.rows = options_.rows;
  set.columns = options_.columns;
  set.scans = scans;
  set.time = clock_.now();
  set.device_time_us =
      static_cast<std::uint32_t>(std::chrono::duration_cast<std::chrono::microseconds>(set.time).count());
  try {
    for (int index = 0; index < scans; ++index) {
      for (int row = 0; row < set.rows; ++row) read_row(set, row);
      set.frame_counters.push_back(frame_++);
    }
    set_relays(-1);
  } catch (const Fault& fault) {
    inputs_.stop();
    open_relays();
    rethrow(fault);
  }
  return set;
}

void DaqmxScanner::read_row(ScanSet& set, int row) {
  set_relays(row);
  clock_.wait_until(clock_.now() + options_.settle);
  const std::chrono::duration<double> duration(options_.samples_per_row / options_.sample_rate_hz);
  const Nanoseconds timeout = options_.frame_timeout + std::chrono::duration_cast<Nanoseconds>(duration);
  ++exchanges_;
  inputs_.start();
  try {
    inputs_.read(options_.samples_per_row, timeout, volts_);
  } catch (const DaqmxError& error) {
    if (error.timed_out()) clock_.reply_lost(timeout);
    throw;
  }
  inputs_.stop();
  const auto columns = static_cast<std::size_t>(options_.columns);
  const double range = options_.range.value();
  for (std::size_t column = 0; column < columns; ++column) {
    double sum = 0.0;
    bool at_limit = false;
    for (std::size_t at = column; at < volts_.size(); at += columns) {
      sum += volts_[at];
      at_limit = at_limit || volts_[at] >= range;
    }
    const double mean = sum / options_.samples_per_row;
    if (at_limit || mean < kBelowZero * range) set.status = static_cast<std::uint8_t>(set.status | kStatusAtLimit);
    const double count = std::clamp(std::round(mean / volts_per_count().value()), 0.0, kFullCount);
    set.counts.push_back(static_cast<std::uint16_t>(count));
  }
}

Identity DaqmxScanner::identity() const {
  return {"tactile scanner", "NI " + device_.product_type, device_.serial, "",
          device_.simulated ? Origin::kSimulated : options_.origin};
}

}  // namespace tactbench::devices
