// The page's characters, paths and frame by hand: which characters are shown, numbers of paths, title, banner,
// contents.
#include <catch2/catch.hpp>
#include <cstdint>
#include <stdexcept>
#include <string>

#include "analysis/report/gather.h"
#include "analysis/report/page/html.h"
#include "analysis/report/page/page.h"
#include "tests/analysis/support/sensor_models.h"

using namespace tactbench::analysis;

namespace {

const std::string kReplaced = "\xEF\xBF\xBD";

std::string utf8_of(std::uint32_t c) {
  const auto byte = [](std::uint32_t value) { return static_cast<char>(static_cast<unsigned char>(value)); };
  if (c < 0x80) return {byte(c)};
  if (c < 0x800) return {byte(0xC0 | (c >> 6)), byte(0x80 | (c & 0x3F))};
  if (c < 0x10000) return {byte(0xE0 | (c >> 12)), byte(0x80 | ((c >> 6) & 0x3F)), byte(0x80 | (c & 0x3F))};
  return {byte(0xF0 | (c >> 18)), byte(0x80 | ((c >> 12) & 0x3F)), byte(0x80 | ((c >> 6) & 0x3F)),
          byte(0x80 | (c & 0x3F))};
}

std::string tenths_of(long first, long second) {
  html::PathData path;
  return path.tenths(first, false).tenths(second, true).value;
}

Page small_page() {
  Page page;
  page.document = "Test report";
  page.number = "12-ab";
  page.json = "{}";
  return page;
}

bool on_page(const Page& page, const std::string& part) { return page_of(page).find(part) != std::string::npos; }

}  // namespace

TEST_CASE("characters by hand: each bound of what is shown, and what is replaced") {
  for (const std::uint32_t shown : {0x09U, 0x0AU, 0x20U, 0x7EU, 0xA0U, 0x2029U, 0x202FU, 0x2065U, 0x206AU, 0xFDCFU,
                                    0xFDF0U, 0xFFFDU, 0x10000U, 0x1FFFDU, 0x10FFFDU}) {
    INFO(shown);
    CHECK(html::Text(utf8_of(shown)).value == utf8_of(shown));
  }
  for (const std::uint32_t replaced : {0x01U, 0x08U, 0x0BU, 0x0DU, 0x1FU, 0x7FU, 0x9FU, 0x202AU, 0x202EU, 0x2066U,
                                       0x2069U, 0xFDD0U, 0xFDEFU, 0xFFFEU, 0xFFFFU, 0x1FFFEU, 0x10FFFFU}) {
    INFO(replaced);
    CHECK(html::Text(utf8_of(replaced)).value == kReplaced);
  }
  CHECK(html::Text("a & b").value == "a &amp; b");
  CHECK(html::Text("\t").value == "\t");
  CHECK(html::Attribute("\t").value == "&#9;");
  CHECK(html::Attribute(" x").value == " x");
  CHECK(html::Text("").value.empty());
}

TEST_CASE("paths by hand: tenths as short as they can be, kept apart where nothing else does") {
  CHECK(tenths_of(0, 0) == "0 0");
  CHECK(tenths_of(5, -5) == ".5-.5");
  CHECK(tenths_of(9, 10) == ".9 1");
  CHECK(tenths_of(10, 11) == "1 1.1");
  CHECK(tenths_of(-10, -11) == "-1-1.1");
  CHECK(tenths_of(125, 1) == "12.5 .1");
  CHECK(tenths_of(-9, 9) == "-.9 .9");
}

TEST_CASE("coordinates by hand: rounded to the digits given, without zeros at the end") {
  CHECK(html::CssNumber(1.004).value == "1");
  CHECK(html::CssNumber(1.006).value == "1.01");
  CHECK(html::CssNumber(-0.5, 1).value == "-0.5");
  CHECK(html::CssNumber(12.3456, 0).value == "12");
  CHECK(html::CssNumber(12.3456, 3).value == "12.346");
  CHECK(html::CssNumber(10.05).value == "10.05");
  CHECK(html::CssNumber(0.1, 4).value == "0.1");
}

TEST_CASE("data in the page by hand: what could end them is written otherwise, wherever it stands") {
  CHECK(html::JsonInHtml(R"({"a":1})").value == R"({"a":1})");
  CHECK(html::JsonInHtml(R"("<")").value == R"("\u003c")");
  CHECK(html::JsonInHtml(R"(">")").value == R"("\u003e")");
  CHECK(html::JsonInHtml(R"("&")").value == R"("\u0026")");
  CHECK(html::JsonInHtml(R"("a<b>c&d")").value == R"("a\u003cb\u003ec\u0026d")");
  CHECK(html::JsonInHtml("<").value == "\\u003c");
}

TEST_CASE("the page by hand: its title, banner, list of contents and end") {
  Page page = small_page();
  CHECK(on_page(page, "<title>Test report 12-ab</title>"));
  CHECK(on_page(page, "<h1>Test report</h1>\n<p class=\"number\">No. 12-ab</p>"));
  CHECK(on_page(page, "End of test report 12-ab."));
  CHECK_FALSE(on_page(page, "class=\"banner\" aria-label"));
  CHECK_FALSE(on_page(page, "<nav"));
  CHECK(on_page(page, "size: A4;"));
  CHECK_FALSE(on_page(page, "content: \"SIMULATED"));
  page.title = "12-ab, signed";
  page.simulated = true;
  page.paper = PaperSize::kLetter;
  page.contents = {{"a", "First"}, {"b", "Second"}};
  page.main = {html::markup("<p>one</p>"), html::markup("<p>two</p>")};
  page.opening = html::markup("<p>opening</p>");
  CHECK(on_page(page, "<title>Test report 12-ab, signed</title>"));
  CHECK(on_page(page, "<aside class=\"banner\""));
  CHECK(on_page(page, "content: \"SIMULATED"));
  CHECK(on_page(page, "size: letter;"));
  CHECK(on_page(page,
                "<p>opening</p><nav aria-label=\"Contents\"><ul>\n<li><a href=\"#a\">First</a></li>\n<li><a "
                "href=\"#b\">Second</a></li>\n</ul></nav>"));
  CHECK(on_page(page, "<main>\n<p>one</p><p>two</p></main>"));
}

TEST_CASE("the style sheet by hand: letters and spaces name a document, digits, a to f and hyphens number it") {
  for (const char* good : {"Report", "a Z", "A z"}) CHECK_NOTHROW(style_sheet({good, "0-9af", false, PaperSize::kA4}));
  for (const char* bad : {"Report1", "a@b", "a[b", "a`b", "a{b", "a\"b", "a-b"})
    CHECK_THROWS_AS(style_sheet({bad, "1", false, PaperSize::kA4}), std::invalid_argument);
  for (const char* bad : {"1g", "1 2", "A", "1/2", "1:2"})
    CHECK_THROWS_AS(style_sheet({"Report", bad, false, PaperSize::kA4}), std::invalid_argument);
}

TEST_CASE("taxels of the indication's figures: those with a model, without models those that are not left out") {
  Health health;
  health.rows = 2;
  health.columns = 2;
  SensorModel fit;
  CHECK(counted_taxels(fit, health) == std::vector<int>{0, 1, 2, 3});
  health.findings = {{1, "dead", "", true}, {2, "noisy", "", false}};
  CHECK(counted_taxels(fit, health) == std::vector<int>{0, 2, 3});
  for (const TaxelStatus status :
       {TaxelStatus::kFitted, TaxelStatus::kFitted, TaxelStatus::kUnfit, TaxelStatus::kFitted})
    fit.taxels.push_back(by_hand::left_out(status));
  CHECK(counted_taxels(fit, health) == std::vector<int>{0, 1, 3});
}
