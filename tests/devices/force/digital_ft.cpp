#include <catch2/catch.hpp>
#include <limits>

#include "devices/force/digital_record.h"
#include "tests/devices/check_codec.h"
#include "tests/devices/force/invented_digital.h"
#include "tests/devices/test_chamber.h"

using namespace tactbench::devices;
using Bytes = std::vector<std::uint8_t>;

TEST_CASE("Digital F/T: the start frame and Modbus frames are the published bytes") {
  CHECK(digital_start_stream(10) == Bytes{0x0A, 0x46, 0x55, 0xA3, 0x9D});
  const std::string digits = "123456789";
  CHECK(crc16_modbus(Bytes(digits.begin(), digits.end())) == 0x4B37);
  // The example of the Modbus specification's annex on RTU reads: unit 17, registers 0x6B to 0x6D.
  CHECK(rtu_read_holding(0x11, 0x006B, 3) == Bytes{0x11, 0x03, 0x00, 0x6B, 0x00, 0x03, 0x76, 0x87});
  CHECK(rtu_frame_is_whole(Bytes{0x11, 0x03, 0x00, 0x6B, 0x00, 0x03, 0x76, 0x87}));
  CHECK_FALSE(rtu_frame_is_whole(Bytes{0x11, 0x03, 0x00, 0x6B, 0x00, 0x02, 0x76, 0x87}));
  CHECK_FALSE(rtu_frame_is_whole(Bytes{0xFF, 0xFF}));
}

TEST_CASE("Digital F/T: a sample's bytes, gauge order and sum") {
  const auto decoded = [](const Bytes& bytes) { return decode_digital_sample(bytes); };
  Bytes bytes{0x00, 0x01, 0xFF, 0xFE, 0x7F, 0xFF, 0x01, 0x00, 0x80, 0x00, 0x00, 0x05, 0x02};
  // 1 + 0xFF + 0xFE + 0x7F + 0xFF + 1 + 0x80 + 5 = 0x502
  DigitalSample sample{{1, 256, -2, -32768, 32767, 5}, false};
  const auto encoded = [](const DigitalSample& one) { return encode(one); };
  check_codec(bytes, sample, encoded, decoded, Sum::kSevenBits);
  bytes[12] |= 0x80U;
  sample.error = true;
  check_codec(bytes, sample, encoded, decoded, Sum::kSevenBits);
  CHECK_FALSE(decode_digital_sample(std::span(bytes).first(12)));
}

TEST_CASE("Digital F/T: the calibration registers, both orders of words, and refused ones") {
  const auto calibration = invented_digital();
  const auto bytes = encode(calibration);
  CHECK(bytes[0] == 'F');
  CHECK(bytes[208] == 2);
  CHECK(bytes[209] == 3);
  CHECK(std::vector<int>(bytes.begin() + 234, bytes.begin() + 242) ==
        std::vector<int>{0, 0, 3, 0xE8, 0, 0x0F, 0x42, 0x40});
  CHECK(decode_digital_calibration(bytes) == calibration);
  auto turned = bytes;
  const auto turn = [&](std::size_t begin, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      std::swap(turned[begin + 4 * i], turned[begin + 4 * i + 2]);
      std::swap(turned[begin + 4 * i + 1], turned[begin + 4 * i + 3]);
    }
  };
  turn(64, 36);
  turn(210, 8);
  CHECK(decode_digital_calibration(turned, true) == calibration);

  const auto refused = [&](auto change) {
    DigitalCalibration wrong = calibration;
    change(wrong);
    return fault_id_of([&] { (void)decode_digital_calibration(encode(wrong)); }) == "TB-FORCE-CALIBRATION";
  };
  CHECK(refused([](DigitalCalibration& c) { c.matrix[2][3] = std::numeric_limits<float>::quiet_NaN(); }));
  CHECK(refused([](DigitalCalibration& c) { c.range[5] = 0.0F; }));
  CHECK(refused([](DigitalCalibration& c) { c.counts_per_torque = -1; }));
  CHECK(refused([](DigitalCalibration& c) { c.force_unit = 1; }));
  CHECK(fault_id_of([&] { (void)decode_digital_calibration(std::span(bytes).first(337)); }) == "TB-FORCE-CALIBRATION");
}
