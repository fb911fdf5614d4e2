// Small plots of figures that do not change, of zeros, and of a band beyond all values; sparklines at their edges.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "bench/nightly/followed_page.h"

using namespace tactbench;
using namespace tactbench::bench;

namespace {

std::string plot_of(const std::vector<double>& values, const std::optional<analysis::ControlBand>& band = {}) {
  FollowedFigure figure;
  figure.name = "a_psi";
  figure.values = values;
  figure.runs.assign(values.size(), 1);
  figure.accepted.assign(values.size(), false);
  figure.chart.band = band;
  Followed followed;
  followed.subject = "s";
  followed.figures = {figure};
  const std::string page = trend_page("t", "hardware", {followed});
  const std::size_t from = page.find("<svg"), to = page.find("</svg>");
  return page.substr(from, to - from);
}

}  // namespace

TEST_CASE("plot edges: values that are all alike lie in the middle, zeros and negative ones, too") {
  for (const double value : {0.0, 5.0, -5.0, 1e-3}) {
    const std::string plot = plot_of({value, value});
    INFO(plot);
    CHECK(plot.find("d=\"M4 15L166 15\"/><circle class=\"dot\" cx=\"166\" cy=\"15\"") != std::string::npos);
  }
}

TEST_CASE("plot edges: a band below or above all values is part of the height") {
  // 0 to 10 over 30 units, 8 % of it free above and below: 30 (1 - (v + 0.8) / 11.6).
  const std::string below = plot_of({10.0, 10.0}, analysis::ControlBand{0.5, 0.1, 0.0, 1.0, 8});
  CHECK_THAT(below, Catch::Contains("<path class=\"band\" d=\"M0 25.34H170V27.93H0Z\"/>") &&
                        Catch::Contains("d=\"M4 2.07L166 2.07\"/>"));
  const std::string above = plot_of({0.0, 0.0}, analysis::ControlBand{9.5, 0.1, 9.0, 10.0, 8});
  CHECK_THAT(above, Catch::Contains("<path class=\"band\" d=\"M0 2.07H170V4.66H0Z\"/>") &&
                        Catch::Contains("d=\"M4 27.93L166 27.93\"/>"));
}

TEST_CASE("plot edges: sparklines in eight steps, in the middle without a span, dots for what is no number") {
  CHECK(sparkline({0, 1, 2, 3, 4, 5, 6, 7, 8}, 9) == "▁▂▃▄▅▆▇██");
  CHECK(sparkline({0.0, 0.99, 1.01, 8.0}, 4) == "▁▁▂█");
  CHECK(sparkline({-2.0, -1.0, 0.0}, 3) == "▁▅█");
  CHECK(sparkline({3.0, 3.0}, 5) == "▅▅");
  const double none = std::numeric_limits<double>::infinity();
  CHECK(sparkline({none, 1.0, -none, 2.0, std::nan("")}, 5) == "·▁·█·");
  CHECK(sparkline({9.0, 1.0, 2.0}, 2) == "▁█");
  CHECK(sparkline({1.0, 2.0}, 0).empty());
}
