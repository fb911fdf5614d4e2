// Figures and numbers of the page by hand: scales in two units, axes at their bounds, maps, histograms, U as printed.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <string>

#include "analysis/report/page/figure.h"
#include "analysis/report/page/gum_numbers.h"
#include "tests/analysis/report/page/luminance.h"

using namespace tactbench::analysis;

namespace {

constexpr double kEmptyCell = std::numeric_limits<double>::quiet_NaN();

bool holds(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

// A chart whose labels are these of its axis alone.
std::string axis_drawn(std::vector<double> x, std::vector<double> y, double width, double height, bool from_zero) {
  return line_chart({"t", "x", "y", {{"", std::move(x), std::move(y), 0}}, width, height, from_zero}).value;
}

}  // namespace

TEST_CASE("charts of pressures by hand: series and labels in the unit, the other unit beside it from 300 pixels on") {
  const LineChart chart{"t", "gauge pressure", "U", {{"a", {0.0, 10.0}, {1.0, 2.0}, 0}}, 300.0, 200.0};
  const double kpa = 6.894757293168361;
  const LineChart along = pressure_along(chart, PressureUnit::kKilopascal);
  CHECK((along.x_label == "gauge pressure in kPa" && along.y_label == "U"));
  CHECK((along.series[0].x[1] == Approx(10.0 * kpa) && along.series[0].y[1] == 2.0));
  CHECK((along.x_beside.unit == "psi" && along.x_beside.factor == Approx(1.0 / kpa) && along.y_beside.unit.empty()));
  const LineChart up = pressure_up(chart, PressureUnit::kPsi);
  CHECK((up.x_label == "gauge pressure" && up.y_label == "U in psi"));
  CHECK((up.series[0].x[1] == 10.0 && up.series[0].y[1] == 2.0));
  CHECK((up.y_beside.unit == "kPa" && up.y_beside.factor == Approx(kpa) && up.x_beside.unit.empty()));
  LineChart narrow = chart;
  narrow.width = 299.9;
  const LineChart both = pressures(narrow, PressureUnit::kBar);
  CHECK((both.x_label == "gauge pressure in bar" && both.y_label == "U in bar"));
  CHECK((both.series[0].x[1] == Approx(0.1 * kpa) && both.series[0].y[1] == Approx(0.02 * kpa)));
  CHECK((both.x_beside.unit.empty() && both.y_beside.unit.empty()));
  const FrameMap map = pressure_map({"m", 1, 2, {1.0, 2.0}, {0.5, 3.0}, 60.0}, PressureUnit::kKilopascal);
  CHECK((map.values[0] == Approx(kpa) && map.values[1] == Approx(2.0 * kpa)));
  CHECK((map.scale.low == Approx(0.5 * kpa) && map.scale.high == Approx(3.0 * kpa) && map.size == 60.0));
  CHECK(pressure_bar({0.5, 3.0}, "b", PressureUnit::kPsi, 2).value ==
        colour_bar(html::Text("0.50\u00A0psi (3.4\u00A0kPa)"), html::Text("3.00\u00A0psi (20.7\u00A0kPa)"), "b").value);
}

TEST_CASE("second scales by hand: ticks of twice x above the plot, of half of y at its right edge") {
  // Plot from 40.8 (28 and two letters of 6.4) to 371.6 (22 and one letter off 400), from 23 (8 and a line of 15) to
  // 200; x from 0 to 10, y from 0 to 10.3. Twice x goes to 20 in steps of 5, half of y to 5.15 in steps of 1.
  LineChart chart{"t", "x", "y", {{"", {0.0, 10.0}, {0.0, 10.0}, 0}}, 400.0, 239.0, true};
  chart.x_beside = {"u", 2.0};
  chart.y_beside = {"v", 0.5};
  CHECK(holds(line_chart(chart).value,
              R"~(<path class="axis" d="M40.8 23v4"/><text x="40.8" y="19" text-anchor="middle">0</text>)~"
              R"~(<path class="axis" d="M123.5 23v4"/><text x="123.5" y="19" text-anchor="middle">5</text>)~"
              R"~(<path class="axis" d="M206.2 23v4"/><text x="206.2" y="19" text-anchor="middle">10</text>)~"
              R"~(<path class="axis" d="M288.9 23v4"/><text x="288.9" y="19" text-anchor="middle">15</text>)~"
              R"~(<path class="axis" d="M371.6 23v4"/><text x="371.6" y="19" text-anchor="middle">20</text>)~"
              R"~(<path class="axis" d="M40.8 23H371.6"/><text x="32.8" y="19" text-anchor="end">u</text>)~"
              R"~(<path class="axis" d="M371.6 200h-4"/><text x="376.6" y="204">0</text>)~"
              R"~(<path class="axis" d="M371.6 165.6h-4"/><text x="376.6" y="169.6">1</text>)~"
              R"~(<path class="axis" d="M371.6 131.3h-4"/><text x="376.6" y="135.3">2</text>)~"
              R"~(<path class="axis" d="M371.6 96.9h-4"/><text x="376.6" y="100.9">3</text>)~"
              R"~(<path class="axis" d="M371.6 62.5h-4"/><text x="376.6" y="66.5">4</text>)~"
              R"~(<path class="axis" d="M371.6 28.2h-4"/><text x="376.6" y="32.2">5</text>)~"
              R"~(<path class="axis" d="M371.6 23V200"/>)~"
              R"~(<text transform="translate(398 111.5) rotate(-90)" text-anchor="middle">v</text>)~"));
}

TEST_CASE("axes by hand: as many ticks as the width and the height have room for") {
  // 50 in six steps are tens, in ten fives. 10.3 in four steps are fives, in six twos.
  CHECK_FALSE(holds(axis_drawn({0, 50}, {7, 8}, 449.9, 300, false), ">5</text>"));
  CHECK(holds(axis_drawn({0, 50}, {7, 8}, 450, 300, false), ">5</text>"));
  CHECK_FALSE(holds(axis_drawn({20, 30}, {0, 10}, 400, 219.9, true), ">2</text>"));
  CHECK(holds(axis_drawn({20, 30}, {0, 10}, 400, 220, true), ">2</text>"));
  // 8.056 in four steps of 5 hold one tick, which has two decimals.
  CHECK(holds(axis_drawn({20, 30}, {0.8, 8.4}, 400, 200, false), ">5.00</text>"));
}

TEST_CASE("axes by hand: an end within a fifth of a step's width moves to the round number outside it") {
  const auto has_60 = [](double high) {
    return holds(axis_drawn({0, high}, {7.1, 7.2}, 400, 300, false), ">60</text>");
  };
  CHECK(has_60(58.2));        // 1.8 of 9.70
  CHECK_FALSE(has_60(57.9));  // 2.1 of 9.65
  const auto has_0 = [](double low) { return holds(axis_drawn({low, 60}, {7.1, 7.2}, 400, 300, false), ">0</text>"); };
  CHECK(has_0(1.8));
  CHECK_FALSE(has_0(2.1));
  // Round numbers inside stay where they are: half a unit beyond 60 the axis ends at 60.5, not at 60.
  const std::string beyond = axis_drawn({0, 60.5}, {7.1, 7.2}, 400, 300, false);
  CHECK_FALSE(holds(beyond, R"(<text x="386" y="275" text-anchor="middle">60</text>)"));
}

TEST_CASE("ticks by hand: at the bounds of each step, and none beyond the range") {
  using Ticks = std::vector<double>;
  CHECK(nice_ticks(0.0, 10.0, 2) == Ticks{0, 5, 10});
  CHECK(nice_ticks(0.0, 10.0, 5) == Ticks{0, 2, 4, 6, 8, 10});
  CHECK(nice_ticks(0.0, 10.0, 10) == Ticks{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10});
  CHECK(nice_ticks(0.0, 10.1, 10) == Ticks{0, 2, 4, 6, 8, 10});
  CHECK(nice_ticks(0.0, 25.1, 5) == Ticks{0, 10, 20});
  CHECK(nice_ticks(-7.0, 12.0, 4) == Ticks{-5, 0, 5, 10});
  CHECK(nice_ticks(0.0, 10.0, 1) == Ticks{0, 10});
  CHECK(nice_ticks(3.0, 10.0, 0) == Ticks{3});
  CHECK(nice_ticks(5.0, 4.0, 6) == Ticks{5});
}

TEST_CASE("histograms by hand: of one value, of zeros, of one bin at least, with a limit that is no number") {
  const auto outline = [](double low, double width, const std::vector<double>& counts) {
    Series series{"number", {low}, {0.0}, 0, false, true};
    for (std::size_t i = 0; i < counts.size(); ++i) {
      const auto bin = static_cast<double>(i);
      series.x.insert(series.x.end(), {low + width * bin, low + width * (bin + 1.0)});
      series.y.insert(series.y.end(), {counts[i], counts[i]});
    }
    series.x.push_back(low + width * static_cast<double>(counts.size()));
    series.y.push_back(0.0);
    return line_chart({"h", "v", "n", {series}, 335.0, 220.0, true}).value;
  };
  const auto drawn = [](std::vector<double> values, int bins, std::optional<double> limit = {}) {
    return histogram_chart({"h", "v", "n", std::move(values), limit, "limit", 335.0, 220.0, bins}).value;
  };
  // Of one value the range is a tenth of it, of zero one.
  CHECK(drawn({-4.0}, 2) == outline(-4.2, 0.2, {0.0, 1.0}));
  CHECK(drawn({0.0, 0.0}, 2) == outline(-0.5, 0.5, {0.0, 2.0}));
  CHECK(drawn({1.0, 2.0, 5.0}, 4) == outline(1.0, 1.0, {1.0, 1.0, 0.0, 1.0}));
  CHECK(drawn({1.0, 2.0, 5.0}, 0) == outline(1.0, 4.0, {3.0}));
  CHECK(drawn({1.0, 2.0, 5.0}, 4, kEmptyCell) == outline(1.0, 1.0, {1.0, 1.0, 0.0, 1.0}));
  CHECK(drawn({kEmptyCell}, 4, 3.0) == line_chart({"h", "v", "n", {}, 335.0, 220.0, true}).value);
}

TEST_CASE("maps by hand: a tall array is as high as a map may be, cells without a value are crossed") {
  const std::string tall = frame_map({"m", 3, 1, {0.0, 1.0}, {0.0, 1.0}, 60.0}).value;
  CHECK(holds(tall, R"(viewBox="0 0 20 60" width="20" height="60">)"));
  CHECK(holds(tall, R"~(<g transform="scale(20)">)~"));
  CHECK(holds(tall, R"(<path fill="#ffffff" d="M0 2h1v1h-1z"/><path class="cross" d="M0.2 2.2l.6 .6m0 -.6l-.6 .6"/>)"));
  CHECK(holds(frame_map({"m", 0, 0, {}, {0.0, 1.0}, 60.0}).value, R"(viewBox="0 0 0 0")"));
  // Each of the 32 colours from its lower bound to below the next.
  for (int bin = 0; bin < 32; ++bin)
    for (const double value : {bin / 32.0, (bin + 0.999) / 32.0})
      CHECK(holds(frame_map({"m", 1, 1, {value}, {0.0, 1.0}, 60.0}).value, cividis((bin + 0.5) / 32.0)));
}

TEST_CASE("numbered maps by hand: each number can be read on its colour, and is rounded as U where it is one") {
  for (int bin = 0; bin < 32; ++bin) {
    const double value = (bin + 0.5) / 32.0, below = luminance(cividis(value));
    const std::string map = numbered_map({"m", 1, 1, {value}, {0.0, 1.0}, 60.0}, 2).value;
    INFO(bin);
    const std::string letters = holds(map, "fill=\"#ffffff\">") ? "#ffffff" : "#000000";
    const double above = luminance(letters);
    CHECK((std::max(above, below) + 0.05) / (std::min(above, below) + 0.05) >= 4.5);
  }
  CHECK(holds(numbered_map({"m", 1, 1, {0.0344}, {0.0, 1.0}, 60.0}, kTwoSignificant).value, ">0.034</text>"));
  CHECK(holds(numbered_map({"m", 1, 1, {0.0344}, {0.0, 1.0}, 60.0}, 2).value, ">0.03</text>"));
}

TEST_CASE("U by hand: decimals of two significant digits, from nine to none, and of what is no U three") {
  for (const auto& [expanded, decimals] : {std::pair{1e-12, 9},
                                           {1.2e-8, 9},
                                           {1.2e-7, 8},
                                           {0.0994, 3},
                                           {0.0996, 2},
                                           {0.5, 2},
                                           {0.994, 2},
                                           {0.996, 1},
                                           {1.0, 1},
                                           {9.94, 1},
                                           {9.96, 0},
                                           {10.0, 0},
                                           {123.0, 0},
                                           {0.0, 3},
                                           {-1.0, 3}}) {
    INFO(expanded);
    CHECK(gum_decimals(expanded) == decimals);
  }
  CHECK(gum_decimals(kEmptyCell) == 3);
  CHECK(gum_decimals(std::numeric_limits<double>::infinity()) == 3);
  CHECK(gum_uncertainty(1234.0).value == "1200");
  CHECK(gum_value(5678.0, 1234.0).value == "5700 ± 1200");
  CHECK(gum_value(56.78, 99.4).value == "57 ± 99");
  CHECK(gum_value(kEmptyCell, 106.0).value == "not available ± 110");
  CHECK(gum_pressure(0.9034, 0.13, PressureUnit::kKilopascal).value == "6.23 ± 0.90");
  CHECK(gum_pressure_value(0.9034, 0.13, PressureUnit::kKilopascal).value == "6.23\u00A0kPa (0.90\u00A0psi)");
  CHECK(gum_degrees(4.99).value == "4");
  CHECK(gum_degrees(999.9).value == "999");
  CHECK(gum_degrees(1000.0).value == "&gt; 1000");
  CHECK(gum_degrees(999999.0).value == "&gt; 1000");
  CHECK(gum_degrees(1e6).value == "∞");
  CHECK(gum_degrees(kEmptyCell).value == "not available");
}
