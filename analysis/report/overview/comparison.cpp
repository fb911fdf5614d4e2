#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "analysis/report/data/data.h"
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

bool same_sensor(const ReportInput& a, const ReportInput& b) {
  return !a.run.sensor_serial.empty() && a.run.sensor_serial == b.run.sensor_serial;
}

Markup compared_row(const char* name, const html::Safe& a, const html::Safe& b) {
  return markup("<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td></tr>\n", Text(name), a, b);
}

std::string sequences_of(const db::RunRecord& run) {
  std::string names;
  for (const db::SequenceRecord& sequence : run.sequences)
    names += fmt::format("{}{} ({} ×)", names.empty() ? "" : ", ", sequence.name, sequence.repeats);
  return names;
}

Markup who_table(const ReportInput& a, const ReportInput& b) {
  Markup out = markup(
      "<table><caption>The two runs</caption><thead><tr><td></td><th scope=\"col\">first</th><th "
      "scope=\"col\">second</th>"
      "</tr></thead><tbody>\n");
  const auto both = [&](const char* name, auto field) { out += compared_row(name, field(a), field(b)); };
  both("run", [](const ReportInput& i) { return markup("{}", i.run.run); });
  both("sensor", [](const ReportInput& i) { return html::stated(i.run.sensor_serial); });
  both("scanner electronics", [](const ReportInput& i) { return html::stated(scanner_serial_of(i.run, i.sensor)); });
  both("origin", [](const ReportInput& i) { return html::stated(i.run.origin); });
  both("started (UTC)", [](const ReportInput& i) { return moment(i.run.started_utc); });
  both("operator", [](const ReportInput& i) { return html::stated(i.run.operator_name); });
  both("bench", [](const ReportInput& i) { return html::stated(i.run.bench_id); });
  both("recipes", [](const ReportInput& i) { return html::stated(sequences_of(i.run)); });
  both("outcome", [](const ReportInput& i) {
    return Text(fmt::format("{}{}", db::to_string(i.run.outcome), i.run.is_void() ? ", VOID" : ""));
  });
  both("declared void", [](const ReportInput& i) {
    if (!i.run.is_void()) return markup("no");
    return markup("<span class=\"fail\"><span class=\"sign\">✗</span> by {}, {}: {}</span>", Text(i.run.void_by),
                  moment(i.run.void_utc), Text(i.run.void_reason));
  });
  both("SHA-256 of the run’s content", [](const ReportInput& i) { return code(i.run.content_sha256); });
  both("all requirements together",
       [](const ReportInput& i) { return overall_cell(i, "no tolerance limits were given"); });
  out += markup("</tbody></table>\n");
  return out;
}

Markup figures_rows(const ReportInput& a, const ReportInput& b) {
  Markup out = markup(
      "<table><caption>Figures</caption><thead><tr><th scope=\"col\">figure</th><th scope=\"col\" "
      "class=\"n\">first</th>"
      "<th scope=\"col\" class=\"n\">second</th><th scope=\"col\" class=\"n\">second − first</th>"
      "<th scope=\"col\" class=\"n\">change, %</th></tr></thead><tbody>\n");
  for (const OverviewFigure& figure : overview_figures()) {
    const double x = figure.value(a), y = figure.value(b);
    out += markup("<tr><th scope=\"row\">{}</th>{}{}{}{}</tr>\n", Text(name_of(figure, a.unit)),
                  number_cell(shown_figure(figure, x, a.unit)), number_cell(shown_figure(figure, y, a.unit)),
                  number_cell(shown_figure(figure, y - x, a.unit)),
                  number_cell(x != 0.0 && std::isfinite(y / x) ? html::percent(y / x - 1.0, 1) : Text("–")));
  }
  out += markup("</tbody></table>\n");
  return out;
}

// The second run's data with the first run's models, beside its own.
Markup found_and_left(const ReportInput& a, const ReportInput& b) {
  if (a.held_out.empty()) return {};
  const PressureUnit unit = a.unit;
  const Evaluation& found = a.held_out.front().evaluation;
  Evaluation left = b.evaluation;
  if (left.levels.empty())
    left.mean_error_psi = left.max_error_psi = left.worst_taxel_mean_error_psi = left.comp_distance =
        left.comp_distance_of_mean = kNan;
  Markup out = markup(
      "<table><caption>The second run’s data, corrected with the first run’s models and with its "
      "own</caption><thead><tr>"
      "<th scope=\"col\">figure</th><th scope=\"col\" class=\"n\">as found (first run’s models)</th>"
      "<th scope=\"col\" class=\"n\">as left (its own models)</th></tr></thead><tbody>\n");
  const auto row = [&](const char* name, const html::Safe& x, const html::Safe& y) {
    out += markup("<tr><th scope=\"row\">{}</th>{}{}</tr>\n", Text(name), number_cell(x), number_cell(y));
  };
  row("mean absolute error", html::pressure(found.mean_error_psi, unit, 3),
      html::pressure(left.mean_error_psi, unit, 3));
  row("maximum absolute error", html::pressure(found.max_error_psi, unit, 2),
      html::pressure(left.max_error_psi, unit, 2));
  row("mean absolute error of the worst taxel", html::pressure(found.worst_taxel_mean_error_psi, unit, 3),
      html::pressure(left.worst_taxel_mean_error_psi, unit, 3));
  row("hysteresis, mean over taxels, % FS", html::percent(found.comp_distance, 2),
      html::percent(left.comp_distance, 2));
  row("hysteresis of the mean of all pressures, % FS", html::percent(found.comp_distance_of_mean, 2),
      html::percent(left.comp_distance_of_mean, 2));
  out += markup(
      "</tbody></table>\n<p class=\"note\">As found: how well the sensor measured until now. As left: the fit’s own "
      "run, "
      "the calibration data; only other runs are independent verification.</p>\n");
  return out;
}

Markup mean_loops(const ReportInput& a, const ReportInput& b) {
  LineChart chart{.title = "Mean external loops of the indication of the two runs",
                  .x_label = "gauge pressure",
                  .y_label = "output in V",
                  .series = {},
                  .width = 682,
                  .height = 220};
  int style = 0;
  for (const auto& [name, input] : {std::pair{"first", &a}, std::pair{"second", &b}}) {
    const Behaviour& behaviour = input->behaviour;
    if (behaviour.loops.empty()) continue;
    const RawLoop& loop = behaviour.loops.front();
    Series series{.name = fmt::format("{}: {}", name, sensor_and_run(*input)),
                  .x = behaviour.pressure_psi,
                  .y = loop.up_v,
                  .style = style++};
    series.x.insert(series.x.end(), behaviour.pressure_psi.rbegin(), behaviour.pressure_psi.rend());
    series.y.insert(series.y.end(), loop.down_v.rbegin(), loop.down_v.rend());
    chart.series.push_back(std::move(series));
  }
  if (chart.series.empty()) return markup("<p>Loops: not available</p>\n");
  return markup("<figure>{}<figcaption>External loops of the mean taxels.</figcaption></figure>\n",
                line_chart(pressure_along(std::move(chart), a.unit)));
}

// Output of each taxel over that of the other run at the level of the equilibration; empty where they do not compare.
std::vector<double> output_ratios(const ReportInput& a, const ReportInput& b) {
  const Behaviour &x = a.behaviour, &y = b.behaviour;
  if (x.loops.empty() || y.loops.empty() || x.gain.size() != y.gain.size() || a.health.columns != b.health.columns)
    return {};
  if (!(std::abs(x.equilibration_psi - y.equilibration_psi) < 0.5)) return {};
  const auto mean_at_level = [](const Behaviour& behaviour) {
    const auto at = std::ranges::find(behaviour.pressure_psi, behaviour.equilibration_psi);
    return behaviour.loops.front().up_v[static_cast<std::size_t>(at - behaviour.pressure_psi.begin())];
  };
  const double means = mean_at_level(y) / mean_at_level(x);
  std::vector<double> ratios;
  for (std::size_t i = 0; i < x.gain.size(); ++i) ratios.push_back(y.gain[i] / x.gain[i] * means);
  return ratios;
}

Markup ratio_figures(const ReportInput& a, const ReportInput& b, const std::vector<double>& ratios) {
  const Spread spread = spread_of(ratios);
  if (spread.count == 0) return markup("<p>Taxel by taxel: not available, the runs share no level or shape.</p>\n");
  const ColourScale scale{spread.low, spread.high > spread.low ? spread.high : spread.low + 1e-3};
  Markup map = frame_map({"Output of each taxel, second run over first, at one level, pressure increasing",
                          a.health.rows, a.health.columns, ratios, scale, 180.0});
  map += colour_bar(scale, "Colour scale of the ratios", "×", 3);
  const Histogram histogram{.title = "Ratio of outputs, number of taxels",
                            .x_label = "second over first",
                            .y_label = "taxels",
                            .values = ratios,
                            .limit = std::nullopt,
                            .limit_name = {},
                            .width = 400,
                            .height = 215};
  return markup(
      "<div class=\"pair\">\n<figure>{}<figcaption>Output of each taxel at {}, increasing, second over first: {} to "
      "{}, "
      "median {}. A cross: not in both.</figcaption></figure>\n<figure>{}<figcaption>The same, number of "
      "taxels.</figcaption></figure>\n</div>\n",
      map, html::pressure(b.behaviour.equilibration_psi, a.unit, 1), html::fixed(spread.low, 3),
      html::fixed(spread.high, 3), html::fixed(spread.median, 3), histogram_chart(histogram));
}

Markup health_changes(const ReportInput& a, const ReportInput& b) {
  const auto states = [](const ReportInput& input) {
    std::set<std::pair<int, std::string>> out;
    for (const TaxelHealth& finding : input.health.findings) out.emplace(finding.taxel, finding.state);
    return out;
  };
  const auto before = states(a), after = states(b);
  const auto list = [&](const auto& from, const auto& without) {
    std::string words;
    for (const auto& [taxel, state] : from)
      if (!without.contains({taxel, state})) words += fmt::format("{}{} {}", words.empty() ? "" : ", ", state, taxel);
    return words.empty() ? std::string("none") : words;
  };
  return pairs_table("Taxels with findings, state and number",
                     {{"only in the first run", markup("{}", Text(list(before, after)))},
                      {"only in the second run", markup("{}", Text(list(after, before)))}});
}

}  // namespace

Report render_comparison(const ReportInput& a, const ReportInput& b) {
  const std::vector<double> ratios = output_ratios(a, b);
  Report report;
  const std::string found =
      a.held_out.empty() ? "null" : fmt::format("{:a}", a.held_out.front().evaluation.mean_error_psi);
  report.content_sha256 = db::sha256_hex(fmt::format("{}\n{}\n{}", content_of_run(a), content_of_run(b), found));
  report.number = fmt::format("{}-{}-{}", a.run.run, b.run.run, report.content_sha256.substr(0, 8));
  report.json = fmt::format(
      "{{\"schema\":\"tactbench.comparison\",\"version\":2,\"number\":\"{}\",\"runs\":[{},{}],\n\"first\":{},"
      "\n\"second\":{},"
      "\n\"output_ratio\":{}}}",
      report.number, a.run.run, b.run.run, content_of_run(a), content_of_run(b), json_text(number_list(ratios)));
  Page page;
  page.document = "Comparison of two runs";
  page.number = report.number;
  page.simulated = is_simulated(a) || is_simulated(b);
  page.paper = a.paper;
  page.opening = markup("<p>{}: {} and {}. Not a calibration report: each run has its own.</p>\n",
                        Text(same_sensor(a, b) ? "One sensor at two times" : "Two sensors"), Text(sensor_and_run(a)),
                        Text(sensor_and_run(b)));
  page.main.push_back(who_table(a, b));
  page.main.push_back(figures_rows(a, b));
  if (same_sensor(a, b)) page.main.push_back(found_and_left(a, b));
  page.main.push_back(mean_loops(a, b));
  page.main.push_back(ratio_figures(a, b, ratios));
  page.main.push_back(health_changes(a, b));
  page.json = report.json;
  report.html = page_of(page);
  return report;
}

}  // namespace tactbench::analysis
