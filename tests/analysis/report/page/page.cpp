// Escapers of the report, its style sheet, and numbers of its JSON.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>
#include <vector>

#include "analysis/report/data/data.h"
#include "analysis/report/page/html.h"
#include "analysis/report/page/page.h"

using namespace tactbench::analysis;
using html::Attribute;
using html::CssNumber;
using html::JsonInHtml;
using html::Text;

namespace {

const std::string kBad = "\xEF\xBF\xBD";

std::string utf8_of(std::uint32_t c) {
  const auto byte = [](std::uint32_t value) { return static_cast<char>(static_cast<unsigned char>(value)); };
  if (c < 0x80) return {byte(c)};
  if (c < 0x800) return {byte(0xC0 | (c >> 6)), byte(0x80 | (c & 0x3F))};
  if (c < 0x10000) return {byte(0xE0 | (c >> 12)), byte(0x80 | ((c >> 6) & 0x3F)), byte(0x80 | (c & 0x3F))};
  return {byte(0xF0 | (c >> 18)), byte(0x80 | ((c >> 12) & 0x3F)), byte(0x80 | ((c >> 6) & 0x3F)),
          byte(0x80 | (c & 0x3F))};
}

}  // namespace

TEST_CASE("HTML text: text and attributes are escaped and contain only valid XML characters") {
  CHECK(Text("<a href='x'>&\"</a>").value == "&lt;a href=&#39;x&#39;&gt;&amp;&quot;&lt;/a&gt;");
  CHECK(Text("]]>").value == "]]&gt;");
  CHECK(Text("+5 °C 漢 𝄞").value == "+5 °C 漢 𝄞");
  CHECK(Text(std::string("a\0b", 3)).value == "a" + kBad + "b");
  CHECK(Text("\xff").value == kBad);                                   // never in UTF-8
  CHECK(Text("\xc0\xaf").value == kBad + kBad);                        // overlong
  CHECK(Text("\xe0\x80\xaf").value == kBad + kBad + kBad);             // overlong
  CHECK(Text("\xed\xa0\x80").value == kBad + kBad + kBad);             // surrogate
  CHECK(Text("\xf4\x90\x80\x80").value == kBad + kBad + kBad + kBad);  // above U+10FFFF
  CHECK(Text("\xe2\x82").value == kBad + kBad);                        // cut short
  CHECK(Attribute("a\tb\nc").value == "a&#9;b&#10;c");
  CHECK(JsonInHtml(R"({"a":1})").value == R"({"a":1})");
  CHECK(JsonInHtml("<").value == "\\u003c");
  CHECK(JsonInHtml("{\"a\":\"</script>&\"}").value == "{\"a\":\"\\u003c/script\\u003e\\u0026\"}");
}

TEST_CASE("CSS numbers: are printed as short as possible, and non-finite ones are refused") {
  for (const auto& [number, text] :
       {std::pair{-0.001, "0"}, {100.0, "100"}, {1.50, "1.5"}, {-12.05, "-12.05"}, {0.07, "0.07"}})
    CHECK(CssNumber(number).value == text);
  CHECK(CssNumber(2.99996, 4).value == "3");
  CHECK_THROWS_AS(CssNumber(std::nan("")), std::invalid_argument);
}

TEST_CASE("JSON number lists: are printed as printf would, non-finite values as null") {
  CHECK(json_text(number_list(std::vector{0.0, -1.5, 3.49, 60.0, std::nan(""), HUGE_VAL})) ==
        "[0,-1.5,3.49,60,null,null]");
  CHECK(json_text(number_list({})) == "[]");
  CHECK(json_text({{"a", number_list(std::vector{2.0 / 3.0, 123.4}, 3)}, {"b<\u00e9", "c\n"}}) ==
        "{\"a\":[0.667,123],\"b<\\u00e9\":\"c\\n\"}");
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> power(-13.0, 11.0), sign(-1.0, 1.0);
  for (int i = 0; i < 20000; ++i) {
    const double number = std::copysign(std::pow(10.0, power(random)), sign(random));
    for (const int digits : {3, 5, 7}) {
      const std::string text = json_text(number_list(std::vector{number}, digits));
      CHECK(text == fmt::format("[{:.{}g}]", number, digits));
    }
  }
  for (const double number : {9.9999999, 99999.96, 999999.96, 0.00099999999, 1e-4, 0.1, 1.0, 1e6})
    CHECK(std::stod(json_text(number_list(std::vector{number})).substr(1)) == Approx(number).epsilon(1e-7));
}

TEST_CASE("HTML text: characters are shown or replaced correctly at each bound of the valid ranges") {
  for (const std::uint32_t shown : {0x09U, 0x0AU, 0x20U, 0x7EU, 0xA0U, 0x2029U, 0x202FU, 0x2065U, 0x206AU, 0xFDCFU,
                                    0xFDF0U, 0xFFFDU, 0x10000U, 0x1FFFDU, 0x10FFFDU}) {
    INFO(shown);
    CHECK(html::Text(utf8_of(shown)).value == utf8_of(shown));
  }
  for (const std::uint32_t replaced : {0x01U, 0x08U, 0x0BU, 0x0DU, 0x1FU, 0x7FU, 0x9FU, 0x202AU, 0x202EU, 0x2066U,
                                       0x2069U, 0xFDD0U, 0xFDEFU, 0xFFFEU, 0xFFFFU, 0x1FFFEU, 0x10FFFFU}) {
    INFO(replaced);
    CHECK(html::Text(utf8_of(replaced)).value == kBad);
  }
  CHECK(html::Text("\t").value == "\t");
  CHECK(html::Attribute("\t").value == "&#9;");
  CHECK(html::Attribute(" x").value == " x");
  CHECK(html::Text("").value.empty());
}

TEST_CASE("style sheet: accepts letters and spaces as document name, hex digits and hyphens as number") {
  const auto sheet = [](const char* document, const char* number, const char* state) {
    return style_sheet({document, number, state, false, PaperSize::kA4});
  };
  for (const char* good : {"Report", "a Z", "A z"}) CHECK_NOTHROW(sheet(good, "0-9af", "issued 2024-05-06, so"));
  for (const char* bad : {"Report1", "a@b", "a[b", "a`b", "a{b", "a\"b", "a-b"})
    CHECK_THROWS_AS(sheet(bad, "1", ""), std::invalid_argument);
  for (const char* bad : {"1g", "1 2", "A", "1/2", "1:2"})
    CHECK_THROWS_AS(sheet("Report", bad, ""), std::invalid_argument);
  for (const char* bad : {"a\"b", "a}b", "a\\b"}) CHECK_THROWS_AS(sheet("Report", "1", bad), std::invalid_argument);
}
