#include "bench/common/screen.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <limits>

#include "bench/common/terminal_safe.h"

namespace tactbench::bench {

ScreenSize screen_size(int descriptor) {
  winsize size{};
  if (::ioctl(descriptor, TIOCGWINSZ, &size) != 0 || size.ws_col == 0 || size.ws_row == 0) return {};
  return {size.ws_col, size.ws_row};
}

std::size_t line_columns() {
  return ::isatty(STDOUT_FILENO) != 0 ? screen_size(STDOUT_FILENO).columns : std::numeric_limits<std::size_t>::max();
}

std::string painted(const std::vector<PaintedLine>& block, std::size_t columns, std::size_t above) {
  std::string out = above > 0 ? fmt::format("\x1b[{}F", above) : std::string();
  for (const PaintedLine& line : block) {
    std::size_t left = std::max<std::size_t>(columns, 2) - 1;
    for (const Span& span : line) {
      if (left == 0) break;
      const std::string text = one_line(span.text, left);
      left -= std::min(left, display_width(text));
      out += span.colour < 0 ? text : fmt::format("\x1b[48;5;{}m{}\x1b[0m", span.colour, text);
    }
    out += "\x1b[K\n";
  }
  return out + "\x1b[J";
}

void ScreenBlock::paint(const std::vector<PaintedLine>& block, ScreenSize size) {
  // A change of size has wrapped or moved the displayed lines.
  const bool resized = lines_ > 0 && (size.columns != size_.columns || size.rows != size_.rows);
  if (resized) tty::clear_screen();
  tty::write_painted(painted(block, size.columns, resized ? 0 : lines_));
  lines_ = block.size();
  size_ = size;
}

}  // namespace tactbench::bench
