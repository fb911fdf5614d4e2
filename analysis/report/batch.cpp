#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "analysis/report/figure.h"
#include "analysis/report/overview.h"
#include "analysis/report/overview_parts.h"
#include "analysis/report/shell.h"
#include "analysis/statistics/levels.h"
#include "db/run_store.h"

namespace tactbench::analysis {

using html::markup;
using html::Markup;
using html::Text;

namespace {

constexpr std::size_t kMostNamedLoops = 5;  // as there are line styles

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

// Best first by the mean compensation error; without models by the mean hysteresis error; then as given.
std::vector<std::size_t> ranked(const std::vector<BatchColumn>& columns) {
  const BatchColumn &error = column_named(columns, "mean_error_psi"),
                    &hysteresis = column_named(columns, "hysteresis_mean_fs");
  std::vector<std::size_t> order(error.values.size());
  std::iota(order.begin(), order.end(), 0);
  const auto key = [&](std::size_t i) {
    const double e = error.values[i], h = hysteresis.values[i];
    return std::tuple(!std::isfinite(e), std::isfinite(e) ? e : 0.0, std::isfinite(h) ? h : 0.0);
  };
  std::ranges::stable_sort(order, {}, key);
  return order;
}

bool may_leave(const std::string& overall) { return overall == "pass" || overall == "conditional pass"; }

Markup yield_part(const std::vector<ReportInput>& runs) {
  std::map<std::string, int> words;
  std::set<std::string> sensors;
  int judged_runs = 0, good = 0;
  for (const ReportInput& run : runs) {
    sensors.insert(run.run.sensor_serial);
    const std::string overall = overall_verdict(run.verdicts);
    ++words[overall.empty() ? "no verdict" : overall];
    judged_runs += overall.empty() ? 0 : 1;
    good += may_leave(overall) ? 1 : 0;
  }
  std::string list;
  for (const auto& [word, number] : words) list += fmt::format("{}{} {}", list.empty() ? "" : ", ", number, word);
  return pairs_table("Yield", {{"runs, sensors", markup("{}, {}", runs.size(), sensors.size())},
                               {"yield: pass or conditional pass",
                                judged_runs == 0 ? markup("not assessed: no limits were given")
                                                 : markup("{} of {} judged, {} %", good, judged_runs,
                                                          html::percent(static_cast<double>(good) / judged_runs, 1))},
                               {"verdicts", markup("{}", Text(list))}});
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
      {"mean_error_psi", "mean error, psi"},
      {"worst_taxel_mean_error_psi", "worst taxel, psi"},
      {"comp_distance_of_mean_fs", "|up − down| of mean, % FS"},
      {"hysteresis_max_fs", "raw hysteresis max., % FS"},
      {"excluded_taxels", "taxels left out"},
      {"retries", "retries"}};
  Markup out = markup(
      "<div class=\"wide\" tabindex=\"0\" role=\"region\" aria-label=\"Sensors ranked\"><table "
      "class=\"levels ranks\"><caption>Sensors ranked, best first, by the mean error after "
      "compensation</caption><thead><tr>"
      "<th scope=\"col\" class=\"n\">rank</th><th scope=\"col\">sensor</th><th scope=\"col\" class=\"n\">run</th>"
      "<th scope=\"col\">date</th>");
  for (const auto& [key, title] : shown) out += markup("<th scope=\"col\" class=\"n\">{}</th>", Text(title));
  out += markup("<th scope=\"col\">verdict</th></tr></thead><tbody>\n");
  int rank = 0;
  for (const std::size_t i : ranked(columns)) {
    const ReportInput& run = runs[i];
    out += markup("<tr><td class=\"n\">{}</td><th scope=\"row\">{}</th><td class=\"n\">{}</td><td>{}</td>", ++rank,
                  html::stated(run.run.sensor_serial), run.run.run, html::stated(run.run.started_utc.substr(0, 10)));
    for (const auto& [key, title] : shown) {
      const BatchColumn& column = column_named(columns, key);
      const bool outlier = std::abs(column.scores[i]) > kOutlierScore;
      const Text value = shown_figure(*column.figure, column.values[i]);
      out += outlier
                 ? markup("<td class=\"n\"><span class=\"doubt\"><span class=\"sign\">▲</span> {}</span></td>", value)
                 : number_cell(value);
    }
    const std::string overall = overall_verdict(run.verdicts);
    out += markup("<td>{}</td></tr>\n", overall.empty() ? markup("none") : verdict_mark(overall, is_simulated(run)));
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

// What stands after the last comma of a figure's name.
std::string unit_words(const std::string& name) {
  const std::size_t comma = name.rfind(", ");
  return comma == std::string::npos ? name : "in " + name.substr(comma + 2);
}

Markup histograms_part(const std::vector<ReportInput>& runs, const std::vector<BatchColumn>& columns) {
  std::vector<Markup> figures;
  for (const char* key : {"mean_error_psi", "worst_taxel_mean_error_psi", "comp_distance_of_mean_fs",
                          "hysteresis_max_fs", "gain_std", "excluded_taxels"}) {
    const BatchColumn& column = column_named(columns, key);
    const OverviewFigure& figure = *column.figure;
    Histogram histogram{.title = fmt::format("{}, number of runs", figure.name),
                        .x_label = unit_words(figure.name),
                        .y_label = "runs",
                        .values = {},
                        .limit = std::nullopt,
                        .limit_name = "limit",
                        .width = 335,
                        .height = 180,
                        .bins = std::clamp(static_cast<int>(2.0 * std::sqrt(static_cast<double>(runs.size()))), 4, 24)};
    for (const double value : column.values) histogram.values.push_back(figure.factor * value);
    std::set<double> limits;
    for (const ReportInput& run : runs)
      if (const double limit = limit_of(figure, run); std::isfinite(limit)) limits.insert(limit);
    if (limits.size() == 1) histogram.limit = figure.factor * *limits.begin();
    const Spread spread = spread_of(histogram.values);
    if (spread.count == 0) continue;
    figures.push_back(markup("<figure>{}<figcaption>{}; {} runs: {} to {}, median {}.{}</figcaption></figure>\n",
                             histogram_chart(histogram), Text(figure.name), spread.count,
                             html::fixed(spread.low, figure.digits), html::fixed(spread.high, figure.digits),
                             html::fixed(spread.median, figure.digits),
                             Text(limits.size() > 1 ? " The runs were judged by several limits: none is drawn." : "")));
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

Markup loops_overlaid(const std::vector<ReportInput>& runs) {
  LineChart chart{.title = "Mean external loops of all runs before compensation",
                  .x_label = "pressure in psi",
                  .y_label = "output in V",
                  .series = {},
                  .width = 682,
                  .height = 270};
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
  out += markup("<figure>{}<figcaption>External loops of the mean taxels, {} runs.</figcaption></figure>\n",
                line_chart(chart), chart.series.size());
  return out;
}

}  // namespace

Report render_batch(const std::vector<ReportInput>& runs) {
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
      fmt::format("{{\"schema\":\"tactbench.batch\",\"version\":1,\"number\":\"{}\",\"runs\":[{}],\n\"content\":[{}]}}",
                  report.number, numbers, content);
  Shell shell;
  shell.document = "Batch of sensors";
  shell.number = report.number;
  shell.simulated = std::ranges::any_of(runs, [](const ReportInput& run) { return is_simulated(run); });
  shell.paper = runs.front().paper;
  shell.opening = markup("<p>{} runs. Not a calibration report: each run has its own.</p>\n", runs.size());
  shell.main.push_back(markup("<h2 id=\"yield\">Yield and ranks</h2>\n"));
  shell.main.push_back(yield_part(runs));
  shell.main.push_back(rank_table(runs, columns));
  shell.main.push_back(outliers_part(runs, columns));
  shell.main.push_back(histograms_part(runs, columns));
  shell.main.push_back(loops_overlaid(runs));
  shell.json = report.json;
  report.html = page_of(shell);
  return report;
}

}  // namespace tactbench::analysis
