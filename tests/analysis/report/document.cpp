// A document's numbers and printers: what a number becomes is decided once; text keeps to its width; escapers, style
// sheet and QR code of a page.

#include "analysis/report/document/document.h"

#include <fmt/format.h>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <regex>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "analysis/report/data/data.h"
#include "analysis/report/page/chart.h"
#include "analysis/report/page/html.h"
#include "analysis/report/page/page.h"
#include "analysis/text_width.h"

using namespace tactbench::analysis;
using html::Attribute;
using html::CssNumber;
using html::JsonInHtml;
using html::Text;

TEST_CASE("report values: are rounded to two digits of U, have no negative zero and end with the unit") {
  const auto text = [](const doc::Quantity& quantity, PressureUnit unit = {}) { return doc::text_of(quantity, unit); };
  CHECK(text(doc::number(0.125, 2)) == "0.12");  // half to even: 0.125 is exact
  CHECK(text(doc::number(-1.5, 1)) == "\u22121.5");
  CHECK(text(doc::number(-0.001, 2)) == "0.00");
  CHECK(text(doc::percent_of(0.253, 1)) == "25.3");
  CHECK(text(doc::number(-std::numeric_limits<double>::infinity(), 2)) == "–");
  CHECK(text(doc::number_with_u(0.0, std::nan(""))) == "0.0");
  CHECK(text(doc::number_with_u(56.78, 99.4)) == "57 ± 99");
  CHECK(text(doc::number_with_u(5678.0, 1234.0)) == "5700 ± 1200");
  CHECK(text(doc::two_digits(0.0996)) == "0.10");
  CHECK(text(doc::pressure_with_u(0.9034, 0.13)) == "6.23 ± 0.90\u00A0kPa");
  CHECK(text(doc::bare_pressure_with_u(0.9034, 0.13), PressureUnit::kPsi) == "0.90 ± 0.13");
  CHECK(text(doc::both_units(60.0)) == "413.7\u00A0kPa (60.0\u00A0psi)");
  CHECK(text(doc::both_units(60.0), PressureUnit::kPsi) == "60.0\u00A0psi (413.7\u00A0kPa)");
  CHECK(text(doc::pressure(std::nan(""))) == "–");
  for (const auto& [expanded, decimals] : {std::pair{1e-12, 9},
                                           {1.2e-7, 8},
                                           {0.0994, 3},
                                           {0.0996, 2},
                                           {0.996, 1},
                                           {9.94, 1},
                                           {9.96, 0},
                                           {123.0, 0},
                                           {0.0, 3},
                                           {-1.0, 3}}) {
    INFO(expanded);
    CHECK(gum_decimals(expanded) == decimals);
  }
}

TEST_CASE("text document: keeps to its width, and cuts off what does not fit") {
  doc::Document document;
  document.add(doc::Heading{2, "A heading", "h"});
  document.add(doc::Paragraph{
      {"Words that go on for longer than one line of a narrow terminal has room, ", doc::strong("all of them"), "."}});
  doc::Table table{.id = "t", .caption = "A table", .columns = {{"what"}, {"value", true}, {"a long story"}}};
  table.rows.push_back({{"first", doc::both_units(10.0), "a cell whose text has to be cut, since it is so long"}});
  table.rows.push_back({{"second", Verdict::kFail}});
  document.add(table);
  document.add(doc::SideBySide{{document, document}, {1, 1}});
  for (const std::size_t width : {40U, 80U, 200U}) {
    const std::string text = doc::to_text(document, {}, width);
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) CHECK(display_width(line) <= width);
    for (const char* part : {"heading", "68.9 kPa", "✗ fail"}) CHECK(text.find(part) != std::string::npos);
    CHECK((text.find("\u2026") != std::string::npos) == (width < 200));  // cut
  }
  const std::string html = doc::to_html(document, {}).value;
  CHECK(html.find("<td colspan=\"2\">") != std::string::npos);  // a short row's last cell spans the rest
}

TEST_CASE("text table: has one line per row, cuts marked columns first and drops the last column if needed") {
  doc::Table table{.columns = {{.title = "who", .cut = true}, {"value", true}, {"verdict"}}};
  table.rows.push_back({{std::string(60, 'a'), "1234.5", Verdict::kConditionalPass}});
  table.rows.push_back({{"测试", "6.7", Verdict::kFail}});
  const auto lines = [](const doc::Table& shown, std::size_t width) {
    doc::Document document;
    document.add(shown);
    std::istringstream text(doc::to_text(document, {}, width));
    std::vector<std::string> all;
    for (std::string line; std::getline(text, line);) all.push_back(line);
    for (const std::string& line : all) CHECK(display_width(line) <= width);
    return all;
  };
  for (const std::size_t width : {44U, 60U, 200U}) {
    const std::vector<std::string> all = lines(table, width);
    REQUIRE(all.size() == 3);
    CHECK(all[1].find("1234.5  ▲ conditional pass") != std::string::npos);
    CHECK(display_width(all[1].substr(0, all[1].find("1234.5"))) ==
          display_width(all[2].substr(0, all[2].find("   6.7"))));
  }
  CHECK(lines(table, 16)[1].find("1234.5") != std::string::npos);
  CHECK(lines(table, 16)[1].find("pass") == std::string::npos);
  doc::Table pairs = doc::pairs({}, {{"name", std::string(30, 'a') + " " + std::string(30, 'b')}});
  CHECK(lines(pairs, 40).size() == 2);
}

TEST_CASE("report charts: are drawn without data, with one point, with gaps and beyond their axes") {
  Chart chart{.title = "t<", .x = {"x"}, .y = {"y"}};
  CHECK(chart_svg(chart).value.starts_with("<svg"));
  chart.curves = {{"one", {1.0}, {2.0}}, {"b<", {0, 1, 2, 3}, {0, 1, std::nan(""), 3}, kBlue}};
  chart.bands = {{"band", {0, 1, 2}, {-9, 0, std::nan("")}, {9, 1, 2}}};
  chart.bars = {bars_of({1.0, 2.0, std::nan(""), 9.0}, 0.0, 4.0, 4)};
  chart.rules = {{1.0, "limit"}, {1e9, "far"}, {2.0, "upright", kRed, true}};
  chart.stretches = {{1.0, 1.0, "there"}};
  chart.y.low = -1.0;
  chart.y.high = 1.0;
  for (const bool ends : {true, false})
    for (const bool logarithmic : {true, false}) {
      chart.labels_at_ends = ends;
      chart.y.logarithmic = logarithmic;
      if (logarithmic) chart.y.low = chart.y.high = {};
      const std::string svg = chart_svg(chart).value;
      CHECK(svg.find("nan") == std::string::npos);
      CHECK(svg.find("b&lt;") != std::string::npos);
    }
  CHECK(bars_of({1.0, 2.0, std::nan(""), 9.0}, 0.0, 4.0, 4).counts == std::vector{0.0, 1.0, 1.0, 1.0});
  TaxelMap map{.title = "m", .rows = 2, .columns = 3, .values = {0.0, 1.0, std::nan(""), -1.0, 5.0}, .numbered = true};
  CHECK(taxel_map_svg(map).value.find("nan") == std::string::npos);
  map.logarithmic = true;
  map.low = 0.1;
  CHECK(taxel_map_svg(map).value.find("nan") == std::string::npos);
}

// Escapers of the report, its style sheet, and numbers of its JSON.

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

// The QR code of page 1: its modules as rectangles. That a reader reads it: tests/docs/certificate.py.

namespace {

// The modules within the quiet zone, by the path alone.
std::vector<std::string> modules_of(const std::string& svg) {
  const std::regex size("viewBox=\"0 0 (\\d+) (\\d+)\""), run("M(\\d+) (\\d+)h(\\d+)v1h-(\\d+)z");
  std::smatch found;
  REQUIRE(std::regex_search(svg, found, size));
  const std::size_t width = std::stoul(found[1]);
  CHECK(found[1] == found[2]);
  std::vector<std::string> rows(width, std::string(width, ' '));
  for (std::sregex_iterator at(svg.begin(), svg.end(), run), end; at != end; ++at) {
    CHECK((*at)[3] == (*at)[4]);
    rows.at(std::stoul((*at)[2])).replace(std::stoul((*at)[1]), std::stoul((*at)[3]), std::stoul((*at)[3]), '#');
  }
  for (std::size_t i = 0; i < width; ++i)
    for (std::size_t edge = 0; edge < 4; ++edge) {
      CHECK(rows[edge][i] == ' ');
      CHECK(rows[i][width - 1 - edge] == ' ');
    }
  return rows;
}

}  // namespace

TEST_CASE("QR code: has its three finder patterns in the quiet zone, and depends on its text only") {
  const std::string text = "report 1-2ccd46bc";
  const std::string svg = qr_code_svg(text, "<title>", 84.0).value;
  CHECK(svg == qr_code_svg(text, "<title>", 84.0).value);
  CHECK(svg != qr_code_svg(text + "d", "<title>", 84.0).value);
  CHECK(svg.find("<title>&lt;title&gt;</title>") != std::string::npos);
  const std::vector<std::string> rows = modules_of(svg);
  const std::vector<std::string> finder = {"#######", "#     #", "# ### #", "# ### #", "# ### #", "#     #", "#######"};
  const std::size_t far = rows.size() - 4 - 7;
  for (const auto& [row, column] : {std::pair<std::size_t, std::size_t>{4, 4}, {4, far}, {far, 4}})
    for (std::size_t i = 0; i < finder.size(); ++i) CHECK(rows[row + i].substr(column, 7) == finder[i]);
  for (std::size_t i = 12; i < far; ++i) CHECK(rows[10][i] == (i % 2 == 0 ? '#' : ' '));  // timing pattern
}

TEST_CASE("QR code: an empty or too long text is refused") {
  CHECK_THROWS_AS(qr_code_svg("", "", 84.0), std::invalid_argument);
  CHECK_THROWS_AS(qr_code_svg(std::string(3000, 'x'), "", 84.0), std::invalid_argument);
}
