// A document's numbers and printers: what a number becomes is decided once; text keeps to its width.
#include "analysis/report/document/document.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <sstream>

#include "analysis/report/page/chart.h"
#include "analysis/text_width.h"

using namespace tactbench::analysis;

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
