#include "devices/force/net_ft.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <utility>

#include "devices/device.h"
#include "devices/wire/http_get.h"
#include "devices/wire/wait.h"

namespace tactbench::devices {
namespace {

// A burst of this many datagrams fits the receive buffer that Linux gives by default (about 270 of this size).
constexpr int kRequestRecords = 100;
constexpr int kSettingAttempts = 3;
constexpr std::size_t kLongestPageFile = 1'000'000;  // bytes; an instrument's has a few thousand

NetFtPage configuration(const NetFtOptions& options, Clock& clock) {
  if (options.page_file.empty()) {
    const HttpPage page{options.host, options.http_port, "/netftapi2.xml", options.page_timeout};
    return parse_netft_page(http_get(page, kForceDevice, clock),
                            fmt::format("http://{}:{}{}", page.host, page.port, page.path));
  }
  std::error_code unknown;
  std::ifstream file;
  std::string text(kLongestPageFile, '\0');
  // Files of /proc and /sys also have size 0; reading some of them blocks forever.
  if (std::filesystem::is_regular_file(options.page_file, unknown) &&
      std::filesystem::file_size(options.page_file, unknown) > 0)
    file.open(options.page_file, std::ios::binary);
  if (file.is_open()) file.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (!file.is_open() || file.bad() || file.gcount() == 0) {
    throw Fault("TB-FORCE-CALIBRATION", kForceDevice,
                fmt::format("reading the configuration {}: it is not a regular file, is empty or cannot be read",
                            options.page_file),
                "Correct the path in the bench file, or leave it out to ask the sensor.");
  }
  text.resize(static_cast<std::size_t>(file.gcount()));
  return parse_netft_page(text, options.page_file);
}

}  // namespace

NetFt::NetFt(NetFtOptions options, Clock& clock)
    : options_(std::move(options)),
      clock_(clock),
      page_(configuration(options_, clock)),
      link_(options_.host, options_.port, kForceDevice) {
  check_serial(options_.expected_serial, page_.calibration_serial, "the sensor at " + link_.peer());
  const auto stated = options_.range ? options_.range : page_.range_n_nmm();
  if (!stated) {
    throw Fault("TB-FORCE-CALIBRATION", kForceDevice,
                fmt::format("the configuration of the sensor at {} names no range (cfgmr)", link_.peer()),
                "Give the calibration's six ranges in the bench file: without them no overload is detected.");
  }
  range_ = *stated;
}

Identity NetFt::identity() const {
  return {"force sensor", options_.model, page_.calibration_serial, page_.firmware, options_.origin};
}

SixAxes NetFt::scaled(const SixAxes& counts) const {
  SixAxes axes{};
  for (std::size_t i = 0; i < 6; ++i) {
    axes[i] = counts[i] * (i < 3 ? page_.newtons_per_count() : page_.newton_millimetres_per_count());
  }
  return axes;
}

ForceReading NetFt::read(int records) { return measure(records, bias_); }

ForceReading NetFt::bias(int records) {
  ForceReading removed = measure(records, {});
  bias_ = removed.wrench;
  return removed;
}

ForceReading NetFt::measure(int records, const Wrench& bias) {
  check_records(records);
  ForceReading reading;
  reading.time = clock_.now();
  Sum sum;
  sum.bias = bias;
  while (sum.records < records) request(std::min(records - sum.records, kRequestRecords), sum);
  for (std::size_t i = 0; i < 6; ++i) reading.raw[i] = sum.counts[i] / sum.records;
  reading.wrench = wrench_of(scaled(reading.raw)) - bias;
  reading.records = sum.records;
  reading.status = sum.status;
  reading.spread_n = sum.spread.standard_deviation_n();
  reading.lost = lost_;
  reading.reordered = reordered_;
  return reading;
}

void NetFt::request(int records, Sum& sum) {
  const Nanoseconds limit =
      options_.reply_timeout + Nanoseconds(static_cast<Nanoseconds::rep>(1e9 * records / page_.records_per_second));
  int missing = records;
  for (int attempt = 0; attempt < kSettingAttempts; ++attempt) {
    const int came = gather(missing, sum, limit);
    missing -= came;
    if (missing == 0) return;
    lost_ += static_cast<std::uint64_t>(missing);
    if (came == 0) break;  // silence, not loss
  }
  throw Fault("TB-FORCE-TIMEOUT", kForceDevice,
              fmt::format("requesting {} record{} from the sensor at {}: {} came within {:g} ms", records,
                          records == 1 ? "" : "s", link_.peer(), records - missing, in_milliseconds(limit)),
              "Check the sensor's power and network cable, and that RDT is enabled in its configuration.");
}

// One request; returns the number of fresh records that came before `limit`.
int NetFt::gather(int records, Sum& sum, Nanoseconds limit) {
  // Records of a request that did not end well may still be on their way; after renew() they go to a closed port.
  if (!std::exchange(settled_, false)) link_.renew();
  link_.drain();
  link_.send(encode(RdtRequest{RdtCommand::kStartRealtime, static_cast<std::uint32_t>(records)}));
  ++exchanges_;
  const auto end = std::chrono::steady_clock::now() + limit;
  const auto before = newest_;
  std::set<std::uint32_t> seen;     // RDT sequence numbers of this stream
  std::set<std::uint32_t> samples;  // F/T sequence numbers
  int old = 0;
  int came = 0;
  std::array<std::uint8_t, 2 * kRdtRecordBytes> buffer{};
  while (came < records) {
    const std::size_t size = link_.receive(buffer, left_until(end));
    if (size == 0) {
      clock_.reply_lost(limit);
      if (came == 0 && old > 0) stalled(*before);
      return came;
    }
    const auto record = decode_rdt_record(std::span(buffer).first(size));
    if (!record) {
      throw Fault(
          "TB-FORCE-PROTOCOL", kForceDevice,
          fmt::format("a datagram of {} bytes came from {}; a record has {}", size, link_.peer(), kRdtRecordBytes),
          "Check that the port is the sensor's RDT port and that its RDT buffer size is 1.");
    }
    // Differences, since the counters wrap. A record that is not newer than the last reading belongs to that reading,
    // or the sensor's counter does not advance; then no record is newer.
    if (before && static_cast<std::int32_t>(record->ft_sequence - *before) <= 0) {
      if (++old == records) stalled(*before);
      continue;
    }
    const bool behind = !seen.empty() && record->rdt_sequence < *seen.rbegin();
    if (!seen.insert(record->rdt_sequence).second) continue;  // the network has duplicated it
    if (behind) ++reordered_;
    if (!samples.insert(record->ft_sequence).second) stalled(record->ft_sequence);
    if (came == 0 || static_cast<std::int32_t>(record->ft_sequence - *newest_) > 0) newest_ = record->ft_sequence;
    take(*record, sum);
    ++came;
  }
  settled_ = true;
  return came;
}

void NetFt::stalled(std::uint32_t sample) {
  newest_.reset();  // a restarted sensor counts from the beginning: the next reading accepts that
  throw Fault("TB-FORCE-STALL", kForceDevice,
              fmt::format("requesting records from the sensor at {}: its sample counter does not go beyond {}",
                          link_.peer(), sample),
              "The sensor repeats itself or has restarted: check its status page, switch it off and on.");
}

void NetFt::take(const RdtRecord& record, Sum& sum) const {
  if (rdt_status_is_error(record.status)) {
    const bool saturated = (record.status & ~(kRdtSummary | kRdtMonitorTripped)) == kRdtSaturated;
    throw Fault(saturated ? "TB-FORCE-SATURATED" : "TB-FORCE-STATUS", kForceDevice,
                fmt::format("the sensor at {} reports status 0x{:08X}: {}", link_.peer(), record.status,
                            rdt_status_text(record.status)),
                saturated ? "Take the load off; if it persists, a gauge or the transducer's cable is broken."
                          : "Check the sensor's status page; switch it off and on.");
  }
  SixAxes counts{};
  for (std::size_t i = 0; i < 6; ++i) {
    counts[i] = record.counts[i];
    sum.counts[i] += record.counts[i];
  }
  const Wrench load = wrench_of(scaled(counts)) - sum.bias;
  check_overload(load, range_, options_.overload_share);
  sum.spread.add(load);
  sum.status |= record.status;
  ++sum.records;
}

}  // namespace tactbench::devices
