// Number of terminal columns that a text takes, and the part of it that fits.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace tactbench::analysis {

// For a text without control characters: 0 columns for combining marks, 2 for wide letters.
std::size_t display_width(std::string_view text);
// The text if it fits; else its beginning with ... (U+2026) at the end.
std::string cut_to(std::string_view text, std::size_t columns);

}  // namespace tactbench::analysis
