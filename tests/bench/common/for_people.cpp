#include "bench/common/for_people.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "bench/common/error.h"

using namespace tactbench::bench;

namespace {

// Whether a terminal may be sent this: lines, tabs, and what a person reads.
bool harmless(const std::string& text) {
  for (const char c : text)
    if ((static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t') || c == 0x7F) return false;
  return text.find("\u009b") == std::string::npos && text.find("\u202e") == std::string::npos;
}

}  // namespace

TEST_CASE("control characters are escaped, ordinary text stays unchanged") {
  CHECK(for_people("\x1b[31mred\x1b[0m") == "\\x1b[31mred\\x1b[0m");
  CHECK(for_people("title\x1b]0;t\x07\r\b\x7f") == "title\\x1b]0;t\\x07\\x0d\\x08\\u007f");
  CHECK(for_people(std::string("a\0b", 3)) == "a\\x00b");
  CHECK(for_people("C1: \u009b31m \u0085") == "C1: \\u009b31m \\u0085");
  CHECK(for_people("a\u200bb\u200ec\u2028d\u061c\u2060\ufeff") == "a\\u200bb\\u200ec\\u2028d\\u061c\\u2060\\ufeff");
  CHECK(for_people("\u202egnp.exe\u202c \u2066x\u2069") == "\\u202egnp.exe\\u202c \\u2066x\\u2069");
  CHECK(for_people("\xff\xc0\xaf\xed\xa0\x80") == "\\xff\\xc0\\xaf\\xed\\xa0\\x80");
  CHECK(for_people("cut \xe2\x82") == "cut \\xe2\\x82");
  for (const char* good : {"", "plain", "two\nlines\tand a tab", "Größe ±5 µm, 测试, ✓, 🙂, e\u0301", "C:\\x1b"})
    CHECK(for_people(good) == good);
}

TEST_CASE("a text for one line has no line breaks and is cut to its number of columns") {
  CHECK(one_line("a\nb\tc") == "a\\x0ab\\x09c");
  CHECK(one_line("abcdef", 6) == "abcdef");
  CHECK(one_line("abcdefg", 6) == "abcde\u2026");
  CHECK(one_line("测试测试", 6) == "测试\u2026");
  CHECK(one_line("测试", 2) == "\u2026");
  CHECK(display_width("测试") == 4);
  CHECK(display_width("e\u0301a") == 2);
  CHECK(display_width("✓") == 1);
  CHECK(display_width(one_line(std::string(100'000, '\x1b'), 50)) <= 50);
  std::string marks = "a";
  for (int i = 0; i < 5000; ++i) marks += "\u0301";
  CHECK(one_line(marks, 50).size() < 300);
  CHECK(one_line(marks, 50).ends_with("\u2026"));
}

TEST_CASE("an error's text has no control characters and a bounded length") {
  const std::string evil = "x\x1b]0;t\x07\r\u009b\u202e\xff\ny";
  const std::string text = error_text(Error("TB-USAGE", evil, evil, evil, evil));
  CHECK(harmless(text));
  CHECK(std::count(text.begin(), text.end(), '\n') == 4);
  const std::string longest = error_text(Error("TB-USAGE", std::string(1'000'000, 'm'), ""));
  CHECK(longest.size() < 3000);
}

TEST_CASE("which characters are hidden, and which take no column or two: the ends of Unicode's blocks") {
  const auto utf8 = [](std::uint32_t c) {
    std::string text;
    if (c < 0x80) return std::string(1, static_cast<char>(c));
    const int more = c < 0x800 ? 1 : c < 0x10000 ? 2 : 3;
    text += static_cast<char>((more == 1 ? 0xC0U : more == 2 ? 0xE0U : 0xF0U) | (c >> (6 * more)));
    for (int i = more - 1; i >= 0; --i) text += static_cast<char>(0x80U | ((c >> (6 * i)) & 0x3FU));
    return text;
  };
  const std::vector<std::pair<std::uint32_t, std::uint32_t>> hidden = {
      {0x00, 0x08},     {0x0B, 0x1F},     {0x7F, 0x9F},     {0x61C, 0x61C},   {0x200B, 0x200B},
      {0x200E, 0x200F}, {0x2028, 0x202E}, {0x2060, 0x2069}, {0xFEFF, 0xFEFF},
  };
  const auto is_shown = [&](std::uint32_t c) { return for_people(utf8(c)) == utf8(c); };
  for (const auto& [first, last] : hidden) {
    INFO("U+" << std::hex << first << " to U+" << last);
    CHECK_FALSE(is_shown(first));
    CHECK_FALSE(is_shown(last));
    CHECK(is_shown(last + 1));
    if (first > 0) CHECK(is_shown(first - 1));
  }
  for (const std::uint32_t none : {0x0300U, 0x036FU, 0xFE0FU, 0xFEFFU}) CHECK(display_width(utf8(none)) == 0);
  for (const std::uint32_t two : {0x1100U, 0x3041U, 0xD7A3U, 0xFF60U, 0x1F600U}) CHECK(display_width(utf8(two)) == 2);
  CHECK(display_width("aé") == 2);
  CHECK(one_line("\U00010330\U00010331", 2) == "\U00010330\U00010331");  // four bytes each, one column
}

TEST_CASE("a time on a clock, to the nearest second") {
  CHECK(clock_text(0.49) == "0:00:00");
  CHECK(clock_text(59.5) == "0:01:00");
  CHECK(clock_text(3661.0) == "1:01:01");
  CHECK(clock_text(100 * 3600.0 + 62.0) == "100:01:02");
}
