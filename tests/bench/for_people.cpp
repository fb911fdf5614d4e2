#include "bench/common/for_people.h"

#include <algorithm>
#include <catch2/catch.hpp>

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

TEST_CASE("control characters are shown, what people write stays") {
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

TEST_CASE("one line is one line, cut by the columns that it takes") {
  CHECK(one_line("a\nb\tc") == "a\\x0ab\\x09c");
  CHECK(one_line("abcdef", 6) == "abcdef");
  CHECK(one_line("abcdefg", 6) == "abcde\u2026");
  CHECK(one_line("测试测试", 6) == "测试\u2026");
  CHECK(display_width("测试") == 4);
  CHECK(display_width("e\u0301a") == 2);
  CHECK(display_width("✓") == 1);
  CHECK(display_width(one_line(std::string(100'000, '\x1b'), 50)) <= 50);
  std::string marks = "a";
  for (int i = 0; i < 5000; ++i) marks += "\u0301";
  CHECK(one_line(marks, 50).size() < 300);
  CHECK(one_line(marks, 50).ends_with("\u2026"));
}

TEST_CASE("a cell is as wide as its column, whatever is in it") {
  for (const char* text : {"", "abc", "abcdefghijkl", "测试测试测试测试", "\x1b[31mabcdef", "e\u0301\u0301\u0301"}) {
    INFO(text);
    CHECK(display_width(cell(text, 10)) == 10);
    CHECK(cell(text, 10).ends_with(' '));
  }
}

TEST_CASE("an error's text holds no control character, whoever wrote it, and has an end") {
  const std::string evil = "x\x1b]0;t\x07\r\u009b\u202e\xff\ny";
  const std::string text = error_text(Error(ExitCode::kUsage, "TB-TEST", evil, evil, evil, evil));
  CHECK(harmless(text));
  CHECK(std::count(text.begin(), text.end(), '\n') == 4);
  const std::string longest = error_text(Error(ExitCode::kUsage, "TB-TEST", std::string(1'000'000, 'm'), "", ""));
  CHECK(longest.size() < 3000);
}
