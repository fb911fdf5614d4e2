// UTF-8 by RFC 3629, all of it.
#include "db/remarks.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

using tactbench::db::CodePoint;
using tactbench::db::decode_utf8;
using tactbench::db::is_blank;

namespace {

char of(std::uint32_t byte) { return static_cast<char>(static_cast<unsigned char>(byte)); }

// As section 3 of the RFC draws the bits.
std::string encoded(std::uint32_t value) {
  const auto tail = [&](int shift) { return of(0x80 | ((value >> shift) & 0x3f)); };
  if (value < 0x80) return {of(value)};
  if (value < 0x800) return {of(0xc0 | (value >> 6)), tail(0)};
  if (value < 0x10000) return {of(0xe0 | (value >> 12)), tail(6), tail(0)};
  return {of(0xf0 | (value >> 18)), tail(12), tail(6), tail(0)};
}

}  // namespace

TEST_CASE("UTF-8: every character is decoded, whatever follows, and surrogates are refused") {
  std::size_t wrong = 0;
  for (std::uint32_t value = 0; value <= 0x10ffff; ++value) {
    const std::string bytes = encoded(value);
    const CodePoint found = decode_utf8(bytes + "\x80z");
    const bool surrogate = value >= 0xd800 && value <= 0xdfff;
    const bool right = surrogate ? !found.valid && found.bytes == 1
                                 : found.valid && found.value == value && found.bytes == bytes.size();
    if (!right && wrong++ < 5) FAIL_CHECK("U+" << std::hex << value);
  }
  CHECK(wrong == 0);
}

TEST_CASE("UTF-8: two bytes are a character only if RFC 3629 allows it") {
  for (std::uint32_t first = 0x80; first < 0x100; ++first) {
    for (std::uint32_t second = 0; second < 0x100; ++second) {
      const bool valid = first >= 0xc2 && first <= 0xdf && second >= 0x80 && second <= 0xbf;
      if (decode_utf8(std::string{of(first), of(second)}).valid != valid) FAIL_CHECK(first << " " << second);
    }
  }
}

TEST_CASE("UTF-8: overlong forms, surrogates, values above U+10FFFF and cut sequences are one invalid byte") {
  for (const std::string& bytes : std::vector<std::string>{
           "\xe0\x9f\xbf",     "\xe0\x80\x80",     "\xed\xa0\x80",     "\xed\xbf\xbf", "\xf0\x8f\xbf\xbf",
           "\xf0\x80\x80\x80", "\xf4\x90\x80\x80", "\xf5\x80\x80\x80", "\xc1\xbf",     "\xc2",
           "\xe1\x80",         "\xf1\x80\x80",     "\xe1z\x80",        "\xe1\x80z",    "\xf1z\x80\x80",
           "\xf1\x80z\x80",    "\xf1\x80\x80z",    "\xe1\xc0\x80",     "\xff",         "\x80"}) {
    const CodePoint found = decode_utf8(bytes);
    CAPTURE(bytes);
    CHECK_FALSE(found.valid);
    CHECK((found.bytes == 1 && found.value == 0));
  }
}

TEST_CASE("UTF-8: Unicode white space and invisible marks are blank, and no other character") {
  using Span = std::pair<std::uint32_t, std::uint32_t>;
  // PropList.txt: White_Space.
  const std::vector<Span> white = {{0x0009, 0x000D}, {0x0020, 0x0020}, {0x0085, 0x0085}, {0x00A0, 0x00A0},
                                   {0x1680, 0x1680}, {0x2000, 0x200A}, {0x2028, 0x2029}, {0x202F, 0x202F},
                                   {0x205F, 0x205F}, {0x3000, 0x3000}};
  // Soft hyphen, Arabic letter mark, fillers of Hangul, Mongolian vowel separator; joiners and marks of direction,
  // twice; word joiner to the last of its block; selectors of variants; byte order mark.
  const std::vector<Span> unseen = {{0x00AD, 0x00AD}, {0x061C, 0x061C}, {0x115F, 0x1160}, {0x3164, 0x3164},
                                    {0x180E, 0x180E}, {0x200B, 0x200F}, {0x202A, 0x202E}, {0x2060, 0x206F},
                                    {0xFE00, 0xFE0F}, {0xFEFF, 0xFEFF}};
  const auto in = [](const std::vector<Span>& spans, std::uint32_t value) {
    return std::ranges::any_of(spans, [&](const Span& span) { return value >= span.first && value <= span.second; });
  };
  for (std::uint32_t value = 0; value <= 0x10ffff; ++value)
    if (is_blank(encoded(value)) != (in(white, value) || in(unseen, value))) FAIL_CHECK("U+" << std::hex << value);
  CHECK(is_blank(""));
  CHECK(is_blank(" \xe2\x80\x8b\t"));
  CHECK_FALSE(is_blank(" a"));
  CHECK_FALSE(is_blank("a "));
  CHECK_FALSE(is_blank(" \x80"));
}
