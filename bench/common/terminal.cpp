#include "bench/common/terminal.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <mutex>

#include "bench/common/error.h"
#include "db/remarks.h"

namespace tactbench::bench {
namespace {

// Not the joiners U+200C and U+200D, which some scripts and emoji need.
bool is_hidden(std::uint32_t c) {
  return c < 0x20 || (c >= 0x7F && c <= 0x9F) || c == 0x061C || c == 0x200B || c == 0x200E || c == 0x200F ||
         (c >= 0x2028 && c <= 0x202E) || (c >= 0x2060 && c <= 0x2069) || c == 0xFEFF;
}

std::string shown(std::string_view text, bool keeps_lines) {
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    const auto plain = static_cast<std::size_t>(
        std::ranges::find_if_not(text, [](char c) { return c >= ' ' && c <= '~'; }) - text.begin());
    out += text.substr(0, plain);
    text.remove_prefix(plain);
    if (text.empty()) break;
    const db::CodePoint c = db::decode_utf8(text);
    if (!c.valid) {
      out += fmt::format("\\x{:02x}", static_cast<unsigned char>(text.front()));
    } else if (keeps_lines && (c.value == '\n' || c.value == '\t')) {
      out += text.front();
    } else if (is_hidden(c.value)) {
      out += c.value < 0x20 ? fmt::format("\\x{:02x}", c.value) : fmt::format("\\u{:04x}", c.value);
    } else {
      out += text.substr(0, c.bytes);
    }
    text.remove_prefix(c.bytes);
  }
  return out;
}

void write_raw(std::FILE* stream, std::string_view text) {
  if (std::fwrite(text.data(), 1, text.size(), stream) == text.size() || stream == stderr) return;
  throw Error("TB-FILE-WRITE", fmt::format("the result cannot be written: {}", std::strerror(errno)), "standard output",
              "check space and permissions of the file, or the reader of the pipe");
}

}  // namespace

std::string terminal_safe(std::string_view text) { return shown(text, true); }

std::string one_line(std::string_view text, std::size_t columns) {
  const std::string_view part = text.substr(0, 4 * columns + 4);  // a character has at most four bytes
  const std::string line = shown(part, false);
  return analysis::cut_to(part.size() == text.size() ? line : line + "\u2026", columns);
}

std::string clock_text(double seconds) {
  const long whole = std::lround(seconds);
  return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
}

namespace tty {

namespace {

// A thread may renew the line while another prints.
std::mutex& line_mutex() {
  static std::mutex mutex;
  return mutex;
}
bool line_open = false;  // guarded by line_mutex()

void erase_open_line() {
  if (line_open) write_raw(stderr, "\r\x1b[K");
  line_open = false;
}

}  // namespace

void vprint(std::FILE* stream, fmt::string_view format, fmt::format_args args) {
  const std::string text = terminal_safe(fmt::vformat(format, args));
  const std::lock_guard lock(line_mutex());
  if (stream == stderr && text == "\n")  // ends the status line, which is kept
    line_open = false;
  else
    erase_open_line();
  write_raw(stream, text);
}

void update_status_line(std::string_view text) {
  const std::size_t columns = std::max<std::size_t>(screen_size(STDERR_FILENO).columns, 2) - 1;
  const std::string line = fmt::format("\r{}\x1b[K", one_line(text, std::min(columns, kMaxCellColumns)));
  const std::lock_guard lock(line_mutex());
  write_raw(stderr, line);
  line_open = true;
}

void erase_status_line() {
  const std::lock_guard lock(line_mutex());
  erase_open_line();
}

void clear_screen() { write_raw(stdout, "\x1b[H\x1b[2J"); }

void write_painted(std::string_view painted) {
  write_raw(stdout, painted);
  (void)std::fflush(stdout);
}

}  // namespace tty

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
