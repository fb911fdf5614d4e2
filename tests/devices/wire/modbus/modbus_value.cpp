#include "devices/wire/modbus/modbus_value.h"

#include <catch2/catch.hpp>
#include <random>

#include "devices/pressure/pressure_reference.h"

using namespace tactbench::devices;

TEST_CASE("modbus value: floats in both word orders, signed and unsigned integers") {
  const std::vector<std::uint16_t> pi{0x4049, 0x0FDB};
  CHECK(decode_register({RegisterType::kF32}, pi).value == Approx(3.14159274));
  CHECK(decode_register({RegisterType::kF32}, pi).counts == 0x40490FDB);
  const std::vector<std::uint16_t> swapped{0x0FDB, 0x4049};
  CHECK(decode_register({RegisterType::kF32, true}, swapped).value == Approx(3.14159274));
  const std::vector<std::uint16_t> minus{0xFFFF, 0xFFFE};
  CHECK(decode_register({RegisterType::kI16}, minus).value == -1.0);
  CHECK(decode_register({RegisterType::kU16}, minus).value == 65535.0);
  CHECK(decode_register({RegisterType::kI32}, minus).value == -2.0);
  CHECK(decode_register({RegisterType::kU32}, minus).value == 4294967294.0);
}

TEST_CASE("modbus value: encoded values decode to the same, out of range is clipped") {
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

TEST_CASE("pressure correction: the certificate's points, between them, beyond them") {
  PressureCorrection correction;
  CHECK(correction.corrected(Psi(30.0)) == Psi(30.0));
  correction.reading_psi = {0.0, 50.0, 100.0};
  correction.correction_psi = {0.1, -0.2, 0.4};
  correction.expanded_uncertainty_psi = {0.05, 0.05, 0.10};
  CHECK(correction.corrected(Psi(0.0)).value() == Approx(0.1));
  CHECK(correction.corrected(Psi(50.0)).value() == Approx(49.8));
  CHECK(correction.corrected(Psi(25.0)).value() == Approx(24.95));
  CHECK(correction.corrected(Psi(75.0)).value() == Approx(75.1));
  CHECK(correction.corrected(Psi(120.0)).value() == Approx(120.4));
  CHECK(correction.corrected(Psi(-1.0)).value() == Approx(-0.9));
  CHECK(correction.expanded_uncertainty(Psi(75.0)) == Approx(0.075));
}
