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

Markup charts(const Evaluation& evaluation, int fitted) {
  const auto series = [&](const char* name, double LevelFigures::*figure, int style) {
    return Series{name, column(evaluation, &LevelFigures::pressure_psi, 1.0), column(evaluation, figure, 100.0), style,
                  false};
  };
  Series only_observable = series("after, observable only", &LevelFigures::comp_distance_observable, 3);
  for (std::size_t i = 0; i < evaluation.levels.size(); ++i) {
    only_observable.y[i] = 100.0 * observable(evaluation.levels[i], &LevelFigures::comp_distance_observable, fitted);
  }
  Markup out = markup("<div class=\"pair\">\n");
  out +=
      markup("<figure>{}<figcaption>Distance of loading and unloading, mean over the taxels.</figcaption></figure>\n",
             line_chart({.title = "Distance of loading and unloading per level before and after compensation",
                         .x_label = "pressure in psi",
                         .y_label = "distance in % FS",
                         .series = {series("before", &LevelFigures::raw_distance, 1),
                                    series("after", &LevelFigures::comp_distance, 2), only_observable},
                         .width = 335,
                         .height = 270,
                         .y_from_zero = true}));
  out += markup("<figure>{}<figcaption>Mismatch: standard deviation over the taxels.</figcaption></figure>\n",
                line_chart({.title = "Standard deviation over the taxels per level before and after compensation",
                            .x_label = "pressure in psi",
                            .y_label = "std/FS in %",
                            .series = {series("up, before", &LevelFigures::raw_std_up, 1),
                                       series("down, before", &LevelFigures::raw_std_down, 4),
                                       series("up, after", &LevelFigures::comp_std_up, 2),
                                       series("down, after", &LevelFigures::comp_std_down, 3)},
                            .width = 335,
                            .height = 270,
                            .y_from_zero = true}));
  out += markup("</div>\n");
  return out;
}

Markup judgement(const LevelFigures& level) {
  const LevelJudgement worse = judge_level(level);
  if (!worse.any()) return markup("smaller");
  std::string words;
  for (const auto& [is_worse, word] : {std::pair{worse.distance, "distance"}, std::pair{worse.std_up, "std up"},
                                       std::pair{worse.std_down, "std down"}}) {
    if (is_worse) words += (words.empty() ? "" : ", ") + std::string(word);
  }
  return markup("<span class=\"worse\"><span class=\"sign\">▲</span> worse: {}</span>", Text(words));
}

Markup level_row(const LevelFigures& level, int fitted) {
  Markup out = markup("<tr><th scope=\"row\" class=\"n\">{}</th>", html::fixed(level.pressure_psi, 1));
  out += number_cell(html::kilopascals(level.pressure_psi, 1));
  out += number_cell(html::fixed(level.up_psi, 2));
  out += number_cell(html::fixed(level.down_psi, 2));
  for (const double figure :
       {level.raw_std_up, level.raw_std_down, level.raw_distance, level.comp_std_up, level.comp_std_down,
        level.comp_distance, observable(level, &LevelFigures::comp_distance_observable, fitted),
        level.worst_taxel_distance}) {
    out += number_cell(html::percent(figure, 2));
  }
  out += markup("<td class=\"n\">{}</td><td>{}</td></tr>\n", level.flat_taxels, judgement(level));
  return out;
}

Markup summary(const Evaluation& evaluation) {
  std::string distance, mismatch;
  int worse_distance = 0, worse_mismatch = 0;
  const auto add = [](std::string& list, double pressure) {
    list += (list.empty() ? "" : ", ") + html::fixed(pressure, 0).value;
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
        "<li>{}: <span class=\"worse\"><span class=\"sign\">▲</span> larger at {} of {} levels</span> ({} psi).</li>\n",
        Text(what), count, evaluation.levels.size(), Text(list));
  };
  Markup out = markup("<p>What compensation made worse, as a share of full scale:</p>\n<ul>\n");
  out += line("distance of loading and unloading", worse_distance, distance);
  out += line("mismatch (std/FS) in at least one direction", worse_mismatch, mismatch);
  out += markup("</ul>\n");
  return out;
}

}  // namespace

Markup levels_section(const ReportInput& input) {
  const Evaluation& evaluation = input.evaluation;
  Markup out = section_start("levels", "Every level before and after compensation");
  if (evaluation.levels.empty()) {
    out += markup("<p>not available</p>\n");
    return out;
  }
  out += summary(evaluation);
  const int fitted = fitted_taxels(input.fit);
  out += charts(evaluation, fitted);
  out += markup(
      "<div class=\"wide\" tabindex=\"0\" role=\"region\" aria-label=\"Levels\"><table "
      "class=\"levels\"><caption>Levels of the external loop; figures in % "
      "FS</caption><thead><tr>"
      "<th scope=\"colgroup\" colspan=\"4\">pressure</th>"
      "<th scope=\"colgroup\" colspan=\"3\">before</th>"
      "<th scope=\"colgroup\" colspan=\"5\">after</th>"
      "<th scope=\"col\" rowspan=\"2\" class=\"n\">flat taxels</th><th scope=\"col\" rowspan=\"2\">after against "
      "before</th></tr><tr>"
      "<th scope=\"col\" class=\"n\">psi</th><th scope=\"col\" class=\"n\">kPa</th>"
      "<th scope=\"col\" class=\"n\">up, psi</th><th scope=\"col\" class=\"n\">down, psi</th>"
      "<th scope=\"col\" class=\"n\">std up</th><th scope=\"col\" class=\"n\">std down</th>"
      "<th scope=\"col\" class=\"n\">dis&#173;tance</th><th scope=\"col\" class=\"n\">std up</th>"
      "<th scope=\"col\" class=\"n\">std down</th><th scope=\"col\" class=\"n\">dis&#173;tance</th>"
      "<th scope=\"col\" class=\"n\">without flat</th><th scope=\"col\" class=\"n\">worst "
      "taxel</th></tr></thead><tbody>\n");
  for (const LevelFigures& level : evaluation.levels) out += level_row(level, fitted);
  out += markup(
      "</tbody></table></div>\n<p class=\"note\">up, down: measured reference pressure of the two passes, mean of the "
      "sweeps. "
      "std: standard deviation over the taxels with a model. distance: mean over them of |up − down|. flat taxels: "
      "taxels "
      "whose "
      "output changed too little with pressure on the way down, measured by their noise, for the pressure to be "
      "observable; "
      "“without flat” leaves them out (not available where none is left). worst taxel: its distance, flat or not. FS "
      "before: {} V; after: {}.</p>\n",
      html::fixed(evaluation.full_scale_v, 3), html::psi(evaluation.full_scale_psi, 1));
  return out;
}

}  // namespace tactbench::analysis
