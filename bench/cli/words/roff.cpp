#include "bench/cli/words/roff.h"

#include <fmt/format.h>

#include <cstdint>
#include <string_view>

#include "db/utf8.h"

namespace tactbench::bench {

std::string roff(const std::string& text) {
  std::string out;
  bool line_start = true;
  for (std::string_view rest = text; !rest.empty();) {
    const db::CodePoint point = db::decode_utf8(rest);
    const char c = rest.front();
    rest.remove_prefix(point.bytes);
    if (point.bytes > 1) {
      out += fmt::format("\\[u{:04X}]", static_cast<std::uint32_t>(point.value));
      line_start = false;
      continue;
    }
    if (line_start && (c == '.' || c == '\'')) out += "\\&";
    if (c == '\\') {
      out += "\\e";
    } else if (c == '-') {
      out += "\\-";
    } else if (c == '\'') {
      out += "\\(aq";
    } else if (c == '`') {
      out += "\\(ga";
    } else if (c == '^') {
      out += "\\(ha";
    } else if (c == '~') {
      out += "\\(ti";
    } else {
      out += c;
    }
    line_start = c == '\n';
  }
  return out;
}

std::string roff_paragraph(const std::string& text) {
  std::string lines;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool blank = text[i] == ' ' || text[i] == '\n';
    if (blank && !lines.empty() && lines.back() == '\n') continue;
    const bool sentence = lines.ends_with('.') && !lines.ends_with("..");
    if (blank && sentence) {
      lines += '\n';
    } else {
      lines += text[i] == '\n' ? ' ' : text[i];
    }
  }
  while (!lines.empty() && (lines.back() == '\n' || lines.back() == ' ')) lines.pop_back();
  return roff(lines);
}

}  // namespace tactbench::bench
