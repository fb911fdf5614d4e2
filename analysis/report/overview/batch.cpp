#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <tuple>

#include "analysis/counted.h"
#include "analysis/report/overview/overview.h"
#include "analysis/report/overview/overview_figures.h"
#include "analysis/report/page/figure.h"
#include "analysis/report/page/page.h"
#include "analysis/statistics/figures/levels.h"
#include "db/run_store.h"

namespace tactbench::analysis {

using html::markup;
using html::Markup;
using html::Text;

namespace {

struct BatchColumn {
  const OverviewFigure* figure;
  std::vector<double> values, scores;  // one a run
};

std::vector<BatchColumn> batch_columns(const std::vector<ReportInput>& runs) {
  std::vector<BatchColumn> columns;
  for (const OverviewFigure& figure : overview_figures()) {
    BatchColumn column{&figure, {}, {}};
    for (const ReportInput& run : runs) column.values.push_back(figure.value(run));
    column.scores = modified_z_scores(column.values);
    columns.push_back(std::move(column));
  }
  return columns;
}

const BatchColumn& column_named(const std::vector<BatchColumn>& columns, const std::string& key) {
  return *std::ranges::find_if(columns, [&](const BatchColumn& column) { return column.figure->key == key; });
}

// Runs that were not judged count as inconclusive.
Verdict rank_of(std::optional<Verdict> overall) {
  return states_conformity(overall) ? *overall : Verdict::kInconclusive;
}

// Passes first, fails last; among equals best first by the mean compensation error; without models by the mean
// hysteresis error; then as given.
std::vector<std::size_t> ranked(const std::vector<ReportInput>& runs, const std::vector<BatchColumn>& columns) {
  const BatchColumn &error = column_named(columns, "mean_error_psi"),
                    &hysteresis = column_named(columns, "hysteresis_mean_fs");
  std::vector<std::size_t> order(error.values.size());
  std::iota(order.begin(), order.end(), 0);
  const auto key = [&](std::size_t i) {
    const double e = error.values[i], h = hysteresis.values[i];
    return std::tuple(rank_of(runs[i].judgement.overall), !std::isfinite(e), std::isfinite(e) ? e : 0.0,
                      std::isfinite(h) ? h : 0.0);
  };
  std::ranges::stable_sort(order, {}, key);
  return order;
}

// A sensor that was not judged, though there are limits, is counted with the judged: its evidence is missing.
Markup yield_part(const std::vector<ReportInput>& sensors, const std::vector<std::string>& left_out) {
  std::map<std::string, int> words;
  int with_limits = 0, good = 0;
  for (const ReportInput& sensor : sensors) {
    const std::optional<Verdict> overall = sensor.judgement.overall;
    const bool judged = !sensor.judgement.not_judged;
    ++words[!overall ? "no verdict" : judged ? to_string(*overall) : "not judged"];
    with_limits += states_conformity(overall) ? 1 : 0;
    good += passes(overall) ? 1 : 0;
  }
  std::string list;
  for (const auto& [word, number] : words) list += fmt::format("{}{} {}", list.empty() ? "" : ", ", number, word);
  return pairs_table("Yield",
                     {{"sensors, runs named", markup("{}, {}", sensors.size(), sensors.size() + left_out.size())},
                      {"yield: pass or conditional pass",
                       with_limits == 0 ? markup("not assessed: no tolerance limits were given")
                                        : markup("{} of {}, {} %", good, Text(counted(with_limits, "sensor")),
                                                 html::percent(static_cast<double>(good) / with_limits, 1))},
                      {"verdicts", markup("{}", Text(list))},
                      {"left out: the newest run of each sensor stands for it",
                       markup("{}", Text(left_out.empty() ? "none" : fmt::format("{}", fmt::join(left_out, "; "))))}});
}

std::string outlying_figures(const std::vector<BatchColumn>& columns, std::size_t run) {
  std::string names;
  for (const BatchColumn& column : columns) {
    if (!(std::abs(column.scores[run]) > kOutlierScore)) continue;
    names += fmt::format("{}{}", names.empty() ? "" : "; ", column.figure->name);
  }
  return names;
}

Markup rank_table(const std::vector<ReportInput>& runs, const std::vector<BatchColumn>& columns) {
  static const std::vector<std::pair<const char*, const char*>> shown = {
      {"mean_error_psi", "mean |error|"},
      {"worst_taxel_mean_error_psi", "worst taxel"},
      {"comp_distance_of_mean_fs", "hysteresis of the mean, % FS"},
      {"hysteresis_max_fs", "hysteresis of the indication, max., % FS"},
      {"excluded_taxels", "excluded taxels"},
      {"retries", "retries"}};
  Markup out = markup(
      "<div class=\"wide\" tabindex=\"0\" role=\"region\" aria-label=\"Sensors ranked\"><table "
      "class=\"levels ranks\"><caption>Sensors ranked: by conformity, best first, then by the mean "
      "absolute error</caption><thead><tr>"
      "<th scope=\"col\" class=\"n\">rank</th><th scope=\"col\">sensor</th><th scope=\"col\" class=\"n\">run</th>"
      "<th scope=\"col\">date</th>");
  const PressureUnit unit = runs.front().unit;
  for (const auto& [key, title] : shown)
    out += markup("<th scope=\"col\" class=\"n\">{}{}</th>", Text(title),
                  Text(is_pressure(*column_named(columns, key).figure)
                           ? fmt::format(", {} ({})", unit.symbol(), unit.beside().symbol())
                           : ""));
  out += markup("<th scope=\"col\">conformity</th></tr></thead><tbody>\n");
  int rank = 0;
  for (const std::size_t i : ranked(runs, columns)) {
    const ReportInput& run = runs[i];
    out += markup("<tr><td class=\"n\">{}</td><th scope=\"row\">{}</th><td class=\"n\">{}</td><td>{}</td>", ++rank,
                  html::stated(run.run.sensor_serial), run.run.run, html::stated(run.run.started_utc.substr(0, 10)));
    for (const auto& [key, title] : shown) {
      const BatchColumn& column = column_named(columns, key);
      const bool outlier = std::abs(column.scores[i]) > kOutlierScore;
      const Text value = shown_figure(*column.figure, column.values[i], unit);
      out += outlier
                 ? markup("<td class=\"n\"><span class=\"doubt\"><span class=\"sign\">▲</span> {}</span></td>", value)
                 : number_cell(value);
    }
    out += markup("<td>{}</td></tr>\n", overall_cell(run, "none"));
  }
  out += markup("</tbody></table></div>\n");
  return out;
}

Markup outliers_part(const std::vector<ReportInput>& runs, const std::vector<BatchColumn>& columns) {
  Markup out = markup("<h2 id=\"outliers\">Outliers</h2>\n");
  if (runs.size() < 5) {
    out += markup("<p>not assessed: fewer than five runs.</p>\n");
    return out;
  }
  Markup list;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const std::string names = outlying_figures(columns, i);
    if (!names.empty()) list += markup("<li>{}: {}</li>\n", Text(sensor_and_run(runs[i])), Text(names));
  }
  out += list.value.empty() ? markup("<p>none</p>\n") : markup("<ul>\n{}</ul>\n", list);
  out += markup(
      "<p class=\"note\">▲ marks a figure whose modified z-score, 0.6745 (x − median) / MAD, is beyond ±{}: far from "
      "the "
      "other sensors, in either direction. Not assessed where more than half of the figures are equal.</p>\n",
      html::fixed(kOutlierScore, 1));
  return out;
}

// The part of a figure's name after the last comma: its unit.
std::string unit_words(const std::string& name) {
  const std::size_t comma = name.rfind(", ");
  return comma == std::string::npos ? name : "in " + name.substr(comma + 2);
}

Markup histograms_part(const std::vector<ReportInput>& runs, const std::vector<BatchColumn>& columns) {
  const PressureUnit unit = runs.front().unit;
  std::vector<Markup> figures;
  for (const char* key : {"mean_error_psi", "worst_taxel_mean_error_psi", "comp_distance_of_mean_fs",
                          "hysteresis_max_fs", "gain_std", "excluded_taxels"}) {
    const BatchColumn& column = column_named(columns, key);
    const OverviewFigure& figure = *column.figure;
    const std::string name = is_pressure(figure) ? fmt::format("{}, {}", figure.name, unit.symbol()) : figure.name;
    Histogram histogram{.title = fmt::format("{}, number of runs", name),
                        .x_label = unit_words(name),
                        .y_label = "runs",
                        .values = {},
                        .limit = std::nullopt,
                        .limit_name = "tolerance limit",
                        .width = 335,
                        .height = 180,
                        .bins = std::clamp(static_cast<int>(2.0 * std::sqrt(static_cast<double>(runs.size()))), 4, 24)};
    for (const double value : column.values) histogram.values.push_back(plotted_figure(figure, value, unit));
    std::set<double> limits;
    for (const ReportInput& run : runs)
      if (const double limit = limit_of(figure, run); std::isfinite(limit)) limits.insert(limit);
    if (limits.size() == 1) histogram.limit = plotted_figure(figure, *limits.begin(), unit);
    const Spread spread = spread_of(histogram.values);
    const int digits = is_pressure(figure) ? unit.digits(figure.digits) : figure.digits;
    if (spread.count == 0) continue;
    figures.push_back(
        markup("<figure>{}<figcaption>{}; {}: {} to {}, median {}.{}</figcaption></figure>\n",
               histogram_chart(histogram), Text(name), Text(counted(spread.count, "run")),
               html::fixed(spread.low, digits), html::fixed(spread.high, digits), html::fixed(spread.median, digits),
               Text(limits.size() > 1 ? " The runs were judged by several tolerance limits: none is drawn." : "")));
  }
  Markup out = markup("<div class=\"keep\"><h2 id=\"histograms\">Distributions and limits</h2>\n");
  for (std::size_t i = 0; i < figures.size(); ++i) {
    if (i % 2 == 0) out += markup("<div class=\"pair\">\n");
    out += figures[i];
    const bool last = i + 1 == figures.size();
    if (i % 2 == 1 || last) out += markup("</div>\n");
    if (i == 1 || (last && i == 0)) out += markup("</div>\n");  // the heading stays with the first two
  }
  if (figures.empty()) out += markup("<p>not available</p>\n</div>\n");
  return out;
}

}  // namespace

std::vector<std::size_t> batch_rows(const std::vector<ReportInput>& named) {
  const auto standing = [](const ReportInput& input) {
    return std::tuple(!input.run.is_void(), !input.fit.taxels.empty(), input.run.started_utc, input.run.run);
  };
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < named.size(); ++i) {
    const bool gives_way = std::ranges::any_of(named, [&](const ReportInput& other) {
      return !other.run.sensor_serial.empty() && other.run.sensor_serial == named[i].run.sensor_serial &&
             standing(other) > standing(named[i]);
    });
    if (!gives_way) rows.push_back(i);
  }
  return rows;
}

Report render_batch(const std::vector<ReportInput>& named) {
  std::vector<ReportInput> runs;
  std::vector<std::string> left_out;
  const std::vector<std::size_t> rows = batch_rows(named);
  for (std::size_t i = 0; i < named.size(); ++i) {
    if (std::ranges::find(rows, i) != rows.end())
      runs.push_back(named[i]);
    else
      left_out.push_back(sensor_and_run(named[i]));
  }
  const std::vector<BatchColumn> columns = batch_columns(runs);
  Report report;
  std::string content, numbers;
  for (const ReportInput& run : runs) {
    content += fmt::format("{}{}", content.empty() ? "" : ",\n", content_of_run(run));
    numbers += fmt::format("{}{}", numbers.empty() ? "" : ",", run.run.run);
  }
  report.content_sha256 = db::sha256_hex(content);
  report.number = report.content_sha256.substr(0, 8);
  report.json =
      fmt::format("{{\"schema\":\"tactbench.batch\",\"version\":2,\"number\":\"{}\",\"runs\":[{}],\n\"content\":[{}]}}",
                  report.number, numbers, content);
  Page page;
  page.document = "Batch of sensors";
  page.number = report.number;
  page.simulated = std::ranges::any_of(runs, [](const ReportInput& run) { return is_simulated(run); });
  page.paper = runs.front().paper;
  page.opening = markup("<p>{}, {} named. Not a calibration report: each run has its own.</p>\n",
                        Text(counted(runs.size(), "sensor")), Text(counted(named.size(), "run")));
  page.main.push_back(markup("<h2 id=\"yield\">Yield and ranks</h2>\n"));
  page.main.push_back(yield_part(runs, left_out));
  page.main.push_back(rank_table(runs, columns));
  page.main.push_back(outliers_part(runs, columns));
  page.main.push_back(histograms_part(runs, columns));
  page.main.push_back(loops_overlaid(runs));
  page.json = report.json;
  report.html = page_of(page);
  return report;
}

}  // namespace tactbench::analysis
