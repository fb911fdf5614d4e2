#include <algorithm>
#include <cmath>

#include "analysis/counted.h"
#include "analysis/report/data/judged_runs.h"
#include "analysis/report/page/figure.h"
#include "analysis/report/parts.h"
#include "analysis/report/sections/sections.h"
#include "analysis/statistics/figures/levels.h"

namespace tactbench::analysis {

using html::markup;
using html::Markup;
using html::Text;

namespace {

// The level of another evaluation at the same set-point; null where it has none.
const LevelFigures* found_level(const std::optional<AsFound>& previous, double pressure_psi) {
  if (!previous) return nullptr;
  for (const LevelFigures& level : previous->evaluation.levels)
    if (std::abs(level.pressure_psi - pressure_psi) < 0.05) return &level;
  return nullptr;
}

struct FoundRow {
  const char* name;
  html::Text raw, found, left, held_out;
};

Markup summary_table(const ReportInput& input) {
  const Evaluation& left = input.evaluation;
  const Evaluation* found = input.more.previous ? &input.more.previous->evaluation : nullptr;
  const Evaluation* held = input.held_out.empty() ? nullptr : &input.held_out.front().evaluation;
  const Text none("not assessed");
  const auto of = [&](const Evaluation* e, auto figure) { return e == nullptr ? none : figure(*e); };
  const StraightLine& straight = input.more.straight;
  const PressureUnit unit = input.unit;
  const auto worse_of = [](const Evaluation& e) {
    return Text(
        fmt::format("{} of {}", std::ranges::count(e.levels, true, &LevelFigures::made_worse), e.levels.size()));
  };
  std::vector<FoundRow> rows;
  const auto row = [&](const char* name, const html::Text& raw, auto figure) {
    rows.push_back({name, raw, of(found, figure), figure(left), of(held, figure)});
  };
  row("mean absolute error", html::pressure(straight.mean_error_psi, unit, 2),
      [unit](const Evaluation& e) { return html::pressure(e.mean_error_psi, unit, 3); });
  row("the same without flat samples", none,
      [unit](const Evaluation& e) { return html::pressure(e.mean_error_observable_psi, unit, 3); });
  row("maximum absolute error", html::pressure(straight.max_error_psi, unit, 1),
      [unit](const Evaluation& e) { return html::pressure(e.max_error_psi, unit, 2); });
  row("mean absolute error of the worst taxel", html::pressure(straight.worst_taxel_mean_error_psi, unit, 2),
      [unit](const Evaluation& e) { return html::pressure(e.worst_taxel_mean_error_psi, unit, 3); });
  row("hysteresis of the mean of all taxels, % FS", html::percent(left.raw_distance, 2),
      [](const Evaluation& e) { return html::percent(e.comp_distance_of_mean, 2); });
  row(
      "hysteresis, mean over taxels, % FS",
      [&] {
        double sum = 0.0;
        for (const LevelFigures& level : left.levels) sum += level.raw_distance;
        return html::percent(sum / static_cast<double>(left.levels.size()), 2);
      }(),
      [](const Evaluation& e) { return html::percent(e.comp_distance, 2); });
  row("levels with more hysteresis than the indication", Text("–"), worse_of);

  Markup out = markup(
      "<div class=\"wide\" tabindex=\"0\" role=\"region\" aria-label=\"Indication, as found, as left\"><table>"
      "<caption>Indication, as found and as left</caption><thead><tr><th scope=\"col\">figure</th><th scope=\"col\" "
      "class=\"n\">indication</th><th scope=\"col\" class=\"n\">as found</th><th scope=\"col\" class=\"n\">as left, "
      "own run (calibration data)</th>"
      "<th scope=\"col\" class=\"n\">as left, {}</th></tr></thead><tbody>\n",
      held == nullptr ? Text("held-out run") : html::stated(input.held_out.front().title));
  for (const FoundRow& own : rows) {
    out += markup("<tr><th scope=\"row\">{}</th>{}{}{}{}</tr>\n", Text(own.name), number_cell(own.raw),
                  number_cell(own.found), number_cell(own.left), number_cell(own.held_out));
  }
  out += markup("</tbody></table></div>\n");
  return out;
}

// As found and as left, each with its verdict.
Markup found_verdicts(const ReportInput& input) {
  if (!input.more.previous || !states_conformity(input.more.previous->judgement.overall)) return {};
  const AsFound& found = *input.more.previous;
  const std::optional<Verdict> as_left = input.judgement.overall;
  Markup rows;
  for (const JudgedFigure& figure : found.judgement.figures)
    rows += markup("<tr><th scope=\"row\">{}</th><td>{}</td>{}{}<td>{}</td></tr>\n",
                   html::stated(in_words(figure.criterion)), html::stated(in_both_units(figure.scope, input.unit)),
                   number_cell(judged_value(figure, input.unit)), number_cell(judged_limit(figure, input.unit)),
                   verdict_mark(figure.verdict, is_simulated(input)));
  Markup out =
      markup("<p>As found: {}. As left: {}{}.</p>\n", verdict_mark(*found.judgement.overall, is_simulated(input)),
             as_left ? verdict_mark(*as_left, is_simulated(input)) : markup("no verdict"),
             Text(as_left ? condition_in_words(input.judgement, input.unit) : ""));
  if (!found.doubt.empty())
    out += markup("<p class=\"fail\"><span class=\"sign\">✗</span> {}</p>\n", Text(found.doubt));
  out += markup(
      "<table><caption>As found against the tolerance limits</caption><thead><tr><th scope=\"col\">requirement</th>"
      "<th scope=\"col\">scope</th><th scope=\"col\" class=\"n\">value</th><th scope=\"col\" "
      "class=\"n\">tolerance limit</th><th scope=\"col\">conformity</th></tr></thead><tbody>\n{}</tbody></table>\n",
      rows);
  return out;
}

Markup worse_mark(bool worse, const char* words) {
  if (!worse) return markup("");
  return markup("<span class=\"worse\"><span class=\"sign\">▲</span> {}</span>", Text(words));
}

Markup level_mark(const LevelFigures& level, const LevelFigures* found) {
  const bool than_raw = judge_level(level).any();
  const bool than_found = found != nullptr && level.comp_distance > found->comp_distance;
  if (!than_raw && !than_found) return markup("no worse");
  Markup out = worse_mark(than_raw, "worse than the indication");
  if (than_raw && than_found) out += markup("; ");
  out += worse_mark(than_found, "worse than as found");
  return out;
}

Markup found_levels(const ReportInput& input) {
  const bool has_found = input.more.previous.has_value();
  Markup out = markup(
      "<div class=\"wide\" tabindex=\"0\" role=\"region\" aria-label=\"Levels: indication, as found, as left\"><table "
      "class=\"levels\"><caption>Every level: indication, as found and as left; % FS</caption><thead><tr>{}"
      "<th scope=\"colgroup\" colspan=\"3\">hysteresis</th><th scope=\"colgroup\" colspan=\"3\">s, increasing</th>"
      "<th scope=\"colgroup\" colspan=\"3\">s, decreasing</th><th scope=\"col\" rowspan=\"2\">as left is</th></tr>"
      "<tr>",
      level_headings(input.unit, 2));
  for (int group = 0; group < 3; ++group)
    out += markup(
        "<th scope=\"col\" class=\"n\">indic.</th><th scope=\"col\" class=\"n\">found</th>"
        "<th scope=\"col\" class=\"n\">left</th>");
  out += markup("</tr></thead><tbody>\n");
  for (const LevelFigures& level : input.evaluation.levels) {
    const LevelFigures* found = found_level(input.more.previous, level.pressure_psi);
    out += markup("<tr>{}", level_cells(level.pressure_psi, input.unit));
    for (const auto& [raw, compensated] : {std::pair{&LevelFigures::raw_distance, &LevelFigures::comp_distance},
                                           std::pair{&LevelFigures::raw_std_up, &LevelFigures::comp_std_up},
                                           std::pair{&LevelFigures::raw_std_down, &LevelFigures::comp_std_down}}) {
      out += number_cell(html::percent(level.*raw, 2));
      out += number_cell(!has_found ? Text("–") : html::percent(found == nullptr ? kNan : found->*compensated, 2));
      out += number_cell(html::percent(level.*compensated, 2));
    }
    out += markup("<td>{}</td></tr>\n", level_mark(level, found));
  }
  out += markup("</tbody></table></div>\n");
  return out;
}

Series distance_series(const char* name, const Evaluation& evaluation, double LevelFigures::*figure, int style) {
  Series series{name, {}, {}, style};
  for (const LevelFigures& level : evaluation.levels) {
    series.x.push_back(level.pressure_psi);
    series.y.push_back(100.0 * level.*figure);
  }
  return series;
}

Markup found_charts(const ReportInput& input) {
  std::vector<Series> compensated;
  if (input.more.previous)
    compensated.push_back(
        distance_series("as found", input.more.previous->evaluation, &LevelFigures::comp_distance, 1));
  compensated.push_back(distance_series("as left, own run", input.evaluation, &LevelFigures::comp_distance, 2));
  if (!input.held_out.empty())
    compensated.push_back(
        distance_series("as left, held out", input.held_out.front().evaluation, &LevelFigures::comp_distance, 3));
  std::vector<Series> all = compensated;
  all.insert(all.begin(), distance_series("indication", input.evaluation, &LevelFigures::raw_distance, 0));
  LineChart chart{.title = "Hysteresis per level: indication, as found, as left",
                  .x_label = "gauge pressure",
                  .y_label = "hysteresis in % FS",
                  .series = std::move(all),
                  .width = 335,
                  .height = 265,
                  .y_from_zero = true};
  Markup out =
      markup("<div class=\"pair\">\n<figure>{}<figcaption>Hysteresis, mean over the taxels.</figcaption></figure>\n",
             line_chart(pressure_along(chart, input.unit)));
  chart.title = "The same of the corrected indication alone, on a scale of its own";
  chart.series = std::move(compensated);
  out += markup("<figure>{}<figcaption>Corrected indication alone.</figcaption></figure>\n</div>\n",
                line_chart(pressure_along(chart, input.unit)));
  return out;
}

}  // namespace

Markup as_found_section(const ReportInput& input) {
  Markup out = section_start("as-found", "Indication, as found, as left");
  if (input.evaluation.levels.empty()) {
    out += markup("<p>not available</p>\n");
    return out;
  }
  if (input.more.previous) {
    out += markup(
        "<p>As found: this run evaluated with the models used before, {} ({}). As left: with the models made "
        "from this run. Taxels that this run leaves out are left out of every column.</p>\n",
        html::stated(input.more.previous->model), html::Text(counted(input.more.previous->fitted_taxels, "taxel")));
  } else {
    out += markup(
        "<p>As found: not assessed, no earlier models were named. Whether measurements made with them stand, this "
        "report "
        "does not show.</p>\n");
  }
  out += found_verdicts(input);
  out += summary_table(input);
  out += found_charts(input);
  out += found_levels(input);
  out += markup(
      "<p class=\"note\">Pressures of the indication: every taxel read by one straight line through the ends of the "
      "mean taxel’s external loop. FS of the indication: {} V, the highest mean output of this run; of the corrected "
      "indication: {}, the full pressure. Hysteresis: mean over the taxels of the difference between increasing and "
      "decreasing pressure; s: standard deviation over the taxels. The column of the own run shows the calibration "
      "data, which the models were made from; only a held-out run is independent verification.</p>\n",
      html::fixed(input.evaluation.full_scale_v, 3), html::pressure(input.evaluation.full_scale_psi, input.unit, 1));
  return out;
}

}  // namespace tactbench::analysis
