#include "devices/tactile/hid_scanner.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>
#include <vector>

#include "devices/device.h"
#include "devices/wire/wait.h"

namespace tactbench::devices {
namespace {

constexpr const char* kHidDevice = "tactile scanner";
using Buffer = std::array<std::uint8_t, kScanReportBytes + 1>;  // one more shows a report that is too long

[[noreturn]] void corrupt(const ReportLink& link, const std::string& what) {
  throw Fault("TB-SCANNER-CORRUPT", kHidDevice, fmt::format("{}, on {}", what, link.description()),
              "Read again; if it recurs, check the scanner's cable and its firmware.");
}

// Runs `talk`; a lost transport becomes TB-SCANNER-LOST.
template <class Talk>
void with_scanner(Talk&& talk) {
  try {
    talk();
  } catch (const Fault& fault) {
    if (fault.id() != "TB-HID-LOST" && fault.id() != "TB-HID-WRITE") throw;
    throw Fault("TB-SCANNER-LOST", kHidDevice, fmt::format("the scanner is gone: {}", fault.what()), fault.remedy());
  }
}

std::string missing_rows(const std::vector<bool>& seen) {
  std::string list;
  for (std::size_t row = 0; row < seen.size(); ++row) {
    if (!seen[row]) list += fmt::format("{}{}", list.empty() ? "" : ", ", row);
  }
  return list;
}

}  // namespace

HidScanner::HidScanner(std::unique_ptr<ReportLink> link, HidScannerOptions options, Clock& clock)
    : link_(std::move(link)), options_(std::move(options)), clock_(clock) {
  with_scanner([this] { identify(); });
  const bool sane = std::isfinite(described_.volts_per_count) && described_.volts_per_count > 0.0F;
  if (described_.rows != options_.rows || described_.columns != options_.columns || options_.rows < 1 ||
      options_.columns < 1 || options_.columns > kScanColumns || !sane) {
    throw Fault(
        "TB-SCANNER-GEOMETRY", kHidDevice,
        fmt::format("a scanner of {} x {} taxels is configured (columns up to {}), {} reports {} x {} with {:g} V "
                    "per count",
                    options_.rows, options_.columns, kScanColumns, link_->description(), described_.rows,
                    described_.columns, described_.volts_per_count),
        "Correct rows and columns under [scanner] of the bench file, or connect the right scanner.");
  }
  if (!options_.expected_serial.empty() && described_.serial != options_.expected_serial) {
    throw Fault("TB-SCANNER-SERIAL", kHidDevice,
                fmt::format("scanner '{}' is configured, '{}' answers on {}", options_.expected_serial,
                            described_.serial, link_->description()),
                "Connect the right scanner, or correct its serial in the bench file.");
  }
}

std::uint16_t HidScanner::send(ScanCommand command) {
  link_->drain();
  const std::uint16_t tag = next_tag_++;
  link_->write(encode(CommandReport{command, tag}));
  ++exchanges_;
  return tag;
}

void HidScanner::timed_out(const std::string& asked, const std::string& came) {
  clock_.reply_lost(options_.frame_timeout);
  throw Fault("TB-SCANNER-TIMEOUT", kHidDevice,
              fmt::format("{} of {}: {} within {:g} ms", asked, link_->description(), came,
                          in_milliseconds(options_.frame_timeout)),
              "Check the scanner's power and cable, then start again.");
}

// The next report of that id; 0: none came by `end`, in real time. After that, at most as many queued reports are
// examined as a kernel keeps: a device that sends others without end does not extend the wait.
std::size_t HidScanner::receive(std::span<std::uint8_t> into, RealTime end, std::uint8_t id) {
  constexpr int kMostKept = 64;
  for (int late = 0; late < kMostKept;) {
    const Nanoseconds left = left_until(end);
    const std::size_t size = link_->read(into, left);
    if (size == 0 || into[0] == id) return size;
    late += left > Nanoseconds(0) ? 0 : 1;
  }
  return 0;
}

void HidScanner::identify() {
  const std::uint16_t tag = send(ScanCommand::kIdentify);
  const RealTime end = std::chrono::steady_clock::now() + options_.frame_timeout;
  Buffer buffer{};
  // A report that does not decode here may belong to an older exchange: only the answer counts.
  while (const std::size_t size = receive(buffer, end, kIdentityId)) {
    const auto report = decode_identity(std::span(buffer).first(size));
    if (report && report->tag == tag) {
      described_ = *report;
      return;
    }
  }
  timed_out("asking the identity", "no answer");
}

ScanSet HidScanner::read(int scans) {
  ScanSet set;
  set.rows = options_.rows;
  set.columns = options_.columns;
  set.scans = scans;
  set.counts.resize(static_cast<std::size_t>(std::max(scans, 0)) * static_cast<std::size_t>(set.rows) *
                    static_cast<std::size_t>(set.columns));
  set.time = clock_.now();
  with_scanner([&] {
    for (int index = 0; index < scans; ++index) read_scan(set, index);
  });
  return set;
}

void HidScanner::read_scan(ScanSet& set, int index) {
  const std::uint16_t tag = send(ScanCommand::kScan);
  const RealTime end = std::chrono::steady_clock::now() + options_.frame_timeout;
  const auto rows = static_cast<std::size_t>(options_.rows);
  const auto columns = static_cast<std::size_t>(options_.columns);
  std::vector<bool> seen(rows);
  std::size_t complete = 0;
  std::uint16_t sequence = 0;
  Buffer buffer{};
  while (complete < rows) {
    const std::size_t size = receive(buffer, end, kRowId);
    if (size == 0) {
      if (complete == 0) timed_out(fmt::format("asking scan {} (tag {})", index, tag), "no report");
      clock_.reply_lost(options_.frame_timeout);
      corrupt(*link_, fmt::format("scan with tag {}: row {} did not come within {:g} ms", tag, missing_rows(seen),
                                  in_milliseconds(options_.frame_timeout)));
    }
    const auto report = decode_row(std::span(buffer).first(size));
    if (!report) {
      corrupt(*link_, fmt::format("scan with tag {}: a report of {} bytes is damaged (CRC, id or length); rows not yet "
                                  "received: {}",
                                  tag, size, missing_rows(seen)));
    }
    if (report->tag != tag) continue;  // a late answer to an earlier command
    if (report->row >= rows) corrupt(*link_, fmt::format("scan with tag {}: there is no row {}", tag, report->row));
    if (seen[report->row]) corrupt(*link_, fmt::format("scan with tag {}: row {} came twice", tag, report->row));
    if (complete > 0 && report->sequence != static_cast<std::uint16_t>(sequence + 1)) {
      corrupt(*link_, fmt::format("scan with tag {}: sequence {} follows {} at row {}; rows not yet received: {}", tag,
                                  report->sequence, sequence, report->row, missing_rows(seen)));
    }
    if (complete == 0) {
      set.frame_counters.push_back(report->frame);
      if (index == 0) set.device_time_us = report->device_time_us;
    } else if (report->frame != set.frame_counters.back()) {
      corrupt(*link_, fmt::format("scan with tag {}: row {} belongs to frame {}, the rows before to {}", tag,
                                  report->row, report->frame, set.frame_counters.back()));
    }
    sequence = report->sequence;
    seen[report->row] = true;
    ++complete;
    set.status = static_cast<std::uint8_t>(set.status | report->status);
    const std::size_t at = (static_cast<std::size_t>(index) * rows + report->row) * columns;
    std::copy_n(report->samples.begin(), columns, set.counts.begin() + static_cast<std::ptrdiff_t>(at));
  }
}

Identity HidScanner::identity() const {
  return {"tactile scanner", options_.model, described_.serial, described_.firmware, options_.origin};
}

}  // namespace tactbench::devices
