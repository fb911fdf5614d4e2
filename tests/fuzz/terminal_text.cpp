// Text on its way to a terminal: no control character is left, nothing that was fit to be read is changed, and a
// line is no wider than it should be.
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "bench/common/terminal.h"
#include "db/remarks.h"

using namespace tactbench;

namespace {

bool harmless(std::string_view text, bool may_have_lines) {
  while (!text.empty()) {
    const db::CodePoint c = db::decode_utf8(text);
    if (!c.valid) return false;
    const bool line = c.value == '\n' || c.value == '\t';
    if ((c.value < 0x20 && !(line && may_have_lines)) || (c.value >= 0x7F && c.value <= 0x9F)) return false;
    if ((c.value >= 0x202A && c.value <= 0x202E) || (c.value >= 0x2066 && c.value <= 0x2069)) return false;
    text.remove_prefix(c.bytes);
  }
  return true;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const std::string clean = bench::terminal_safe(text);
  if (!harmless(clean, true) || bench::terminal_safe(clean) != clean) std::abort();
  if (harmless(text, true) && clean != text) std::abort();
  for (const std::size_t columns : {2U, 12U, 200U}) {
    const std::string line = bench::one_line(text, columns);
    if (!harmless(line, false) || bench::display_width(line) > columns) std::abort();
  }
  return 0;
}
