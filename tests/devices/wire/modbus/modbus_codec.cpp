// Check sums and numbers of Modbus by answers worked out by hand.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "devices/wire/modbus/modbus_link.h"
#include "devices/wire/modbus/modbus_value.h"
#include "tests/devices/check_codec.h"

using namespace tactbench::devices;

namespace {

using Words = std::vector<std::uint16_t>;

std::uint16_t crc_of(const std::string& text) {
  const std::vector<std::uint8_t> bytes(text.begin(), text.end());
  return crc16_modbus(bytes);
}

}  // namespace

TEST_CASE("modbus checksum: has its published values, low byte first") {
  CHECK(crc_of("") == 0xFFFF);
  CHECK(crc_of("123456789") == 0x4B37);  // the catalogue of check sums' CRC-16/MODBUS
  CHECK(rtu_frame(std::vector<std::uint8_t>{1, 3, 0, 0, 0, 1}) ==
        std::vector<std::uint8_t>{1, 3, 0, 0, 0, 1, 0x84, 0x0A});
  CHECK(rtu_frame(std::vector<std::uint8_t>{2, 7}) ==
        std::vector<std::uint8_t>{2, 7, 0x41, 0x12});  // the standard's own
  const std::vector<std::uint8_t> body{0x11, 3, 0, 0x6B, 0, 3};
  check_codec(
      rtu_frame(body), body, [](const std::vector<std::uint8_t>& one) { return rtu_frame(one); },
      [](const std::vector<std::uint8_t>& frame) {
        const std::vector<std::uint8_t> front(frame.begin(), frame.end() - 2);
        return rtu_frame(front) == frame ? std::optional(front) : std::nullopt;
      },
      Sum::kAll);
}

TEST_CASE("modbus value: each type decodes its words in both orders, with its counts") {
  const Words words{0x8001, 0xFFFE};
  const struct {
    RegisterType type;
    bool low_first;
    std::int32_t counts;
    double value;
  } cases[] = {
      {RegisterType::kU16, false, 0x8001, 32769.0},
      {RegisterType::kU16, true, 0x8001, 32769.0},
      {RegisterType::kI16, false, -32767, -32767.0},
      {RegisterType::kI16, true, -32767, -32767.0},
      {RegisterType::kU32, false, -2147352578, 2147614718.0},  // 0x8001FFFE
      {RegisterType::kU32, true, -98303, 4294868993.0},        // 0xFFFE8001
      {RegisterType::kI32, false, -2147352578, -2147352578.0},
      {RegisterType::kI32, true, -98303, -98303.0},
  };
  for (const auto& [type, low_first, counts, value] : cases) {
    INFO("type " << static_cast<int>(type) << ", low word first " << low_first);
    const RegisterValue decoded = decode_register({type, low_first}, words);
    CHECK(decoded.counts == counts);
    CHECK(decoded.value == value);
  }
  // -6.25 is 0xC0C80000, 2^-126 is 0x00800000, and 1 + 2^-23 is 0x3F800001.
  CHECK(decode_register({RegisterType::kF32, false}, Words{0xC0C8, 0}).value == -6.25);
  CHECK(decode_register({RegisterType::kF32, true}, Words{1, 0x3F80}).value == 1.0 + std::ldexp(1.0, -23));
  CHECK(decode_register({RegisterType::kF32, false}, Words{0x0080, 0}).value == std::ldexp(1.0, -126));
  CHECK(std::isnan(decode_register({RegisterType::kF32, false}, Words{0x7FC0, 0}).value));
}

TEST_CASE("modbus value: each type encodes its words in both orders") {
  CHECK(encode_register({RegisterType::kU16, true}, 32769.0) == Words{0x8001});
  CHECK(encode_register({RegisterType::kI16, true}, -2.0) == Words{0xFFFE});
  CHECK(encode_register({RegisterType::kU32, false}, 4294868993.0) == Words{0xFFFE, 0x8001});
  CHECK(encode_register({RegisterType::kU32, true}, 4294868993.0) == Words{0x8001, 0xFFFE});
  CHECK(encode_register({RegisterType::kI32, false}, -98303.0) == Words{0xFFFE, 0x8001});
  CHECK(encode_register({RegisterType::kI32, true}, -98303.0) == Words{0x8001, 0xFFFE});
  CHECK(encode_register({RegisterType::kF32, false}, -6.25) == Words{0xC0C8, 0});
  CHECK(encode_register({RegisterType::kF32, true}, 1.0 + std::ldexp(1.0, -23)) == Words{1, 0x3F80});
}

TEST_CASE("modbus value: encodes the nearest value of the type, halves away from zero, and NaN as 0") {
  CHECK(encode_register({RegisterType::kU16}, 2.5) == Words{3});
  CHECK(encode_register({RegisterType::kI16}, -2.5) == Words{static_cast<std::uint16_t>(-3)});
  CHECK(encode_register({RegisterType::kI16}, 2.4) == Words{2});
  const double nan = std::nan("");
  CHECK(encode_register({RegisterType::kU16}, nan) == Words{0});
  CHECK(encode_register({RegisterType::kI16}, nan) == Words{0});
  CHECK(encode_register({RegisterType::kU32}, nan) == Words{0, 0});
  CHECK(encode_register({RegisterType::kI32}, nan) == Words{0, 0});
  CHECK(encode_register({RegisterType::kU16}, -1.0) == Words{0});
  CHECK(encode_register({RegisterType::kU16}, 65536.0) == Words{0xFFFF});
  CHECK(encode_register({RegisterType::kI16}, -40000.0) == Words{0x8000});
  CHECK(encode_register({RegisterType::kI16}, 40000.0) == Words{0x7FFF});
  CHECK(encode_register({RegisterType::kU32}, -1.0) == Words{0, 0});
  CHECK(encode_register({RegisterType::kU32}, 1e11) == Words{0xFFFF, 0xFFFF});
  CHECK(encode_register({RegisterType::kI32}, -1e11) == Words{0x8000, 0});
  CHECK(encode_register({RegisterType::kI32}, 1e11) == Words{0x7FFF, 0xFFFF});
}

TEST_CASE("modbus value: values survive encoding and decoding, clipped to the range of the type") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> value(-40000.0, 70000.0);
  for (int i = 0; i < 1000; ++i) {
    for (const RegisterType type : {RegisterType::kU16, RegisterType::kI16, RegisterType::kU32, RegisterType::kI32}) {
      const RegisterFormat format{type, i % 2 == 1};
      const double wanted = std::round(value(random));
      const double low = type == RegisterType::kI16 ? -32768.0 : type == RegisterType::kI32 ? -2147483648.0 : 0.0;
      const double high = type == RegisterType::kU16 ? 65535.0 : type == RegisterType::kI16 ? 32767.0 : 2147483647.0;
      const auto words = encode_register(format, wanted);
      REQUIRE(words.size() == format.words());
      REQUIRE(decode_register(format, words).value == std::clamp(wanted, low, high));
    }
  }
}
