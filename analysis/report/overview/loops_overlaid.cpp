// The mean loops of several runs in one chart.
#include "analysis/counted.h"
#include "analysis/report/overview/overview_figures.h"
#include "analysis/report/page/chart.h"

namespace tactbench::analysis {

namespace {

constexpr std::size_t kMostNamedLoops = std::size(kStrokes);

}  // namespace

doc::Document loops_overlaid(const std::vector<const ReportInput*>& runs) {
  const PressureUnit unit = runs.front()->unit;
  const bool named = runs.size() <= kMostNamedLoops;
  Chart chart{.title = "Mean loops before correction of all runs",
              .width = 676.0,
              .height = 240.0,
              .x = {fmt::format("gauge pressure in {}", unit.symbol())},
              .y = {"output in V"},
              .labels_at_ends = named};
  for (const ReportInput* run : runs) {
    const Behaviour& b = run->behaviour;
    if (b.loops.empty()) continue;
    const RawLoop& loop = b.loops.front();
    Curve curve{named ? sensor_and_run(*run) : "", {}, {}, named ? kStrokes[chart.curves.size()] : kBlack};
    const std::size_t n = b.pressure_psi.size();
    for (std::size_t i = 0; i < 2 * n; ++i) {  // down, then up, which ends at the right
      const std::size_t at = i < n ? n - 1 - i : i - n;
      curve.x.push_back(unit.of(b.pressure_psi[at]));
      curve.y.push_back(i < n ? loop.down_v[at] : loop.up_v[at]);
    }
    chart.curves.push_back(std::move(curve));
  }
  doc::Document out;
  out.add(doc::Heading{2, "Mean loops", "loops"});
  if (chart.curves.empty())
    out.add(doc::Paragraph{{"not available"}});
  else
    out.add(doc::Figure{chart_svg(chart),
                        chart.title,
                        {"Loops of the mean taxels before correction, ", counted(chart.curves.size(), "run"), "."}});
  return out;
}

}  // namespace tactbench::analysis
