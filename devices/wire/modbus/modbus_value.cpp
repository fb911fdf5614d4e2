#include "devices/wire/modbus/modbus_value.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace tactbench::devices {
namespace {

template <class Integer>
Integer nearest(double value) {
  if (std::isnan(value)) return 0;
  const double clipped = std::clamp(value, static_cast<double>(std::numeric_limits<Integer>::min()),
                                    static_cast<double>(std::numeric_limits<Integer>::max()));
  return static_cast<Integer>(std::llround(clipped));
}

}  // namespace

RegisterValue decode_register(const RegisterFormat& format, std::span<const std::uint16_t> words) {
  if (format.type == RegisterType::kU16) return {words[0], static_cast<double>(words[0])};
  if (format.type == RegisterType::kI16) {
    const auto value = static_cast<std::int16_t>(words[0]);
    return {value, static_cast<double>(value)};
  }
  const std::uint32_t high = words[format.low_word_first ? 1 : 0];
  const std::uint32_t bits = high << 16U | words[format.low_word_first ? 0 : 1];
  const auto counts = static_cast<std::int32_t>(bits);
  if (format.type == RegisterType::kU32) return {counts, static_cast<double>(bits)};
  if (format.type == RegisterType::kI32) return {counts, static_cast<double>(counts)};
  return {counts, static_cast<double>(std::bit_cast<float>(bits))};
}

std::vector<std::uint16_t> encode_register(const RegisterFormat& format, double value) {
  if (format.type == RegisterType::kU16) return {nearest<std::uint16_t>(value)};
  if (format.type == RegisterType::kI16) return {static_cast<std::uint16_t>(nearest<std::int16_t>(value))};
  const std::uint32_t bits = format.type == RegisterType::kU32 ? nearest<std::uint32_t>(value)
                             : format.type == RegisterType::kI32
                                 ? static_cast<std::uint32_t>(nearest<std::int32_t>(value))
                                 : std::bit_cast<std::uint32_t>(static_cast<float>(value));
  const auto high = static_cast<std::uint16_t>(bits >> 16U);
  const auto low = static_cast<std::uint16_t>(bits & 0xFFFFU);
  return format.low_word_first ? std::vector{low, high} : std::vector{high, low};
}

}  // namespace tactbench::devices
