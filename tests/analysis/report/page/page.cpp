// Escapers, numbers, ticks and colours of the report.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>
#include <vector>

#include "analysis/report/data/data.h"
#include "analysis/report/page/figure.h"
#include "analysis/report/page/html.h"
#include "analysis/report/page/style.h"
#include "tests/analysis/report/page/luminance.h"

using namespace tactbench::analysis;
using html::Attribute;
using html::CssNumber;
using html::JsonInHtml;
using html::Text;

namespace {

double contrast(const std::string& a, const std::string& b) {
  const double la = luminance(a), lb = luminance(b);
  return (std::max(la, lb) + 0.05) / (std::min(la, lb) + 0.05);
}

const std::string kBad = "\xEF\xBF\xBD";

}  // namespace

TEST_CASE("text and attributes are escaped and always valid XML characters") {
  CHECK(Text("<a href='x'>&\"</a>").value == "&lt;a href=&#39;x&#39;&gt;&amp;&quot;&lt;/a&gt;");
  CHECK(Text("]]>").value == "]]&gt;");
  CHECK(Text("+5 °C 漢 𝄞").value == "+5 °C 漢 𝄞");
  CHECK(Text(std::string("a\0b", 3)).value == "a" + kBad + "b");
  CHECK(Text("\x1b\x7f").value == kBad + kBad);
  CHECK(Text("\xc2\x85").value == kBad);                               // C1
  CHECK(Text("\xff").value == kBad);                                   // never in UTF-8
  CHECK(Text("\xc0\xaf").value == kBad + kBad);                        // overlong
  CHECK(Text("\xe0\x80\xaf").value == kBad + kBad + kBad);             // overlong
  CHECK(Text("\xed\xa0\x80").value == kBad + kBad + kBad);             // surrogate
  CHECK(Text("\xf4\x90\x80\x80").value == kBad + kBad + kBad + kBad);  // above U+10FFFF
  CHECK(Text("\xef\xbf\xbe").value == kBad);                           // U+FFFE
  CHECK(Text("\xe2\x82").value == kBad + kBad);                        // cut short
  CHECK(Text("\xe2\x80\xae").value == kBad);                           // right-to-left override
  CHECK(Attribute("a\tb\nc").value == "a&#9;b&#10;c");
  CHECK(JsonInHtml("{\"a\":\"</script>&\"}").value == "{\"a\":\"\\u003c/script\\u003e\\u0026\"}");
}

TEST_CASE("numbers for the reader") {
  CHECK(html::fixed(0.125, 2).value == "0.12");  // half to even: 0.125 is exact
  CHECK(html::fixed(0.375, 2).value == "0.38");
  CHECK(html::fixed(-1.5, 1).value == "\u22121.5");
  CHECK(html::fixed(-0.001, 2).value == "0.00");
  CHECK(html::fixed(std::nan(""), 2).value == "not available");
  CHECK(html::fixed(-std::numeric_limits<double>::infinity(), 2).value == "not available");
  CHECK(html::percent(0.253, 1).value == "25.3");
  CHECK(html::pressure(10.0, PressureUnit::kKilopascal, 2).value == "68.9\u00A0kPa (10.00\u00A0psi)");
  CHECK(html::pressure(10.0, PressureUnit::kBar, 2).value == "0.689\u00A0bar (10.00\u00A0psi)");
  CHECK(html::pressure(-10.0, PressureUnit::kPsi, 2).value == "\u221210.00\u00A0psi (\u221268.9\u00A0kPa)");
  CHECK(html::pressure(std::nan(""), PressureUnit::kKilopascal, 2).value == "not available");
  CHECK(html::in_unit(60.0, PressureUnit::kKilopascal, 1).value == "413.7");
  CHECK(html::significant(1.5e-7, 3).value == "1.5 × 10^\u22127");
  CHECK(html::stated(" \t").value == "not stated");
  CHECK(CssNumber(-0.001).value == "0");
  CHECK(CssNumber(100.0).value == "100");
  CHECK(CssNumber(1.50).value == "1.5");
  CHECK(CssNumber(-12.05).value == "-12.05");
  CHECK(CssNumber(0.07).value == "0.07");
  CHECK(CssNumber(2.99996, 4).value == "3");
  CHECK_THROWS_AS(CssNumber(std::nan("")), std::invalid_argument);
  CHECK_THROWS_AS(style_sheet({"Report", "12-ab\"; } body { display: none", true, PaperSize::kA4}),
                  std::invalid_argument);
}

TEST_CASE("a list of numbers in the JSON is what printf would write") {
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

TEST_CASE("ticks are round and inside the range") {
  CHECK(nice_ticks(0.0, 60.0, 6) == std::vector<double>{0, 10, 20, 30, 40, 50, 60});
  CHECK(nice_ticks(0.0, 3.5, 6) == std::vector<double>{0, 1, 2, 3});
  CHECK(nice_ticks(-0.3, 0.3, 6).size() == 7);
  CHECK(nice_ticks(2.0, 2.0, 6).size() == 1);
  for (const double high : {1e-6, 0.013, 7.7, 2.5e4, 9e8}) {
    const auto ticks = nice_ticks(0.0, high, 6);
    CHECK(ticks.size() >= 3);
    CHECK(ticks.size() <= 8);
    CHECK(ticks.back() <= high * (1.0 + 1e-9));
  }
}

TEST_CASE("line colours and status colours can be read on white") {
  for (const LineStyle& style : kLineStyles) CHECK(contrast(style.colour, "#ffffff") >= 4.5);
  for (std::size_t i = 0; i < std::size(kLineStyles); ++i) {
    for (std::size_t j = i + 1; j < std::size(kLineStyles); ++j)
      CHECK(std::string(kLineStyles[i].dashes) != kLineStyles[j].dashes);
  }
  const std::string css = style_sheet({"Report", "1-0", true, PaperSize::kA4}).value;
  for (const char* colour : {"#1a1a1a", "#444444", "#00507d", "#1b6e3c", "#aa1111", "#8a5a00"}) {
    CHECK(css.find(colour) != std::string::npos);
    CHECK(contrast(colour, "#ffffff") >= 4.5);
  }
  CHECK(css.find("display: grid") == std::string::npos);
}

TEST_CASE("cividis rises in lightness from end to end and is clamped") {
  CHECK(cividis(-1.0) == "#00204d");
  CHECK(cividis(0.0) == "#00204d");
  CHECK(cividis(1.0) == "#ffea46");
  CHECK(cividis(2.0) == "#ffea46");
  double last = -1.0;
  for (int i = 0; i <= 64; ++i) {
    const double now = luminance(cividis(i / 64.0));
    CHECK(now > last);
    last = now;
  }
}

TEST_CASE("a frame map has one path a colour bin, and a taxel without a value is crossed out") {
  FrameMap map{"title & more", 2, 2, {0.0, 1.0, 1.0, std::nan("")}, {0.0, 1.0}, 40.0};
  const std::string svg = frame_map(map).value;
  CHECK(svg.find("<title>title &amp; more</title>") != std::string::npos);
  CHECK(svg.find("class=\"cross\"") != std::string::npos);
  // Base colour, the other bin, the blank cell, its cross.
  std::size_t paths = 0;
  for (std::size_t at = svg.find("<path"); at != std::string::npos; at = svg.find("<path", at + 1)) ++paths;
  CHECK(paths == 4);
  map.values.back() = 7.0;  // beyond the scale: the end's colour
  CHECK(frame_map(map).value.find("cross") == std::string::npos);
  const std::string numbered = numbered_map(map, 1).value;
  CHECK(numbered.find(">7.0</text>") != std::string::npos);
  CHECK(numbered.find("fill=\"#ffffff\">0.0</text>") != std::string::npos);
  CHECK(numbered.find("fill=\"#000000\">1.0</text>") != std::string::npos);
}

TEST_CASE("charts without data, with one point and with gaps can be drawn") {
  CHECK(line_chart({"t", "x", "y", {}, 300, 200, false}).value.find("<svg") == 0);
  CHECK(line_chart({"t", "x", "y", {{"one", {1.0}, {2.0}, 0, false}}, 300, 200, false}).value.find("nan") ==
        std::string::npos);
  const std::string holes =
      line_chart({"t",
                  "x",
                  "y",
                  {{"a", {0, 1, 2, 3}, {0, 1, std::nan(""), 3}, 0, false}, {"b<", {0}, {0}, 1, true}},
                  300,
                  200,
                  true})
          .value;
  CHECK(holes.find("b&lt;") != std::string::npos);
  CHECK(holes.find("nan") == std::string::npos);
}
