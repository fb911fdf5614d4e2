#include <cmath>
#include <limits>

#include "analysis/report/page/figure.h"
#include "analysis/report/parts.h"
#include "analysis/report/sections/sections.h"

namespace tactbench::analysis {

using html::markup;
using html::Markup;
using html::Text;

namespace {

std::vector<double> column(const Evaluation& evaluation, double LevelFigures::*figure, double factor) {
  std::vector<double> out;
  for (const LevelFigures& level : evaluation.levels) out.push_back(factor * level.*figure);
  return out;
}

Markup level_charts(const Evaluation& evaluation, int fitted, PressureUnit unit) {
  const auto series = [&](const char* name, double LevelFigures::*figure, int style) {
    return Series{name, column(evaluation, &LevelFigures::pressure_psi, 1.0), column(evaluation, figure, 100.0), style,
                  false};
  };
  Series only_observable = series("corrected, without flat", &LevelFigures::comp_distance_observable, 3);
  for (std::size_t i = 0; i < evaluation.levels.size(); ++i) {
    only_observable.y[i] = 100.0 * observable(evaluation.levels[i], &LevelFigures::comp_distance_observable, fitted);
  }
  Markup out = markup("<div class=\"pair\">\n");
  out += markup(
      "<figure>{}<figcaption>Hysteresis, mean over the taxels.</figcaption></figure>\n",
      line_chart(pressure_along({.title = "Hysteresis of indication and corrected indication per level",
                                 .x_label = "gauge pressure",
                                 .y_label = "hysteresis in % FS",
                                 .series = {series("indication", &LevelFigures::raw_distance, 1),
                                            series("corrected", &LevelFigures::comp_distance, 2), only_observable},
                                 .width = 335,
                                 .height = 285,
                                 .y_from_zero = true},
                                unit)));
  out += markup("<figure>{}<figcaption>Non-uniformity: standard deviation s over the taxels.</figcaption></figure>\n",
                line_chart(pressure_along(
                    {.title = "Standard deviation over the taxels per level, indication and corrected indication",
                     .x_label = "gauge pressure",
                     .y_label = "s in % FS",
                     .series = {series("increasing, indication", &LevelFigures::raw_std_up, 1),
                                series("decreasing, indication", &LevelFigures::raw_std_down, 4),
                                series("increasing, corrected", &LevelFigures::comp_std_up, 2),
                                series("decreasing, corrected", &LevelFigures::comp_std_down, 3)},
                     .width = 335,
                     .height = 285,
                     .y_from_zero = true},
                    unit)));
  out += markup("</div>\n");
  return out;
}

Markup judgement(const LevelFigures& level) {
  const LevelJudgement worse = judge_level(level);
  if (!worse.any()) return markup("smaller");
  std::string words;
  for (const auto& [is_worse, word] : {std::pair{worse.distance, "hysteresis"}, std::pair{worse.std_up, "s incr."},
                                       std::pair{worse.std_down, "s decr."}}) {
    if (is_worse) words += (words.empty() ? "" : ", ") + std::string(word);
  }
  return markup("<span class=\"worse\"><span class=\"sign\">▲</span> worse: {}</span>", Text(words));
}

Markup level_row(const LevelFigures& level, int fitted, PressureUnit unit) {
  Markup out = markup("<tr>{}", level_cells(level.pressure_psi, unit));
  out += number_cell(html::in_unit(level.up_psi, unit, 2));
  out += number_cell(html::in_unit(level.down_psi, unit, 2));
  for (const double figure :
       {level.raw_std_up, level.raw_std_down, level.raw_distance, level.comp_std_up, level.comp_std_down,
        level.comp_distance, observable(level, &LevelFigures::comp_distance_observable, fitted),
        level.worst_taxel_distance}) {
    out += number_cell(html::percent(figure, 2));
  }
  out += markup("<td class=\"n\">{}</td><td>{}</td></tr>\n", level.flat_taxels, judgement(level));
  return out;
}

Markup summary(const Evaluation& evaluation, PressureUnit unit) {
  std::string distance, mismatch;
  int worse_distance = 0, worse_mismatch = 0;
  const auto add = [&](std::string& list, double pressure) {
    list += (list.empty() ? "" : ", ") + html::in_unit(pressure, unit, 0).value;
  };
  for (const LevelFigures& level : evaluation.levels) {
    const LevelJudgement worse = judge_level(level);
    if (worse.distance) {
      ++worse_distance;
      add(distance, level.pressure_psi);
    }
    if (worse.std_up || worse.std_down) {
      ++worse_mismatch;
      add(mismatch, level.pressure_psi);
    }
  }
  const auto line = [&](const char* what, int count, const std::string& list) {
    if (count == 0) return markup("<li>{}: larger at none of {} levels.</li>\n", Text(what), evaluation.levels.size());
    return markup(
        "<li>{}: <span class=\"worse\"><span class=\"sign\">▲</span> larger at {} of {} levels</span> ({} {}).</li>\n",
        Text(what), count, evaluation.levels.size(), Text(list), Text(unit.symbol()));
  };
  Markup out =
      markup("<p>Where the corrected indication is worse than the indication, as a share of full scale:</p>\n<ul>\n");
  out += line("hysteresis", worse_distance, distance);
  out += line("non-uniformity (s), increasing or decreasing", worse_mismatch, mismatch);
  out += markup("</ul>\n");
  return out;
}

}  // namespace

Markup levels_section(const ReportInput& input) {
  const Evaluation& evaluation = input.evaluation;
  Markup out = section_start("levels", "Every level: indication and corrected indication");
  if (evaluation.levels.empty()) {
    out += markup("<p>not available</p>\n");
    return out;
  }
  out += summary(evaluation, input.unit);
  const int fitted = fitted_taxels(input.fit);
  out += level_charts(evaluation, fitted, input.unit);
  out += markup(
      "<div class=\"wide\" tabindex=\"0\" role=\"region\" aria-label=\"Levels\"><table "
      "class=\"levels\"><caption>Levels of the external loop; figures in % "
      "FS</caption><thead><tr>"
      "<th scope=\"colgroup\" colspan=\"2\">level</th><th scope=\"colgroup\" colspan=\"2\">reference value, {}</th>"
      "<th scope=\"colgroup\" colspan=\"3\">indication</th>"
      "<th scope=\"colgroup\" colspan=\"5\">corrected indication</th>"
      "<th scope=\"col\" rowspan=\"2\" class=\"n\">flat taxels</th><th scope=\"col\" rowspan=\"2\">corrected "
      "is</th></tr><tr>{}"
      "<th scope=\"col\" class=\"n\">incr.</th><th scope=\"col\" class=\"n\">decr.</th>"
      "<th scope=\"col\" class=\"n\">s incr.</th><th scope=\"col\" class=\"n\">s decr.</th>"
      "<th scope=\"col\" class=\"n\">hyste&#173;resis</th><th scope=\"col\" class=\"n\">s incr.</th>"
      "<th scope=\"col\" class=\"n\">s decr.</th><th scope=\"col\" class=\"n\">hyste&#173;resis</th>"
      "<th scope=\"col\" class=\"n\">without flat</th><th scope=\"col\" class=\"n\">worst "
      "taxel</th></tr></thead><tbody>\n",
      Text(input.unit.symbol()), level_headings(input.unit));
  for (const LevelFigures& level : evaluation.levels) out += level_row(level, fitted, input.unit);
  out += markup(
      "</tbody></table></div>\n<p class=\"note\">incr., decr.: pressure increasing, decreasing. Reference value: mean "
      "of "
      "the sweeps. s: non-uniformity, the standard deviation over the taxels with a model. Hysteresis: mean over them "
      "of the difference between increasing and decreasing pressure. Flat taxels: their output changed too little with "
      "decreasing pressure, measured by their noise, for the pressure to be observable; “without flat” leaves them out "
      "(not available where none is left). Worst taxel: its hysteresis, flat or not. FS of the indication: {} V, the "
      "highest mean over taxels and sweeps at a level; of the corrected indication: {}.</p>\n",
      html::fixed(evaluation.full_scale_v, 3), html::pressure(evaluation.full_scale_psi, input.unit, 1));
  return out;
}

}  // namespace tactbench::analysis
