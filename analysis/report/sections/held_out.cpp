#include <algorithm>

#include "analysis/report/parts.h"
#include "analysis/report/sections/sections.h"

namespace tactbench::analysis {

using html::markup;
using html::Markup;
using html::Text;

namespace {

constexpr std::size_t kRunsPerTable = 4;  // as many columns as A4 holds

struct Column {
  std::string title;
  const db::RunRecord* run;
  const Evaluation* evaluation;
};

struct Row {
  const char* name;
  html::Text (*figure)(const Evaluation&, PressureUnit);
};

html::Text worse_levels(const Evaluation& evaluation, PressureUnit) {
  const auto worse = std::count_if(evaluation.levels.begin(), evaluation.levels.end(),
                                   [](const LevelFigures& level) { return level.made_worse; });
  return Text(fmt::format("{} of {}", worse, evaluation.levels.size()));
}

constexpr Row kRows[] = {
    {"indication: hysteresis of the mean taxel, % FS",
     [](const Evaluation& e, PressureUnit) { return html::percent(e.raw_distance, 2); }},
    {"corrected: hysteresis of the mean of all pressures, % FS",
     [](const Evaluation& e, PressureUnit) { return html::percent(e.comp_distance_of_mean, 2); }},
    {"corrected: hysteresis, mean over taxels, % FS",
     [](const Evaluation& e, PressureUnit) { return html::percent(e.comp_distance, 2); }},
    {"the same without flagged levels, % FS",
     [](const Evaluation& e, PressureUnit) { return html::percent(e.comp_distance_observable, 2); }},
    {"corrected: hysteresis, worst taxel, % FS",
     [](const Evaluation& e, PressureUnit) { return html::percent(e.worst_taxel_distance, 2); }},
    {"the same without flagged levels, % FS",
     [](const Evaluation& e, PressureUnit) { return html::percent(e.worst_taxel_distance_observable, 2); }},
    {"flagged pairs of taxel and level, %",
     [](const Evaluation& e, PressureUnit) { return html::percent(e.flat_share, 1); }},
    {"mean absolute error",
     [](const Evaluation& e, PressureUnit unit) { return html::pressure(e.mean_error_psi, unit, 3); }},
    {"the same without flat samples",
     [](const Evaluation& e, PressureUnit unit) { return html::pressure(e.mean_error_observable_psi, unit, 3); }},
    {"mean absolute error of the worst taxel",
     [](const Evaluation& e, PressureUnit unit) { return html::pressure(e.worst_taxel_mean_error_psi, unit, 3); }},
    {"levels with more hysteresis than the indication", worse_levels},
};

std::string recipes_of(const db::RunRecord& run) {
  std::string names;
  for (const db::SequenceRecord& sequence : run.sequences) names += (names.empty() ? "" : ", ") + sequence.name;
  return names;
}

Markup runs_table(std::span<const Column> columns, const html::Safe& caption, PressureUnit unit) {
  Markup out = markup(
      "<div class=\"wide\" tabindex=\"0\" role=\"region\" "
      "aria-label=\"Runs\"><table><caption>{}</caption><thead><tr><th scope=\"col\">figure</th>",
      caption);
  for (const Column& column : columns)
    out += markup("<th scope=\"col\" class=\"n\">{}</th>", html::stated(column.title));
  out += markup("</tr></thead><tbody>\n<tr><th scope=\"row\">run</th>");
  for (const Column& column : columns) out += markup("<td class=\"n\">{}</td>", column.run->run);
  out += markup("</tr>\n<tr><th scope=\"row\">recipes: the trajectories that its errors hold for</th>");
  for (const Column& column : columns) out += markup("<td class=\"n\">{}</td>", html::stated(recipes_of(*column.run)));
  out += markup("</tr>\n<tr><th scope=\"row\">started (UTC)</th>");
  for (const Column& column : columns) out += number_cell(moment(column.run->started_utc));
  out += markup("</tr>\n<tr><th scope=\"row\">frames evaluated</th>");
  for (const Column& column : columns) out += markup("<td class=\"n\">{}</td>", column.evaluation->frames);
  out += markup("</tr>\n");
  for (const Row& row : kRows) {
    out += markup("<tr><th scope=\"row\">{}</th>", Text(row.name));
    for (const Column& column : columns) out += number_cell(row.figure(*column.evaluation, unit));
    out += markup("</tr>\n");
  }
  out += markup("</tbody></table></div>\n");
  return out;
}

}  // namespace

Markup held_out_section(const ReportInput& input) {
  Markup out = section_start("held-out", "The same models on other runs");
  if (input.held_out.empty()) {
    out += markup(
        "<p>not assessed: no other run of this sensor was given. The figures below are of the run that the models were "
        "made from.</p>\n");
  }
  std::vector<Column> columns{{"own run (calibration data)", &input.run, &input.evaluation}};
  for (const HeldOut& held_out : input.held_out)
    columns.push_back({held_out.title, &held_out.run, &held_out.evaluation});
  for (std::size_t first = 0; first < columns.size(); first += kRunsPerTable) {
    const std::size_t count = std::min(kRunsPerTable, columns.size() - first);
    out += runs_table(std::span(columns).subspan(first, count),
                      Text(first == 0 ? "The models on this and other runs" : "The models on other runs, continued"),
                      input.unit);
  }
  out += markup(
      "<p class=\"note\">The models were made from run {} only, the calibration data; the other runs are independent "
      "verification data. Hysteresis: the difference between increasing and decreasing pressure at one level, averaged "
      "over the levels of the external loop. FS of the indication: highest mean output of the run in volt; of the "
      "corrected indication: full pressure, {}. Flagged: taxel and level where the output changes too little for the "
      "pressure to be observable.</p>\n",
      input.run.run, html::pressure(input.evaluation.full_scale_psi, input.unit, 1));
  return out;
}

}  // namespace tactbench::analysis
