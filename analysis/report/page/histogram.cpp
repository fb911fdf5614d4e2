#include <algorithm>
#include <cmath>

#include "analysis/report/page/figure.h"

namespace tactbench::analysis {

namespace {

constexpr double kFarthestLimit = 2.0;  // spans of the values: farther away, its line would squeeze them to nothing

}  // namespace

html::Markup histogram_chart(const Histogram& histogram) {
  std::vector<double> values = histogram.values;
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  LineChart chart{.title = histogram.title,
                  .x_label = histogram.x_label,
                  .y_label = histogram.y_label,
                  .series = {},
                  .width = histogram.width,
                  .height = histogram.height,
                  .y_from_zero = true};
  if (values.empty()) return line_chart(chart);
  const auto [least, most] = std::ranges::minmax(values);
  const double span = most > least ? most - least : most != 0.0 ? 0.1 * std::abs(most) : 1.0;
  const double low = most > least ? least : least - 0.5 * span;
  const int bins = std::max(1, histogram.bins);
  std::vector<double> counts(static_cast<std::size_t>(bins), 0.0);
  for (const double value : values) {
    const int bin = static_cast<int>((value - low) / span * bins);
    counts[static_cast<std::size_t>(std::clamp(bin, 0, bins - 1))] += 1.0;
  }
  Series outline{.name = "number", .x = {low}, .y = {0.0}, .style = 0, .points = false, .filled = true};
  for (int bin = 0; bin < bins; ++bin) {
    for (const int edge : {bin, bin + 1}) {
      outline.x.push_back(low + span * edge / bins);
      outline.y.push_back(counts[static_cast<std::size_t>(bin)]);
    }
  }
  outline.x.push_back(low + span);
  outline.y.push_back(0.0);
  chart.series.push_back(std::move(outline));
  if (!histogram.limit || !std::isfinite(*histogram.limit)) return line_chart(chart);
  const double limit = *histogram.limit;
  if (limit < low - kFarthestLimit * span || limit > low + span + kFarthestLimit * span) {
    chart.x_label += fmt::format(" ({} {}: beyond this axis)", histogram.limit_name, html::significant(limit, 4).value);
    return line_chart(chart);
  }
  chart.series.push_back({.name = histogram.limit_name,
                          .x = {limit, limit},
                          .y = {0.0, *std::ranges::max_element(counts)},
                          .style = 1,
                          .points = false,
                          .filled = false});
  return line_chart(chart);
}

}  // namespace tactbench::analysis
