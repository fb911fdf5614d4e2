// Checks a codec on one message: encoding and decoding are inverse to each other, and a damaged byte is detected or
// gives another value.
#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace tactbench::devices {

// How many of a byte's bits the message's own sum sees: none where it has no sum.
enum class Sum { kNone, kSevenBits, kAll };

// `decode` returns an optional.
template <class Bytes, class Value, class Encode, class Decode>
void check_codec(const Bytes& bytes, const Value& value, Encode encode, Decode decode, Sum sum = Sum::kNone) {
  const auto equals = [](const auto& left, const auto& right) {
    return std::equal(left.begin(), left.end(), right.begin(), right.end());
  };
  CHECK(equals(encode(value), bytes));
  const auto decoded = decode(bytes);
  REQUIRE(decoded.has_value());
  CHECK(*decoded == value);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    for (unsigned bit = 0; bit < (sum == Sum::kSevenBits ? 7U : 8U); ++bit) {
      INFO("bit " << bit << " of byte " << i);
      Bytes damaged = bytes;
      damaged[i] = static_cast<std::uint8_t>(damaged[i] ^ 1U << bit);
      const auto other = decode(damaged);
      if (sum != Sum::kNone) CHECK_FALSE(other.has_value());
      if (sum == Sum::kNone && other) {
        CHECK_FALSE(*other == value);
        CHECK(equals(encode(*other), damaged));
      }
    }
  }
}

}  // namespace tactbench::devices
