#include <algorithm>
#include <cmath>

#include "analysis/counted.h"
#include "analysis/report/page/figure.h"
#include "analysis/report/parts.h"
#include "analysis/report/sections/sections.h"

namespace tactbench::analysis {

using html::markup;
using html::Markup;
using html::Text;

namespace {

Markup not_assessed(const std::string& reason) { return markup("<p>not assessed: {}.</p>\n", Text(reason)); }

Markup zone_row(const char* name, const CrosstalkZone& zone) {
  return markup("<tr><th scope=\"row\">{}</th>{}{}{}<td class=\"n\">{}</td></tr>\n", Text(name),
                number_cell(html::percent(zone.mean_share, 3)), number_cell(html::percent(zone.u_share, 3)),
                number_cell(html::percent(zone.max_share, 3)), zone.samples);
}

Markup ghost_line(const char* what, const std::vector<CrosstalkLine>& lines) {
  if (lines.empty()) return markup("<li>No ghost {} were found.</li>\n", Text(what));
  Markup list;
  for (const CrosstalkLine& line : lines)
    list += markup("{}{} ({} %)", Text(list.value.empty() ? "" : ", "), line.line, html::percent(line.mean_share, 2));
  return markup("<li><span class=\"doubt\"><span class=\"sign\">▲</span> Ghost {}</span>: {}.</li>\n", Text(what),
                list);
}

Markup crosstalk_part(const Crosstalk& crosstalk) {
  Markup out = markup("<h3>Crosstalk</h3>\n");
  if (!crosstalk.assessed()) {
    out += not_assessed(crosstalk.not_assessed);
    return out;
  }
  out += markup(
      "<p>Run {}: a point indenter at {}, {} N. Output of taxels that nothing presses (more than {} pitches "
      "from the print’s centre along rows or columns), over their own zero, as a share of the highest output of the "
      "frame.</p>\n",
      crosstalk.run, Text(counted(crosstalk.positions, "position")), html::fixed(crosstalk.force_n, 2),
      html::fixed(crosstalk.reach_pitches, 0));
  out += markup(
      "<table><caption>Output of unloaded taxels over the loaded one, %</caption><thead><tr><th "
      "scope=\"col\">where</th>"
      "<th scope=\"col\" class=\"n\">mean</th><th scope=\"col\" class=\"n\">standard deviation of the mean</th>"
      "<th scope=\"col\" class=\"n\">highest</th><th scope=\"col\" class=\"n\">samples</th></tr></thead><tbody>\n");
  out += zone_row("in a loaded row", crosstalk.row);
  out += zone_row("in a loaded column", crosstalk.column);
  out += zone_row("elsewhere", crosstalk.elsewhere);
  out += markup("</tbody></table>\n<ul>\n");
  out += ghost_line("rows", crosstalk.ghost_rows);
  out += ghost_line("columns", crosstalk.ghost_columns);
  out += markup("</ul>\n");
  std::vector<double> row, column, distance;
  for (std::size_t i = 0; i < crosstalk.distance_pitches.size(); ++i) {
    if (crosstalk.distance_pitches[i] < 2.0) continue;  // the print itself would set the scale
    distance.push_back(crosstalk.distance_pitches[i]);
    row.push_back(100.0 * crosstalk.along_row_share[i]);
    column.push_back(100.0 * crosstalk.along_column_share[i]);
  }
  out +=
      markup("<figure>{}<figcaption>Mean output over the distance from the print’s centre.</figcaption></figure>\n",
             line_chart({.title = "Output of unloaded taxels along the loaded rows and columns over distance",
                         .x_label = "distance in pitches",
                         .y_label = "output, % of highest",
                         .series = {{"along the rows", distance, row, 1}, {"along the columns", distance, column, 2}},
                         .width = 682,
                         .height = 200,
                         .y_from_zero = true}));
  out += markup(
      "<p class=\"note\">Zero of a taxel: the lower quartile of its outputs over all positions. A line is a ghost "
      "where "
      "its unloaded taxels show more than elsewhere by {} % and by three standard deviations. What a taxel remembers "
      "of "
      "an earlier press is contained.</p>\n",
      html::percent(kGhostShare, 1));
  return out;
}

// `factor`: from the bins' unit to that of the heading.
Markup bins_rows(const std::vector<Bin>& bins, double factor, PressureUnit unit) {
  Markup out;
  for (const Bin& bin : bins)
    out += markup("<tr><th scope=\"row\">{} to {}</th><td class=\"n\">{}</td>{}{}</tr>\n",
                  html::significant(factor * bin.low, 3), html::significant(factor * bin.high, 3), bin.error.samples,
                  number_cell(html::pressure(bin.error.mean(), unit, 3)),
                  number_cell(html::pressure(bin.error.max, unit, 2)));
  return out;
}

Markup bins_table(const char* caption, const std::string& head, const std::vector<Bin>& bins, double factor,
                  PressureUnit unit) {
  if (bins.empty()) return markup("");
  return markup(
      "<table><caption>{}</caption><thead><tr><th scope=\"col\">{}</th><th scope=\"col\" class=\"n\">samples</th>"
      "<th scope=\"col\" class=\"n\">mean |error|</th><th scope=\"col\" class=\"n\">maximum "
      "|error|</th></tr></thead><tbody>\n{}"
      "</tbody></table>\n",
      Text(caption), Text(head), bins_rows(bins, factor, unit));
}

Series bins_series(const std::string& name, const std::vector<Bin>& bins, double factor, int style) {
  Series series{name, {}, {}, style};
  for (const Bin& bin : bins) {
    series.x.push_back(std::log10(factor * std::sqrt(bin.low * bin.high)));
    series.y.push_back(bin.error.mean());
  }
  return series;
}

Markup rate_hold_part(const RateHold& study, PressureUnit unit) {
  Markup out = markup("<h3>Rate and hold</h3>\n");
  if (!study.assessed()) {
    out += not_assessed(study.not_assessed);
    return out;
  }
  LineChart hold{.title = "Mean absolute error of the corrected indication over the time that a level was held",
                 .x_label = "log10 of the hold in s",
                 .y_label = "mean |error|",
                 .series = {},
                 .width = 335,
                 .height = 245,
                 .y_from_zero = true};
  LineChart rate = hold;
  rate.title = "Mean absolute error of the corrected indication over the rate of the pressure";
  const double per_second = unit.of(1.0);
  rate.x_label = fmt::format("log10 of the rate in {}/s", unit.symbol());
  Markup tables;
  int style = 1;
  for (const RateHoldRun& run : study.runs) {
    const std::string name = fmt::format("{}, run {}", run.sequence, run.run);
    if (run.by_hold.size() > 1) hold.series.push_back(bins_series(name, run.by_hold, 1.0, style));
    if (run.by_rate.size() > 1) rate.series.push_back(bins_series(name, run.by_rate, per_second, style));
    ++style;
    tables += markup("<h4>Sequence {}, run {}</h4>\n<p>Mean absolute error {}, maximum {}, over {}.</p>\n",
                     html::stated(run.sequence), run.run, html::pressure(run.error.mean(), unit, 3),
                     html::pressure(run.error.max, unit, 2), Text(counted(run.error.samples, "sample")));
    if (run.output_max_share > 0.0)
      tables += markup(
          "<p>Between its repeats of different pace the mean output differs from that of the slowest by up to {} % FS, "
          "{} "
          "% FS on average.</p>\n",
          html::percent(run.output_max_share, 2), html::percent(run.output_mean_share, 2));
    tables += bins_table("Error by hold", "held, s", run.by_hold, 1.0, unit);
    tables += bins_table("Error by rate", fmt::format("rate, {}/s", unit.symbol()), run.by_rate, per_second, unit);
  }
  if (!hold.series.empty() || !rate.series.empty()) {
    out += markup("<div class=\"pair\">\n");
    for (const auto& [chart, caption] :
         {std::pair{&hold, "Error against hold."}, std::pair{&rate, "Error against rate."}})
      if (!chart->series.empty())
        out += markup("<figure>{}<figcaption>{}</figcaption></figure>\n", line_chart(pressure_up(*chart, unit)),
                      Text(caption));
    out += markup("</div>\n");
  }
  out += tables;
  out += markup(
      "<p class=\"note\">The models are rate-independent: what grows with rate or hold here is outside them. Hold: "
      "time "
      "since the level was commanded; rate: of the reference from frame to frame, where the level changed. Bins in "
      "steps of 1, 2, 5.</p>\n");
  return out;
}

}  // namespace

Markup studies_section(const ReportInput& input) {
  const Studies& studies = input.more.studies;
  Markup out = section_start("studies", "Crosstalk, rate and hold, mounting, uniformity of the pressure");
  out += crosstalk_part(studies.crosstalk);
  out += rate_hold_part(studies.rate_hold, input.unit);
  out += remount_part(studies.remount, input.fit.rows, input.fit.columns, input.unit);
  out += uniformity_part(studies.uniformity, input.fit.rows, input.fit.columns, input.unit);
  return out;
}

}  // namespace tactbench::analysis
