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
const LevelFigures* same_level(const std::optional<AsFound>& previous, double pressure_psi) {
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
  const auto worse_of = [](const Evaluation& e) {
    return Text(
        fmt::format("{} of {}", std::ranges::count(e.levels, true, &LevelFigures::made_worse), e.levels.size()));
  };
  std::vector<FoundRow> rows;
  const auto row = [&](const char* name, const html::Text& raw, auto figure) {
    rows.push_back({name, raw, of(found, figure), figure(left), of(held, figure)});
  };
  row("mean error against the reference", html::psi(straight.mean_error_psi, 2),
      [](const Evaluation& e) { return html::psi(e.mean_error_psi, 3); });
  row("the same without flat samples", none,
      [](const Evaluation& e) { return html::psi(e.mean_error_observable_psi, 3); });
  row("maximum error", html::psi(straight.max_error_psi, 1),
      [](const Evaluation& e) { return html::psi(e.max_error_psi, 2); });
  row("mean error of the worst taxel", html::psi(straight.worst_taxel_mean_error_psi, 2),
      [](const Evaluation& e) { return html::psi(e.worst_taxel_mean_error_psi, 3); });
  row("|up − down| of the mean of all taxels, % FS", html::percent(left.raw_distance, 2),
      [](const Evaluation& e) { return html::percent(e.comp_distance_of_mean, 2); });
  row(
      "|up − down|, mean over taxels, % FS",
      [&] {
        double sum = 0.0;
        for (const LevelFigures& level : left.levels) sum += level.raw_distance;
        return html::percent(sum / static_cast<double>(left.levels.size()), 2);
      }(),
      [](const Evaluation& e) { return html::percent(e.comp_distance, 2); });
  row("levels with a larger distance than raw", Text("–"), worse_of);

  Markup out = markup(
      "<div class=\"wide\" tabindex=\"0\" role=\"region\" aria-label=\"Raw, as found, as left\"><table><caption>Raw, "
      "as "
      "found and as left</caption><thead><tr><th scope=\"col\">figure</th><th scope=\"col\" class=\"n\">raw</th>"
      "<th scope=\"col\" class=\"n\">as found</th><th scope=\"col\" class=\"n\">as left, own run (fit)</th>"
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
  if (!input.more.previous || input.more.previous->verdicts.empty()) return {};
  const AsFound& found = *input.more.previous;
  const std::optional<Verdict> as_found = overall_verdict(found.verdicts),
                               as_left = final_verdict(input.verdicts, input.judgement);
  if (!states_conformity(as_found)) return {};
  Markup rows;
  for (const db::VerdictRecord& verdict : found.verdicts)
    rows += markup("<tr><th scope=\"row\">{}</th><td>{}</td>{}{}<td>{}</td></tr>\n",
                   html::stated(criterion_in_words(verdict.criterion)), html::stated(verdict.scope),
                   number_cell(judged_value(nullptr, verdict)), number_cell(judged_limit(verdict)),
                   verdict_mark(verdict_in(verdict), is_simulated(input)));
  Markup out = markup("<p>As found: {}. As left: {}{}.</p>\n", verdict_mark(*as_found, is_simulated(input)),
                      as_left ? verdict_mark(*as_left, is_simulated(input)) : markup("no verdict"),
                      Text(as_left ? condition_in_words(*as_left, input.judgement) : ""));
  if (!found.doubt.empty())
    out += markup("<p class=\"fail\"><span class=\"sign\">✗</span> {}</p>\n", Text(found.doubt));
  out += markup(
      "<table><caption>As found against the limits</caption><thead><tr><th scope=\"col\">criterion</th>"
      "<th scope=\"col\">scope</th><th scope=\"col\" class=\"n\">value</th><th scope=\"col\" "
      "class=\"n\">limit</th><th scope=\"col\">verdict</th></tr></thead><tbody>\n{}</tbody></table>\n",
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
  Markup out = worse_mark(than_raw, "worse than raw");
  if (than_raw && than_found) out += markup("; ");
  out += worse_mark(than_found, "worse than as found");
  return out;
}

Markup found_levels(const ReportInput& input) {
  const bool has_found = input.more.previous.has_value();
  Markup out = markup(
      "<div class=\"wide\" tabindex=\"0\" role=\"region\" aria-label=\"Levels raw, as found, as left\"><table "
      "class=\"levels\"><caption>Every level raw, as found and as left; % FS</caption><thead><tr>"
      "<th scope=\"col\" rowspan=\"2\" class=\"n\">psi</th><th scope=\"col\" rowspan=\"2\" class=\"n\">kPa</th>"
      "<th scope=\"colgroup\" colspan=\"3\">distance</th><th scope=\"colgroup\" colspan=\"3\">std up</th>"
      "<th scope=\"colgroup\" colspan=\"3\">std down</th><th scope=\"col\" rowspan=\"2\">as left is</th></tr><tr>");
  for (int group = 0; group < 3; ++group)
    out += markup(
        "<th scope=\"col\" class=\"n\">raw</th><th scope=\"col\" class=\"n\">found</th>"
        "<th scope=\"col\" class=\"n\">left</th>");
  out += markup("</tr></thead><tbody>\n");
  for (const LevelFigures& level : input.evaluation.levels) {
    const LevelFigures* found = same_level(input.more.previous, level.pressure_psi);
    out += markup("<tr><th scope=\"row\" class=\"n\">{}</th>{}", html::fixed(level.pressure_psi, 1),
                  number_cell(html::kilopascals(level.pressure_psi, 1)));
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
  all.insert(all.begin(), distance_series("raw", input.evaluation, &LevelFigures::raw_distance, 0));
  LineChart chart{.title = "Distance of loading and unloading per level: raw, as found, as left",
                  .x_label = "pressure in psi",
                  .y_label = "distance in % FS",
                  .series = std::move(all),
                  .width = 335,
                  .height = 250,
                  .y_from_zero = true};
  Markup out =
      markup("<div class=\"pair\">\n<figure>{}<figcaption>Mean over the taxels of |up − down|.</figcaption></figure>\n",
             line_chart(chart));
  chart.title = "The same without the raw one, on a scale of its own";
  chart.series = std::move(compensated);
  out += markup("<figure>{}<figcaption>After compensation alone.</figcaption></figure>\n</div>\n", line_chart(chart));
  return out;
}

}  // namespace

Markup as_found_section(const ReportInput& input) {
  Markup out = section_start("as-found", "Raw, as found, as left");
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
        "<p>As found: not assessed, no earlier models were named. Whether measurements made with them stand cannot be "
        "said from this report.</p>\n");
  }
  out += found_verdicts(input);
  out += summary_table(input);
  out += found_charts(input);
  out += found_levels(input);
  out += markup(
      "<p class=\"note\">Raw pressures: every taxel read by one straight line through the ends of the mean taxel’s "
      "external loop. FS raw: {} V, the highest mean output of this run; FS after compensation: {}, the full pressure. "
      "Distance: mean over the taxels of |up − down|; std: standard deviation over the taxels. The column of the own "
      "run shows the data that the models were made from; only a held-out run shows what to expect in use.</p>\n",
      html::fixed(input.evaluation.full_scale_v, 3), html::psi(input.evaluation.full_scale_psi, 1));
  return out;
}

}  // namespace tactbench::analysis
