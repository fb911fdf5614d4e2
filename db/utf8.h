// UTF-8, one character at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

namespace tactbench::db {

struct CodePoint {
  std::uint32_t value = 0;
  std::size_t bytes = 1;
  bool valid = false;  // false: one byte that starts no sequence
};

// The first sequence of the non-empty `text` (RFC 3629: no overlong forms, no surrogates, at most U+10FFFF).
CodePoint decode_utf8(std::string_view text);

// True if there is no visible character: only blanks of any kind, zero-width marks or line ends, or an empty text.
bool is_blank(std::string_view text);

}  // namespace tactbench::db
