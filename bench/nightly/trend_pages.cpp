#include "bench/nightly/trend_pages.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/counted.h"
#include "analysis/report/page/html.h"
#include "analysis/report/page/page.h"
#include "bench/nightly/night_store.h"

namespace tactbench::bench {
namespace {

using analysis::html::Attribute;
using analysis::html::CssNumber;
using analysis::html::markup;
using analysis::html::Markup;
using analysis::html::significant;
using analysis::html::Text;

constexpr double kPlotWidth = 170.0, kPlotHeight = 30.0;
constexpr std::size_t kPlotRuns = 60;  // the newest

constexpr char kOwnRules[] = R"(
header, main, footer { max-width: 1000px; }
td.state { white-space: nowrap; }
table.figures td, table.figures th { font-size: 11px; vertical-align: middle; }
.band { fill: #dfe9ef; } .line { stroke: #00507d; stroke-width: 1.2; fill: none; }
.dot { fill: #00507d; } .out { fill: #aa1111; }
)";

// The newest values, the baseline's band behind them, the last one as a dot. Values beyond the scale are drawn at its
// edge.
Markup small_plot(const TrendFigure& figure) {
  const std::size_t count = std::min(kPlotRuns, figure.values.size());
  const std::vector<double> shown(figure.values.end() - static_cast<std::ptrdiff_t>(count), figure.values.end());
  const FigureScale scale = scale_of(figure);
  const auto y = [&](double value) {
    const double share = std::clamp((value - scale.low) / (scale.high - scale.low), 0.0, 1.0);
    return CssNumber(3.0 + (kPlotHeight - 6.0) * (1.0 - share));
  };
  const auto x = [&](std::size_t i) {
    return CssNumber(count > 1 ? 4.0 + (kPlotWidth - 8.0) * static_cast<double>(i) / static_cast<double>(count - 1)
                               : 0.5 * kPlotWidth);
  };
  Markup plot = markup("<svg width=\"{}\" height=\"{}\" role=\"img\"><title>{} over the last {}, {} to {}</title>",
                       CssNumber(kPlotWidth), CssNumber(kPlotHeight), Text(display_text(figure.name).text()),
                       Text(analysis::counted(count, "run")), significant(*std::ranges::min_element(shown), 4),
                       significant(*std::ranges::max_element(shown), 4));
  if (figure.chart.band)
    plot += markup("<path class=\"band\" d=\"M0 {0}H{2}V{1}H0Z\"/>", y(figure.chart.band->high),
                   y(figure.chart.band->low), CssNumber(kPlotWidth));
  plot += markup("<path class=\"line\" d=\"");
  for (std::size_t i = 0; i < count; ++i) plot += markup("{}{} {}", Text(i == 0 ? "M" : "L"), x(i), y(shown[i]));
  plot += markup("\"/><circle class=\"{}\" cx=\"{}\" cy=\"{}\" r=\"2.5\"/></svg>",
                 Attribute(figure.outside || figure.outlier ? "out" : "dot"), x(count - 1), y(shown.back()));
  return plot;
}

Markup figure_state(const TrendFigure& figure) {
  if (figure.missing) return markup("<span class=\"bad\"><span class=\"sign\">✗</span> missing</span>");
  if (figure.outside) return markup("<span class=\"bad\"><span class=\"sign\">✗</span> outside</span>");
  if (figure.shifted) return markup("<span class=\"doubt\"><span class=\"sign\">▲</span> shifted</span>");
  if (figure.outlier) return markup("<span class=\"doubt\"><span class=\"sign\">▲</span> unlike other sensors</span>");
  if (!figure.chart.band) return markup("no baseline");
  return markup("<span class=\"good\"><span class=\"sign\">✓</span> within</span>");
}

std::string followed_baseline(const SubjectTrend& followed) {
  if (!followed.baseline) return {};
  const db::BaselineRecord& own = *followed.baseline;
  std::string text =
      fmt::format(": baseline of {}, {}, accepted by {} on {}", analysis::counted(own.runs.size(), "run"), own.reason,
                  own.accepted_by, own.accepted_utc);
  if (const std::string too_short = short_baseline(followed); !too_short.empty()) text += "; " + too_short;
  if (followed.same_seeds != 0)
    text += fmt::format("; run {} has the seeds of run {}: no moving average", followed.run, followed.same_seeds);
  return text;
}

Markup figures_of_subject(const SubjectTrend& followed) {
  Markup out = markup(
      "<div class=\"wide\"><table class=\"figures\"><caption>{}{}</caption><thead><tr><th>figure</th><th "
      "class=\"n\">former</th><th class=\"n\">newest</th><th "
      "class=\"n\">baseline</th><th>runs</th><th></th></tr></thead><tbody>\n",
      Text(followed.subject), Text(followed_baseline(followed)));
  for (const TrendFigure& figure : followed.figures) {
    out += markup("<tr><th scope=\"row\">{}</th><td class=\"n\">{}</td><td class=\"n\">{}</td><td class=\"n\">",
                  Text(display_text(figure.name).text()),
                  figure.values.size() > 1 ? significant(figure.former(), 4) : Text("–"),
                  significant(figure.values.back(), 4));
    if (figure.chart.band)
      out += markup("{}; {} to {}", significant(figure.chart.band->mean, 5), significant(figure.chart.band->low, 4),
                    significant(figure.chart.band->high, 4));
    else
      out += markup("–");
    out += markup("</td><td>{}</td><td class=\"state\">{}</td></tr>\n", small_plot(figure), figure_state(figure));
  }
  out += markup("</tbody></table></div>\n");
  return out;
}

Markup page_start(const std::string& title, bool simulated) {
  Markup page = markup(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n<meta "
      "http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'\"/>\n<meta "
      "name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n<title>{}</title>\n<style>",
      Text(title));
  page += analysis::plain_style_sheet();
  page += Markup::literal(kOwnRules);
  page += markup("</style>\n</head>\n<body>\n");
  if (simulated) page += markup("<div class=\"banner\" role=\"note\">SIMULATED – made on simulated devices</div>\n");
  page += markup("<header>\n<h1>{}</h1>\n", Text(title));
  return page;
}

constexpr const char* kBandNote =
    "Plots span three times the baseline's band; without a baseline they begin at 0. Band, for gross changes: "
    "prediction interval for one further run of the baseline's kind, from the spread of the "
    "accepted runs; one value of a sound figure in 100 000 falls outside. Of a maximum it is taken on the logarithm, "
    "of a constant it has no width. Shifted: the moving average (EWMA) of the runs since the baseline has left the "
    "baseline's mean; of the figures reported so in the 60 runs after a baseline at most 5 % are false on average "
    "(Benjamini-Hochberg).";

Markup result_row(const ScenarioResult& result) {
  Markup row = markup("<tr><th scope=\"row\">{}</th><td class=\"state\">", Text(result.name));
  if (!result.wrong.empty())
    row += markup("<span class=\"bad\"><span class=\"sign\">✗</span> red</span>");
  else if (!result.remarks.empty())
    row += markup("<span class=\"doubt\"><span class=\"sign\">▲</span> moved</span>");
  else
    row += markup("<span class=\"good\"><span class=\"sign\">✓</span> green</span>");
  row += markup("</td><td class=\"n\">{}</td><td>{}</td><td>{}", analysis::html::fixed(result.seconds, 1),
                Text(result.compared), Text(result.about));
  for (const std::string& line : result.wrong) row += markup("<br/><span class=\"bad\">{}</span>", Text(line));
  for (const std::string& line : result.remarks) row += markup("<br/><span class=\"doubt\">{}</span>", Text(line));
  row += markup("</td></tr>\n");
  return row;
}

}  // namespace

std::string night_page(const Suite& suite, const NightPage& night) {
  const auto red = std::ranges::count_if(night.results, [](const ScenarioResult& r) { return !r.wrong.empty(); });
  Markup page = page_start(fmt::format("Night of {}: suite {}", night.begun_utc, suite.name), true);
  page += markup("<p>{}, {} red, {} not run. {}</p>\n</header>\n<main>\n",
                 Text(analysis::counted(suite.scenarios.size(), "scenario")), red,
                 suite.scenarios.size() - night.results.size(), Text(night.program));
  page += markup(
      "<h2>Scenarios</h2>\n<div class=\"wide\"><table><thead><tr><th>scenario</th><th></th><th "
      "class=\"n\">s</th><th>the run</th><th>subject, and what was wrong</th></tr></thead><tbody>\n");
  for (const bool wrong : {true, false})  // red ones first
    for (const ScenarioResult& result : night.results)
      if (result.wrong.empty() != wrong) page += result_row(result);
  for (const Scenario& scenario : suite.scenarios)
    if (std::ranges::find(night.results, scenario.label, &ScenarioResult::name) == night.results.end())
      page += markup(
          "<tr><th scope=\"row\">{}</th><td class=\"state fail\">✗ not run</td><td></td><td></td><td>{}</td>"
          "</tr>\n",
          Text(scenario.label), Text(scenario.about));
  page += markup("</tbody></table></div>\n");
  if (!night.followed.empty()) {
    page += markup("<h2>Figures over the nights</h2>\n<p class=\"note\">{}</p>\n", Text(kBandNote));
    for (const SubjectTrend& followed : night.followed) page += figures_of_subject(followed);
  }
  page += markup("</main>\n</body>\n</html>\n");
  return page.value;
}

std::string trend_page(const std::string& title, const std::string& origin, const std::vector<SubjectTrend>& followed) {
  Markup page = page_start(title, origin == "simulated");
  page += markup("<p class=\"note\">{}</p>\n</header>\n<main>\n", Text(kBandNote));
  for (const SubjectTrend& subject : followed) page += figures_of_subject(subject);
  page += markup("</main>\n</body>\n</html>\n");
  return page.value;
}

}  // namespace tactbench::bench
