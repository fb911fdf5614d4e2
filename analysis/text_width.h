// Number of terminal columns that a text takes, and the part of it that fits.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace tactbench::analysis {

// Of a text free of control characters: none for combining marks, two for wide letters.
std::size_t display_width(std::string_view text);
// The text where it fits; else its beginning with ... (U+2026) at the end.
std::string cut_to(std::string_view text, std::size_t columns);

}  // namespace tactbench::analysis
