// The mean loops of the runs of a batch in one chart.
#include "analysis/counted.h"
#include "analysis/report/overview/overview_figures.h"
#include "analysis/report/page/figure.h"

namespace tactbench::analysis {

using html::markup;
using html::Markup;
using html::Text;

namespace {

constexpr std::size_t kMostNamedLoops = 5;  // as there are line styles

}  // namespace

Markup loops_overlaid(const std::vector<ReportInput>& runs) {
  LineChart chart{.title = "Mean external loops of the indication of all runs",
                  .x_label = "gauge pressure",
                  .y_label = "output in V",
                  .series = {},
                  .width = 682,
                  .height = 285};
  const bool named = runs.size() <= kMostNamedLoops;
  for (const ReportInput& run : runs) {
    const Behaviour& b = run.behaviour;
    if (b.loops.empty()) continue;
    const RawLoop& loop = b.loops.front();
    Series series{.name = named ? sensor_and_run(run) : std::string(),
                  .x = b.pressure_psi,
                  .y = loop.up_v,
                  .style = named ? static_cast<int>(chart.series.size()) : 0};
    series.x.insert(series.x.end(), b.pressure_psi.rbegin(), b.pressure_psi.rend());
    series.y.insert(series.y.end(), loop.down_v.rbegin(), loop.down_v.rend());
    chart.series.push_back(std::move(series));
  }
  Markup out = markup("<h2 id=\"loops\">Mean loops</h2>\n");
  if (chart.series.empty()) {
    out += markup("<p>not available</p>\n");
    return out;
  }
  out += markup("<figure>{}<figcaption>External loops of the mean taxels, {}.</figcaption></figure>\n",
                line_chart(pressure_along(chart, runs.front().unit)), Text(counted(chart.series.size(), "run")));
  return out;
}

}  // namespace tactbench::analysis
