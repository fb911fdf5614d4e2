#include "analysis/text_width.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

#include "db/remarks.h"

namespace tactbench::analysis {

namespace {

// Unicode 15: combining marks that texts of people hold, and the blocks that terminals draw two columns wide.
std::size_t columns_of(std::uint32_t c) {
  using Span = std::pair<std::uint32_t, std::uint32_t>;
  constexpr std::array kNone{Span(0x0300, 0x036F), Span(0x0483, 0x0489), Span(0x0591, 0x05BD), Span(0x064B, 0x065F),
                             Span(0x1AB0, 0x1AFF), Span(0x1DC0, 0x1DFF), Span(0x200B, 0x200F), Span(0x20D0, 0x20FF),
                             Span(0xFE00, 0xFE0F), Span(0xFE20, 0xFE2F), Span(0xFEFF, 0xFEFF)};
  constexpr std::array kTwo{Span(0x1100, 0x115F),   Span(0x2E80, 0x303E),   Span(0x3041, 0xA4CF),
                            Span(0xA960, 0xA97F),   Span(0xAC00, 0xD7A3),   Span(0xF900, 0xFAFF),
                            Span(0xFE10, 0xFE19),   Span(0xFE30, 0xFE6F),   Span(0xFF00, 0xFF60),
                            Span(0xFFE0, 0xFFE6),   Span(0x1F300, 0x1F64F), Span(0x1F680, 0x1F6FF),
                            Span(0x1F900, 0x1F9FF), Span(0x20000, 0x3FFFD)};
  const auto holds = [c](const Span& span) { return c >= span.first && c <= span.second; };
  if (std::ranges::any_of(kNone, holds)) return 0;
  return std::ranges::any_of(kTwo, holds) ? 2 : 1;
}

}  // namespace

std::size_t display_width(std::string_view text) {
  std::size_t width = 0;
  while (!text.empty()) {
    const db::CodePoint c = db::decode_utf8(text);
    width += columns_of(c.value);
    text.remove_prefix(c.bytes);
  }
  return width;
}

std::string cut_to(std::string_view text, std::size_t columns) {
  if (display_width(text) <= columns) return std::string(text);
  std::size_t bytes = 0, taken = 1;  // the ...
  while (bytes < text.size()) {
    const db::CodePoint c = db::decode_utf8(text.substr(bytes));
    taken += columns_of(c.value);
    if (taken > columns) break;
    bytes += c.bytes;
  }
  return std::string(text.substr(0, bytes)) + "\u2026";
}

}  // namespace tactbench::analysis
