// A number in one or two Modbus registers, and its linear scale: codec of module channels, gauges and environment
// sensors. No I/O.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace tactbench::devices {

enum class RegisterType { kU16, kI16, kU32, kI32, kF32 };

// "u16", "i16", "u32", "i32", "f32", in the order of RegisterType.
inline constexpr std::array<const char*, 5> kRegisterTypes{"u16", "i16", "u32", "i32", "f32"};

struct RegisterFormat {
  RegisterType type = RegisterType::kU16;
  bool low_word_first = false;  // of two words; within a word Modbus sends the high byte first
  [[nodiscard]] std::size_t words() const { return type == RegisterType::kU16 || type == RegisterType::kI16 ? 1 : 2; }
};

struct RegisterValue {
  std::int32_t counts = 0;  // as read; for f32 and u32 the bit pattern
  double value = 0.0;
};

// `words` holds format.words() registers.
RegisterValue decode_register(const RegisterFormat& format, std::span<const std::uint16_t> words);
// The nearest value that the type can hold.
std::vector<std::uint16_t> encode_register(const RegisterFormat& format, double value);

// physical = low + (raw - raw_low) / (raw_high - raw_low) * (high - low)
struct LinearScale {
  double raw_low = 0.0, raw_high = 1.0;
  double low = 0.0, high = 1.0;
  [[nodiscard]] double physical(double raw) const {
    return low + (raw - raw_low) / (raw_high - raw_low) * (high - low);
  }
  [[nodiscard]] double raw(double physical) const {
    return raw_low + (physical - low) / (high - low) * (raw_high - raw_low);
  }
};

}  // namespace tactbench::devices
