#include "analysis/report/page/figure.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

namespace tactbench::analysis {
namespace {

using html::Attribute;
using html::CssNumber;
using html::markup;
using html::Markup;
using html::Text;

constexpr double kLetter = 6.4;  // mean advance of an 11 px sans-serif digit, generous
constexpr double kLine = 15.0;

struct AxisRange {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  void include(double value) {
    if (!std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  // Moves an end that is close to a round number onto it: measured 0.03..59.98 psi gives an axis from 0 to 60.
  void snap(int wanted) {
    const double rough = (high - low) / wanted;
    for (double* end : {&low, &high}) {
      const auto outer = nice_ticks(low - rough, high + rough, wanted + 2);
      for (const double tick : outer) {
        const bool outside = end == &low ? tick <= low : tick >= high;
        if (outside && std::abs(tick - *end) < 0.2 * rough) *end = tick;
      }
    }
  }
  // An empty or pointlike range still needs an axis.
  void settle() {
    if (low > high) {
      low = 0.0;
      high = 1.0;
    }
    if (high - low < 1e-12 * std::max(1.0, std::abs(high))) {
      low -= 0.5;
      high += 0.5;
    }
  }
};

int decimals(const std::vector<double>& ticks) {
  if (ticks.size() < 2) return 2;
  const double step = ticks[1] - ticks[0];
  return std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 9);
}

// Letters, not bytes: continuation bytes of UTF-8 do not count.
double letters(const std::string& text) {
  return static_cast<double>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0u) != 0x80u; }));
}

const LineStyle& style_of(const Series& series) {
  return kLineStyles[static_cast<std::size_t>(std::max(0, series.style)) % std::size(kLineStyles)];
}

struct Frame {
  double left, right, top, bottom;  // of the plot
  AxisRange x, y;
  [[nodiscard]] double px(double value) const { return left + (value - x.low) / (x.high - x.low) * (right - left); }
  [[nodiscard]] double py(double value) const { return bottom - (value - y.low) / (y.high - y.low) * (bottom - top); }
};

// Steps from one rounded place to the next: half as long as places, and nothing adds up.
html::PathData path_of(const Series& series, const Frame& frame) {
  html::PathData d;
  bool pen_down = false;
  long last_x = 0, last_y = 0;
  const std::size_t n = std::min(series.x.size(), series.y.size());
  d.value.reserve(12 * n);
  for (std::size_t i = 0; i < n; ++i) {
    if (!std::isfinite(series.x[i]) || !std::isfinite(series.y[i])) {
      pen_down = false;
      continue;
    }
    const long x = std::lrint(10.0 * frame.px(series.x[i])), y = std::lrint(10.0 * frame.py(series.y[i]));
    const bool first = d.value.empty();
    d.literal(first ? "M" : pen_down && !series.points ? "l" : "m");
    d.tenths(first ? x : x - last_x, false).tenths(first ? y : y - last_y, true);
    if (series.points) d.literal("h0");  // a round cap on a line of no length is a dot
    last_x = x;
    last_y = y;
    pen_down = true;
  }
  return d;
}

Markup stroke(const LineStyle& style, bool points) {
  if (points) return markup("stroke=\"{}\" stroke-width=\"3\" stroke-linecap=\"round\"", Attribute(style.colour));
  if (*style.dashes == '\0') return markup("stroke=\"{}\" stroke-width=\"1.3\"", Attribute(style.colour));
  return markup("stroke=\"{}\" stroke-width=\"1.5\" stroke-dasharray=\"{}\"", Attribute(style.colour),
                Attribute(style.dashes));
}

// The axis' own range in the other unit.
AxisRange scaled(const AxisRange& range, const SecondScale& beside) {
  return {range.low * beside.factor, range.high * beside.factor};
}

int wanted_along(const LineChart& chart) { return chart.width < 450 ? 6 : 10; }
int wanted_up(const LineChart& chart) { return chart.height < 220 ? 4 : 6; }

// Ticks at round numbers of the other unit, above and at the right of the plot.
Markup second_scales(const Frame& frame, const LineChart& chart) {
  Markup out;
  if (const SecondScale& beside = chart.x_beside; !beside.unit.empty()) {
    const AxisRange range = scaled(frame.x, beside);
    const auto ticks = nice_ticks(range.low, range.high, wanted_along(chart));
    for (const double tick : ticks) {
      const CssNumber x(frame.px(tick / beside.factor), 1);
      out += markup("<path class=\"axis\" d=\"M{} {}v4\"/>", x, CssNumber(frame.top, 1));
      out += markup("<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>", x, CssNumber(frame.top - 4, 1),
                    html::fixed(tick, decimals(ticks)));
    }
    out += markup("<path class=\"axis\" d=\"M{} {}H{}\"/>", CssNumber(frame.left, 1), CssNumber(frame.top, 1),
                  CssNumber(frame.right, 1));
    out += markup("<text x=\"{}\" y=\"{}\" text-anchor=\"end\">{}</text>", CssNumber(frame.left - 8, 1),
                  CssNumber(frame.top - 4, 1), Text(beside.unit));
  }
  if (const SecondScale& beside = chart.y_beside; !beside.unit.empty()) {
    const AxisRange range = scaled(frame.y, beside);
    const auto ticks = nice_ticks(range.low, range.high, wanted_up(chart));
    for (const double tick : ticks) {
      const double y = frame.py(tick / beside.factor);
      out += markup("<path class=\"axis\" d=\"M{} {}h-4\"/>", CssNumber(frame.right, 1), CssNumber(y, 1));
      out += markup("<text x=\"{}\" y=\"{}\">{}</text>", CssNumber(frame.right + 5, 1), CssNumber(y + 4, 1),
                    html::fixed(tick, decimals(ticks)));
    }
    out += markup("<path class=\"axis\" d=\"M{} {}V{}\"/>", CssNumber(frame.right, 1), CssNumber(frame.top, 1),
                  CssNumber(frame.bottom, 1));
    out += markup("<text transform=\"translate({} {}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
                  CssNumber(chart.width - 2, 1), CssNumber(0.5 * (frame.top + frame.bottom), 1), Text(beside.unit));
  }
  return out;
}

Markup axes(const Frame& frame, const LineChart& chart) {
  Markup out;
  const auto x_ticks = nice_ticks(frame.x.low, frame.x.high, wanted_along(chart));
  const auto y_ticks = nice_ticks(frame.y.low, frame.y.high, wanted_up(chart));
  for (const double tick : x_ticks) {
    const CssNumber x(frame.px(tick), 1);
    out += markup("<path class=\"grid\" d=\"M{} {}V{}\"/>", x, CssNumber(frame.bottom, 1), CssNumber(frame.top, 1));
    out += markup("<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>", x, CssNumber(frame.bottom + 14, 1),
                  html::fixed(tick, decimals(x_ticks)));
  }
  for (const double tick : y_ticks) {
    const CssNumber y(frame.py(tick), 1);
    out += markup("<path class=\"grid\" d=\"M{} {}H{}\"/>", CssNumber(frame.left, 1), y, CssNumber(frame.right, 1));
    out += markup("<text x=\"{}\" y=\"{}\" text-anchor=\"end\">{}</text>", CssNumber(frame.left - 6, 1),
                  CssNumber(frame.py(tick) + 4, 1), html::fixed(tick, decimals(y_ticks)));
  }
  out += markup("<path class=\"axis\" d=\"M{} {}V{}H{}\"/>", CssNumber(frame.left, 1), CssNumber(frame.top, 1),
                CssNumber(frame.bottom, 1), CssNumber(frame.right, 1));
  out += markup("<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
                CssNumber(0.5 * (frame.left + frame.right), 1), CssNumber(frame.bottom + 30, 1), Text(chart.x_label));
  const double middle = 0.5 * (frame.top + frame.bottom);
  out += markup("<text transform=\"translate(12 {}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
                CssNumber(middle, 1), Text(chart.y_label));
  return out;
}

}  // namespace

std::vector<double> nice_ticks(double low, double high, int wanted) {
  if (!(high > low) || wanted < 1) return {low};
  const double rough = (high - low) / wanted;
  const double decade = std::pow(10.0, std::floor(std::log10(rough)));
  double step = 10.0 * decade;
  for (const double factor : {5.0, 2.0, 1.0}) {
    if (factor * decade >= rough * (1.0 - 1e-9)) step = factor * decade;
  }
  std::vector<double> ticks;
  const auto first = static_cast<long long>(std::ceil(low / step - 1e-9));
  const auto last = static_cast<long long>(std::floor(high / step + 1e-9));
  for (long long i = first; i <= last; ++i) ticks.push_back(static_cast<double>(i) * step);
  return ticks;
}

Markup line_chart(const LineChart& chart) {
  Frame frame{};
  for (const Series& series : chart.series) {
    for (const double x : series.x) frame.x.include(x);
    for (const double y : series.y) frame.y.include(y);
  }
  if (chart.y_from_zero) frame.y.include(0.0);
  frame.x.settle();
  frame.y.settle();
  frame.x.snap(wanted_along(chart));
  const double margin = 0.03 * (frame.y.high - frame.y.low);
  if (!chart.y_from_zero || frame.y.low < 0.0) frame.y.low -= margin;
  frame.y.high += margin;

  const auto width_of_ticks = [&](const AxisRange& range) {
    const auto ticks = nice_ticks(range.low, range.high, wanted_up(chart));
    double widest = 0.0;
    for (const double tick : ticks) widest = std::max(widest, letters(html::fixed(tick, decimals(ticks)).value));
    return kLetter * widest;
  };
  frame.left = 18.0 + 10.0 + width_of_ticks(frame.y);
  // Without a scale at the right half of the last tick's label.
  frame.right =
      chart.width - (chart.y_beside.unit.empty() ? 14.0 : 22.0 + width_of_ticks(scaled(frame.y, chart.y_beside)));
  frame.top = chart.x_beside.unit.empty() ? 8.0 : 8.0 + kLine;
  // Rows of the legend, laid out by estimated widths.
  struct Entry {
    double x, row;
  };
  std::vector<Entry> entries;
  double x = frame.left, row = 0.0;
  std::size_t named = 0;
  for (const Series& series : chart.series) {
    if (series.name.empty()) {
      entries.push_back({x, row});
      continue;
    }
    ++named;
    const double width = 34.0 + kLetter * letters(series.name) + 14.0;
    if (x + width > chart.width && x > frame.left) {
      x = frame.left;
      row += 1.0;
    }
    entries.push_back({x, row});
    x += width;
  }
  const double legend = named < 2 ? 0.0 : (row + 1.0) * kLine;
  frame.bottom = chart.height - 39.0 - legend;

  Markup out =
      markup("<svg role=\"img\" class=\"chart\" viewBox=\"0 0 {} {}\" width=\"{}\" height=\"{}\"><title>{}</title>",
             CssNumber(chart.width), CssNumber(chart.height), CssNumber(chart.width), CssNumber(chart.height),
             Text(chart.title));
  out += axes(frame, chart);
  out += second_scales(frame, chart);
  for (std::size_t i = 0; i < chart.series.size(); ++i) {
    const Series& series = chart.series[i];
    const Markup line = stroke(style_of(series), series.points);
    const html::PathData path = path_of(series, frame);
    if (series.filled && !path.value.empty())
      out += markup("<path fill=\"#d5dde3\" d=\"{}V{}H{}z\"/>", path, CssNumber(frame.bottom, 1),
                    CssNumber(frame.px(series.x.front()), 1));
    out += markup("<path fill=\"none\" {} d=\"", line);
    out += path;
    out += markup("\"/>");
    if (legend == 0.0 || series.name.empty()) continue;
    const double y = chart.height - legend + kLine * entries[i].row + 8.0;
    out +=
        markup("<path fill=\"none\" {} d=\"M{} {}h{}\"/>", line, CssNumber(entries[i].x + (series.points ? 14 : 0), 1),
               CssNumber(y - 4, 1), CssNumber(series.points ? 0 : 28));
    out += markup("<text x=\"{}\" y=\"{}\">{}</text>", CssNumber(entries[i].x + 34, 1), CssNumber(y, 1),
                  Text(series.name));
  }
  out += markup("</svg>");
  return out;
}

}  // namespace tactbench::analysis
