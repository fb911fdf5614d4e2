// Output to terminals. Text from a store, file, device or keyboard may hold characters that move the cursor, change
// colours or reverse the writing direction, and so rewrite the text around them. All terminal output goes through
// tty::print(), which shows such characters as escapes.
#pragma once

#include <fmt/core.h>

#include <cstddef>
#include <cstdio>
#include <string>
#include <string_view>
#include <vector>

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
// Erases that line. print() erases it before it writes; a line end alone on standard error leaves it.
void erase_status_line();
// Clears the screen of standard output.
void clear_screen();
// Writes to standard output immediately; painted() has made the text safe.
void write_painted(std::string_view painted);

}  // namespace tty

struct ScreenSize {
  std::size_t columns = 80, rows = 24;
};
// Size of the terminal behind a descriptor (STDOUT_FILENO, STDERR_FILENO); 80 x 24 if there is no terminal.
ScreenSize screen_size(int descriptor);
// Width of a line on standard output; unlimited if that is not a terminal, because a program that reads it needs whole
// lines.
std::size_t line_columns();

struct Span {
  std::string text;
  int colour = -1;  // of its background, 0 to 255 as xterm counts them; -1: the terminal's own
  bool operator==(const Span&) const = default;
};
using PaintedLine = std::vector<Span>;

// The bytes that draw the lines on a terminal of `columns`: each span through one_line(), lines cut to columns - 1.
// `above` > 0: first moves the cursor up by as many lines, to the first line of the previous block.
std::string painted(const std::vector<PaintedLine>& block, std::size_t columns, std::size_t above);

// A block on standard output that each paint() overwrites. A block must leave one row of the screen free.
class ScreenBlock {
 public:
  void paint(const std::vector<PaintedLine>& block, ScreenSize size);

 private:
  std::size_t lines_ = 0;
  ScreenSize size_{0, 0};
};

}  // namespace tactbench::bench
