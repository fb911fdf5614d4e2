// The terminal's size, and a block of lines on standard output that is painted over in place.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace tactbench::bench {

struct ScreenSize {
  std::size_t columns = 80, rows = 24;
};
// Of the terminal behind a descriptor (STDOUT_FILENO, STDERR_FILENO); none: 80 x 24.
ScreenSize screen_size(int descriptor);
// Of a line on standard output; no end where that is no terminal: what reads it wants whole lines.
std::size_t line_columns();

struct Span {
  std::string text;
  int colour = -1;  // of its background, 0 to 255 as xterm counts them; -1: the terminal's own
  bool operator==(const Span&) const = default;
};
using PaintedLine = std::vector<Span>;

// The bytes that draw the lines on a terminal of that width: each span through one_line(), lines cut to columns - 1.
// `above` > 0: first moves the cursor up by as many lines, to the first line of the previous block.
std::string painted(const std::vector<PaintedLine>& block, std::size_t columns, std::size_t above);

// A block on standard output that each paint() writes over. A block has to leave one row of the screen free.
class ScreenBlock {
 public:
  void paint(const std::vector<PaintedLine>& block, ScreenSize size);

 private:
  std::size_t lines_ = 0;
  ScreenSize size_{0, 0};
};

}  // namespace tactbench::bench

// Erases the line of standard error that tty::update_status_line() overwrites (terminal_safe.h). tty::print() erases it
// before it writes; a line end alone on standard error leaves it.

namespace tactbench::bench::tty {

void erase_status_line();

}  // namespace tactbench::bench::tty
