#include "devices/force/digital_ft.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "devices/device.h"
#include "devices/wire/wait.h"

namespace tactbench::devices {
namespace {

constexpr int kMostRegisters = 125;  // of one Modbus read
constexpr int kStatusRegister = 0x001D;
constexpr std::size_t kStartReplyBytes = 5;
constexpr std::size_t kExceptionBytes = 5;
constexpr std::uint8_t kAcknowledged = 5, kBusy = 6;  // exceptions that say: ask again
constexpr std::size_t kJamBytes = 14;
constexpr auto kLongestStop = std::chrono::seconds(2);
constexpr double kNewtonMetre = 1000.0;  // in N*mm

}  // namespace

DigitalFt::DigitalFt(std::unique_ptr<ByteStream> stream, DigitalFtOptions options, Clock& clock)
    : stream_(std::move(stream)), options_(std::move(options)), clock_(clock) {
  stop();
  std::vector<std::uint8_t> bytes;
  constexpr int kAll = kDigitalCalibrationBytes / 2;
  for (int at = 0; at < kAll; at += kMostRegisters) {
    const auto part = read_registers(kDigitalCalibrationRegister + at, std::min(kMostRegisters, kAll - at));
    bytes.insert(bytes.end(), part.begin(), part.end());
  }
  calibration_ = decode_digital_calibration(bytes, options_.low_word_first);
  check_serial(options_.expected_serial, calibration_.serial, "the sensor on " + stream_->description());
  const auto active = read_registers(kDigitalGainRegister, 12);
  for (std::size_t i = 0; i < 12; ++i) {
    const int value = active[2 * i] << 8 | active[2 * i + 1];
    if (value == calibration_.gains_and_offsets[i]) continue;
    throw Fault(
        "TB-FORCE-CALIBRATION", kForceDevice,
        fmt::format("the sensor on {} runs with {} of gauge G{} at {}, its calibration requires {}",
                    stream_->description(), i < 6 ? "gain" : "offset", i % 6, value, calibration_.gains_and_offsets[i]),
        "Load the calibration into the sensor again with the maker's program.");
  }
  for (int row = 0; row < 6; ++row) {
    const auto index = static_cast<std::size_t>(row);
    const double unit = row < 3 ? 1.0 / calibration_.counts_per_force : kNewtonMetre / calibration_.counts_per_torque;
    for (int gauge = 0; gauge < 6; ++gauge) {
      matrix_(row, gauge) = unit * static_cast<double>(calibration_.matrix[index][static_cast<std::size_t>(gauge)]);
    }
    range_[index] = static_cast<double>(calibration_.range[index]) * (row < 3 ? 1.0 : kNewtonMetre);
  }
}

Identity DigitalFt::identity() const {
  return {"force sensor", options_.model, calibration_.serial, "", options_.origin};
}

void DigitalFt::timed_out(const std::string& asked, const std::string& came, Nanoseconds nominal) {
  clock_.reply_lost(nominal);
  throw Fault("TB-FORCE-TIMEOUT", kForceDevice,
              fmt::format("{} of the sensor on {}: {} within {:g} ms", asked, stream_->description(), came,
                          in_milliseconds(nominal)),
              "Check the sensor's power, the RS-485 wires, and the port's rate and parity in the bench file.");
}

// Jams the line until the sensor receives it and stops sending. Bounded.
void DigitalFt::stop() {
  const auto end = std::chrono::steady_clock::now() + kLongestStop;
  const std::vector<std::uint8_t> jam(kJamBytes, 0xFF);
  std::array<std::uint8_t, 512> sink{};
  do {
    stream_->write(jam);
    auto calm = std::chrono::steady_clock::now() + options_.quiet;
    // A full buffer may still hold many bytes: bytes that come within the quiet time restart it, a few times.
    for (int part = 0; part < 64; ++part) {
      if (stream_->read(sink, left_until(calm)) == 0) return;
      calm = std::chrono::steady_clock::now() + options_.quiet;
    }
  } while (std::chrono::steady_clock::now() < end);
  timed_out("asking the stream to stop", "it continues", kLongestStop);
}

// `size` bytes, or the five of an exception.
std::vector<std::uint8_t> DigitalFt::receive(std::size_t size, const std::string& asked) {
  const auto end = std::chrono::steady_clock::now() + options_.reply_timeout;
  std::vector<std::uint8_t> bytes(size);
  std::size_t came = 0;
  while (came < size) {
    const std::size_t got = stream_->read(std::span(bytes).subspan(came), left_until(end));
    if (got == 0) timed_out(asked, fmt::format("{} of {} bytes came", came, size), options_.reply_timeout);
    came += got;
    if (came >= kExceptionBytes && (bytes[1] & 0x80U) != 0) bytes.resize(size = kExceptionBytes);
  }
  return bytes;
}

std::vector<std::uint8_t> DigitalFt::answer(std::span<const std::uint8_t> request, std::size_t size,
                                            const std::string& asked) {
  const auto fail = [&](const std::string& why, const char* remedy) {
    throw Fault("TB-FORCE-PROTOCOL", kForceDevice,
                fmt::format("{} of the sensor on {}: {}", asked, stream_->description(), why), remedy);
  };
  const auto is_request = [&](std::span<const std::uint8_t> bytes) {
    return std::equal(bytes.begin(),
                      bytes.begin() + static_cast<std::ptrdiff_t>(std::min(bytes.size(), request.size())),
                      request.begin());
  };
  for (const Nanoseconds begun = clock_.now();;) {
    stream_->discard();
    stream_->write(request);
    ++exchanges_;
    if (options_.local_echo && !is_request(receive(request.size(), asked))) {
      fail("local_echo is set, and what was sent did not come back",
           "Remove local_echo from [force] where the adapter has no echo; else check the RS-485 wires.");
    }
    std::vector<std::uint8_t> bytes = receive(size, asked);
    if (is_request(bytes)) {
      fail(fmt::format("the first {} bytes of the answer are the request itself: the adapter echoes",
                       std::min(bytes.size(), request.size())),
           "Switch off the adapter's echo, or write local_echo = true in [force] of the bench file.");
    }
    const bool own = rtu_frame_is_whole(bytes) && bytes[0] == options_.unit;
    const bool refused = own && (bytes[1] & 0x80U) != 0;
    if (own && !refused) return bytes;
    const bool busy = refused && (bytes[2] == kAcknowledged || bytes[2] == kBusy);
    if (!busy || clock_.now() - begun >= options_.reply_timeout) {
      fail(refused ? fmt::format("refused with exception {}", bytes[2]) : "a damaged reply came",
           "Check the RS-485 wires and their termination, and the unit number in the bench file.");
    }
    clock_.wait_until(clock_.now() + options_.quiet);
  }
}

std::vector<std::uint8_t> DigitalFt::read_registers(int address, int count) {
  auto bytes = answer(rtu_read_holding(options_.unit, address, count), static_cast<std::size_t>(count) * 2 + 5,
                      fmt::format("reading {} registers from 0x{:04X}", count, address));
  return {bytes.begin() + 3, bytes.end() - 2};
}

SixAxes DigitalFt::scaled(const Vector6& gauges) const {
  SixAxes axes{};
  Vector6::Map(axes.data()) = matrix_ * gauges;
  return axes;
}

ForceReading DigitalFt::read(int records) { return measure(records, bias_); }

ForceReading DigitalFt::bias(int records) {
  ForceReading removed = measure(records, {});
  bias_ = removed.wrench;
  return removed;
}

ForceReading DigitalFt::measure(int records, const Wrench& bias) {
  check_records(records);
  ForceReading reading;
  reading.time = clock_.now();
  Vector6 sum = Vector6::Zero();
  ForceSpread spread;
  try {
    stream_samples(records, bias, sum, spread);
  } catch (const Fault& fault) {
    if (!fault.id().starts_with("TB-SERIAL-")) stop();  // the next reading needs a quiet line
    if (fault.id() != "TB-FORCE-STATUS") throw;
    const auto status = read_registers(kStatusRegister, 1);
    throw Fault(fault.id(), fault.device(),
                fmt::format("{}; its status register is 0x{:02X}{:02X}", fault.what(), status[0], status[1]),
                fault.remedy());
  }
  stop();
  sum /= records;
  Vector6::Map(reading.raw.data()) = sum;
  reading.wrench = wrench_of(scaled(sum)) - bias;
  reading.spread_n = spread.standard_deviation_n();
  reading.records = records;
  reading.lost = lost_;
  return reading;
}

void DigitalFt::stream_samples(int records, const Wrench& bias, Vector6& sum, ForceSpread& spread) {
  (void)answer(digital_start_stream(options_.unit), kStartReplyBytes, "starting the stream");
  const Nanoseconds nominal =
      options_.reply_timeout + Nanoseconds(static_cast<Nanoseconds::rep>(1e9 * records / options_.samples_per_second));
  const auto end = std::chrono::steady_clock::now() + nominal;
  std::vector<std::uint8_t> bytes;
  std::array<std::uint8_t, 1024> part{};
  bool aligned = true;
  int came = 0;
  for (bool late = false; came < records;) {
    // One look after the deadline: a program that was not given the processor may find samples that came in time.
    const Nanoseconds left = left_until(end);
    const std::size_t got = late ? 0 : stream_->read(part, left);
    if (got == 0) timed_out(fmt::format("asking {} samples", records), fmt::format("{} came", came), nominal);
    late = left == Nanoseconds(0);
    bytes.insert(bytes.end(), part.begin(), part.begin() + static_cast<std::ptrdiff_t>(got));
    std::size_t at = 0;
    // Out of step, a sum may be right by chance (1 in 128), so two in a row have to be right.
    while (came < records && bytes.size() - at >= (aligned ? 1 : 2) * kDigitalSampleBytes) {
      const auto rest = std::span(bytes).subspan(at);
      const auto sample = decode_digital_sample(rest.first(kDigitalSampleBytes));
      if (sample && (aligned || decode_digital_sample(rest.subspan(kDigitalSampleBytes, kDigitalSampleBytes)))) {
        aligned = true;
        const Vector6 gauges = gauges_of(*sample);
        const Wrench load = wrench_of(scaled(gauges)) - bias;
        check_overload(load, range_, options_.overload_share);
        spread.add(load);
        sum += gauges;
        ++came;
        at += kDigitalSampleBytes;
      } else {
        if (std::exchange(aligned, false)) ++lost_;
        ++at;
      }
    }
    bytes.erase(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(at));
  }
}

Vector6 DigitalFt::gauges_of(const DigitalSample& sample) const {
  if (sample.error) {
    throw Fault("TB-FORCE-STATUS", kForceDevice,
                fmt::format("the sensor on {} reports an error with a sample", stream_->description()),
                "Switch the sensor off and on; if it persists, the transducer or its cable is broken.");
  }
  Vector6 gauges;
  for (int i = 0; i < 6; ++i) {
    const std::int16_t gauge = sample.gauges[static_cast<std::size_t>(i)];
    using Limits = std::numeric_limits<std::int16_t>;
    if (gauge == Limits::min() || gauge == Limits::max()) {
      throw Fault("TB-FORCE-SATURATED", kForceDevice,
                  fmt::format("gauge G{} of the sensor on {} is at its limit ({})", i, stream_->description(), gauge),
                  "Take the load off; if it persists, a gauge or its wire is broken.");
    }
    gauges[i] = gauge;
  }
  return gauges;
}

}  // namespace tactbench::devices
