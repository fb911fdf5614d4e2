// The terminal's size, and a block of lines on standard output that is redrawn in place.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace tactbench::bench {

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

// Erases the line of standard error that tty::update_status_line() overwrites (terminal_safe.h). tty::print() erases it
// before it writes; a line end alone on standard error leaves it.

namespace tactbench::bench::tty {

void erase_status_line();

}  // namespace tactbench::bench::tty
