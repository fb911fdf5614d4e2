// The QR code of page 1: its modules as rectangles. That a reader reads it: tests/docs/certificate.py.
#include "analysis/report/page/chart.h"

#include <catch2/catch.hpp>
#include <regex>
#include <stdexcept>
#include <vector>

using namespace tactbench::analysis;

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

TEST_CASE("a QR code has its three finder patterns in the quiet zone, and is of its text alone") {
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
