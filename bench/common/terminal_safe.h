// Text made safe for terminals. Text from a store, file, device or keyboard may hold characters that move the cursor,
// change colours or reverse the writing direction, and so rewrite the text around them. All terminal output goes
// through tty::print(), which shows such characters as escapes.
#pragma once

#include <fmt/core.h>

#include <cstddef>
#include <cstdio>
#include <string>
#include <string_view>

#include "analysis/text_width.h"

namespace tactbench::bench {

// Control characters become \x1b, \u009b, \u202e (bidirectional marks, line separators, zero-width characters), bytes
// that are not UTF-8 become \xff; line ends, tabs and all other characters stay. Valid JSON stays valid JSON.
std::string terminal_safe(std::string_view text);

// The same with line ends and tabs shown as well, cut with ... (U+2026) to `columns` of a terminal.
inline constexpr std::size_t kMaxTextLength = 2000;  // for one field of an error
inline constexpr std::size_t kMaxCellColumns = 200;  // for the last cell of a table's line
std::string one_line(std::string_view text, std::size_t columns = kMaxCellColumns);

using analysis::display_width;

// "h:mm:ss".
std::string clock_text(double seconds);

namespace tty {

// Like fmt::print, through terminal_safe(). Standard output that cannot be written throws Error TB-FILE-WRITE; standard
// error that cannot be written is ignored, so that it does not end a run.
void vprint(std::FILE* stream, fmt::string_view format, fmt::format_args args);

template <class... Args>
void print(std::FILE* stream, fmt::format_string<Args...> format, Args&&... args) {
  tty::vprint(stream, format, fmt::make_format_args(args...));
}
template <class... Args>
void print(fmt::format_string<Args...> format, Args&&... args) {
  tty::vprint(stdout, format, fmt::make_format_args(args...));
}

// One line of standard error, cut to the terminal's width; the next call overwrites it.
void update_status_line(std::string_view text);
// Clears the screen of standard output.
void clear_screen();
// Writes to standard output immediately; painted() of bench/common/screen.h has made the text safe.
void write_painted(std::string_view painted);

}  // namespace tty
}  // namespace tactbench::bench
