#include "devices/force/digital_record.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "devices/device.h"
#include "devices/force/force_checks.h"

namespace tactbench::devices {
namespace {

constexpr std::array<std::size_t, 6> kGaugeOrder{0, 2, 4, 1, 3, 5};
constexpr std::uint8_t kNewtons = 2;
constexpr std::uint8_t kNewtonMetres = 3;
constexpr float kLargestFactor = 1e6F;

std::uint8_t low(unsigned value) { return static_cast<std::uint8_t>(value & 0xFFU); }
std::uint8_t high(unsigned value) { return low(value >> 8U); }

unsigned sum_of(std::span<const std::uint8_t> bytes) {
  unsigned sum = 0;
  for (const std::uint8_t byte : bytes) sum += byte;
  return sum & 0x7FU;
}

// Walks a block of big-endian fields.
class Walk {
 public:
  Walk(std::span<const std::uint8_t> bytes, bool low_word_first) : bytes_(bytes), turned_(low_word_first) {}
  std::uint32_t number(std::size_t size) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < size; ++i) value = value << 8U | bytes_[at_++];
    return size == 4 && turned_ ? std::rotl(value, 16) : value;
  }
  float real() { return std::bit_cast<float>(number(4)); }
  std::string text(std::size_t size) {
    const auto field = bytes_.subspan(at_, size);
    at_ += size;
    return {field.begin(), std::find(field.begin(), field.end(), 0)};
  }
  void skip(std::size_t size) { at_ += size; }

 private:
  std::span<const std::uint8_t> bytes_;
  bool turned_;
  std::size_t at_ = 0;
};

class Fill {
 public:
  explicit Fill(std::span<std::uint8_t> bytes) : bytes_(bytes) {}
  void number(std::uint32_t value, std::size_t size) {
    for (std::size_t i = size; i-- > 0; value >>= 8U) bytes_[at_ + i] = low(value);
    at_ += size;
  }
  void real(float value) { number(std::bit_cast<std::uint32_t>(value), 4); }
  void text(const std::string& value, std::size_t size) {
    std::copy_n(value.begin(), std::min(value.size(), size), bytes_.begin() + static_cast<std::ptrdiff_t>(at_));
    at_ += size;
  }
  void skip(std::size_t size) { at_ += size; }

 private:
  std::span<std::uint8_t> bytes_;
  std::size_t at_ = 0;
};

constexpr std::size_t kSerial = 8, kPart = 32, kFamily = 4, kDate = 20;

}  // namespace

std::vector<std::uint8_t> rtu_read_holding(int unit, int address, int count) {
  const auto first = static_cast<unsigned>(address), number = static_cast<unsigned>(count);
  const std::array<std::uint8_t, 6> body{
      low(static_cast<unsigned>(unit)), 3, high(first), low(first), high(number), low(number)};
  return rtu_frame(body);
}

std::vector<std::uint8_t> digital_start_stream(int unit) {
  const std::array<std::uint8_t, 3> body{low(static_cast<unsigned>(unit)), 0x46, 0x55};
  return rtu_frame(body);
}

bool rtu_frame_is_whole(std::span<const std::uint8_t> frame) {
  if (frame.size() < 4) return false;
  const unsigned crc = crc16_modbus(frame.first(frame.size() - 2));
  return frame[frame.size() - 2] == low(crc) && frame[frame.size() - 1] == high(crc);
}

std::array<std::uint8_t, kDigitalSampleBytes> encode(const DigitalSample& sample) {
  std::array<std::uint8_t, kDigitalSampleBytes> bytes{};
  for (std::size_t i = 0; i < 6; ++i) {
    const auto gauge = static_cast<std::uint16_t>(sample.gauges[kGaugeOrder[i]]);
    bytes[2 * i] = high(gauge);
    bytes[2 * i + 1] = low(gauge);
  }
  bytes[12] = low((sample.error ? 0x80U : 0U) | sum_of(std::span(bytes).first(12)));
  return bytes;
}

std::optional<DigitalSample> decode_digital_sample(std::span<const std::uint8_t> bytes) {
  if (bytes.size() != kDigitalSampleBytes || (bytes[12] & 0x7FU) != sum_of(bytes.first(12))) return std::nullopt;
  DigitalSample sample;
  for (std::size_t i = 0; i < 6; ++i) {
    sample.gauges[kGaugeOrder[i]] = static_cast<std::int16_t>(bytes[2 * i] << 8 | bytes[2 * i + 1]);
  }
  sample.error = (bytes[12] & 0x80U) != 0;
  return sample;
}

std::array<std::uint8_t, kDigitalCalibrationBytes> encode(const DigitalCalibration& calibration) {
  std::array<std::uint8_t, kDigitalCalibrationBytes> bytes{};
  Fill fill(bytes);
  fill.text(calibration.serial, kSerial);
  fill.text(calibration.part_number, kPart);
  fill.skip(kFamily);
  fill.text(calibration.date, kDate);
  for (const auto& row : calibration.matrix) {
    for (const float value : row) fill.real(value);
  }
  fill.number(calibration.force_unit, 1);
  fill.number(calibration.torque_unit, 1);
  for (const float value : calibration.range) fill.real(value);
  fill.number(static_cast<std::uint32_t>(calibration.counts_per_force), 4);
  fill.number(static_cast<std::uint32_t>(calibration.counts_per_torque), 4);
  for (const std::uint16_t value : calibration.gains_and_offsets) fill.number(value, 2);
  return bytes;
}

DigitalCalibration decode_digital_calibration(std::span<const std::uint8_t> bytes, bool low_word_first) {
  const auto fail = [](const std::string& what) {
    throw Fault("TB-FORCE-CALIBRATION", kForceDevice,
                fmt::format("reading the calibration in the Digital F/T's registers: {}", what),
                "Read again; if it persists, the sensor holds no calibration that this program knows.");
  };
  if (bytes.size() != kDigitalCalibrationBytes) {
    fail(fmt::format("{} bytes, not {}", bytes.size(), kDigitalCalibrationBytes));
  }
  Walk walk(bytes, low_word_first);
  DigitalCalibration calibration;
  calibration.serial = walk.text(kSerial);
  calibration.part_number = walk.text(kPart);
  walk.skip(kFamily);
  calibration.date = walk.text(kDate);
  bool finite = true;
  for (auto& row : calibration.matrix) {
    for (float& value : row) finite = std::isfinite(value = walk.real()) && finite;
  }
  calibration.force_unit = low(walk.number(1));
  calibration.torque_unit = low(walk.number(1));
  bool ranged = true;
  for (float& value : calibration.range) {
    value = walk.real();
    ranged = value > 0.0F && value < kLargestFactor && ranged;
  }
  calibration.counts_per_force = static_cast<std::int32_t>(walk.number(4));
  calibration.counts_per_torque = static_cast<std::int32_t>(walk.number(4));
  for (std::uint16_t& value : calibration.gains_and_offsets) value = static_cast<std::uint16_t>(walk.number(2));
  if (!finite) fail("its matrix holds a value that is not a number");
  if (!ranged) fail("its ranges are not above 0");
  if (calibration.counts_per_force < 1 || calibration.counts_per_torque < 1) {
    fail(fmt::format("{} counts per force unit, {} per torque unit", calibration.counts_per_force,
                     calibration.counts_per_torque));
  }
  if (calibration.force_unit != kNewtons || calibration.torque_unit != kNewtonMetres) {
    fail(fmt::format("units {} and {}; known: 2 (N) and 3 (N*m)", calibration.force_unit, calibration.torque_unit));
  }
  return calibration;
}

}  // namespace tactbench::devices
