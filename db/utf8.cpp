#include "db/utf8.h"

#include <algorithm>
#include <array>
#include <utility>

namespace tactbench::db {

CodePoint decode_utf8(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<std::uint32_t>(static_cast<unsigned char>(text[i])); };
  const std::uint32_t lead = byte(0);
  if (lead < 0x80) return {lead, 1, true};
  const std::size_t length = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead < 0xC2 || lead > 0xF4 || text.size() < length) return {};
  std::uint32_t value = lead & (0x7Fu >> length);
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0u) != 0x80u) return {};
    value = (value << 6) | (byte(i) & 0x3Fu);
  }
  const bool overlong = (length == 3 && value < 0x800) || (length == 4 && value < 0x10000);
  if (overlong || (value >= 0xD800 && value <= 0xDFFF) || value > 0x10FFFF) return {};
  return {value, length, true};
}

bool is_blank(std::string_view text) {
  using Span = std::pair<std::uint32_t, std::uint32_t>;
  // Unicode 15: White_Space, and those of Default_Ignorable_Code_Point that occur in people's texts.
  constexpr std::array kBlank{Span(0x09, 0x0D),     Span(0x20, 0x20),     Span(0x85, 0x85),     Span(0xA0, 0xA0),
                              Span(0xAD, 0xAD),     Span(0x061C, 0x061C), Span(0x115F, 0x1160), Span(0x1680, 0x1680),
                              Span(0x180E, 0x180E), Span(0x2000, 0x200F), Span(0x2028, 0x202F), Span(0x205F, 0x206F),
                              Span(0x3000, 0x3000), Span(0x3164, 0x3164), Span(0xFE00, 0xFE0F), Span(0xFEFF, 0xFEFF)};
  while (!text.empty()) {
    const CodePoint c = decode_utf8(text);
    const auto holds = [&](const Span& span) { return c.value >= span.first && c.value <= span.second; };
    if (!c.valid || std::ranges::none_of(kBlank, holds)) return false;
    text.remove_prefix(c.bytes);
  }
  return true;
}

}  // namespace tactbench::db
