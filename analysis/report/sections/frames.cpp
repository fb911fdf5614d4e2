#include <algorithm>
#include <array>
#include <cmath>

#include "analysis/report/page/figure.h"
#include "analysis/report/parts.h"
#include "analysis/report/sections/sections.h"

namespace tactbench::analysis {

using html::markup;
using html::Markup;
using html::Text;

namespace {

using Levels = std::vector<const LevelFigures*>;
using FrameOf = std::vector<double> LevelFigures::*;
using FigureOf = double LevelFigures::*;

// The levels of the paper's Tables 6 and 7; where a run has none within 1 psi of one, that column is left out.
Levels shown_levels(const Evaluation& evaluation) {
  Levels shown;
  for (const double wanted : {4.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0}) {
    const LevelFigures* best = nullptr;
    for (const LevelFigures& level : evaluation.levels) {
      const double distance = std::abs(level.pressure_psi - wanted);
      if (distance <= 1.0 && (best == nullptr || distance < std::abs(best->pressure_psi - wanted))) best = &level;
    }
    if (best != nullptr && std::find(shown.begin(), shown.end(), best) == shown.end()) shown.push_back(best);
  }
  return shown;
}

std::vector<double> distance_frame(const std::vector<double>& up, const std::vector<double>& down, double full_scale) {
  std::vector<double> out;
  for (std::size_t i = 0; i < std::min(up.size(), down.size()); ++i) {
    out.push_back(100.0 * std::abs(up[i] - down[i]) / full_scale);
  }
  return out;
}

double highest(const Levels& levels, FrameOf up, FrameOf down) {
  double out = 0.0;
  for (const LevelFigures* level : levels) {
    for (const FrameOf frame : {up, down}) {
      for (const double value : level->*frame) out = std::isfinite(value) ? std::max(out, value) : out;
    }
  }
  return out > 0.0 ? out : 1.0;
}

struct Strip {
  const char* id;
  const char* caption;
  const char* what;  // in titles
  FrameOf up, down;
  FigureOf std_up, std_down, distance;
  double full_scale = 1.0;
  ColourScale scale, distance_scale;
};

class StripWriter {
 public:
  StripWriter(const ReportInput& input, const Levels& levels, const Strip& strip)
      : input_(input), levels_(levels), strip_(strip) {}

  Markup write() const {
    Markup out = markup("<table class=\"strip\" id=\"{}\"><caption>{}</caption><thead><tr><td></td>",
                        html::Attribute(strip_.id), Text(strip_.caption));
    const PressureUnit unit = input_.unit;
    for (const LevelFigures* level : levels_) {
      out += markup("<th scope=\"col\">{} {}<br/>{} {}</th>", html::in_unit(level->pressure_psi, unit, 0),
                    Text(unit.symbol()), html::in_unit(level->pressure_psi, unit.beside(), 0),
                    Text(unit.beside().symbol()));
    }
    out += markup("</tr></thead><tbody>\n");
    out += frames("incr.", true, strip_.up);
    out += figures("s, % FS", strip_.std_up);
    out += frames("decr.", false, strip_.down);
    out += figures("s, % FS", strip_.std_down);
    out += distances();
    out += figures("mean, % FS", strip_.distance);
    out += markup("</tbody></table>\n");
    return out;
  }

 private:
  FrameMap map(const LevelFigures& level, const char* way) const {
    return {fmt::format("{}, {}, {}", strip_.what, way, input_.unit.text(level.pressure_psi, 0)),
            input_.fit.rows,
            input_.fit.columns,
            {},
            strip_.scale,
            78.0};
  }

  Markup frames(const char* head, bool up, FrameOf frame) const {
    Markup out = markup("<tr><th scope=\"row\">{}</th>", Text(head));
    for (const LevelFigures* level : levels_) {
      FrameMap picture = map(*level, branch_in_words(up));
      picture.values = level->*frame;
      out += cell(frame_map(picture));
    }
    out += markup("</tr>\n");
    return out;
  }

  Markup distances() const {
    Markup out = markup("<tr><th scope=\"row\">hyst.</th>");
    for (const LevelFigures* level : levels_) {
      FrameMap picture = map(*level, "hysteresis");
      picture.values = distance_frame(level->*strip_.up, level->*strip_.down, strip_.full_scale);
      picture.scale = strip_.distance_scale;
      out += cell(frame_map(picture));
    }
    out += markup("</tr>\n");
    return out;
  }

  Markup figures(const char* head, FigureOf figure) const {
    Markup out = markup("<tr><th scope=\"row\">{}</th>", Text(head));
    for (const LevelFigures* level : levels_) out += cell(html::percent(level->*figure, 1));
    out += markup("</tr>\n");
    return out;
  }

  const ReportInput& input_;
  const Levels& levels_;
  const Strip& strip_;
};

// Up to the next 5 % FS. Each strip has its own: on that of the indication the corrected maps would be of one colour.
ColourScale distance_scale(const Levels& levels, FrameOf up, FrameOf down, double full_scale) {
  double high = 0.0;
  for (const LevelFigures* level : levels)
    for (const double value : distance_frame(level->*up, level->*down, full_scale))
      high = std::isfinite(value) ? std::max(high, value) : high;
  return {0.0, std::max(5.0, 5.0 * std::ceil(high / 5.0))};
}

}  // namespace

Markup frames_section(const ReportInput& input) {
  const Evaluation& evaluation = input.evaluation;
  const Levels levels = shown_levels(evaluation);
  Markup out = section_start("frames", "Frames: indication and corrected indication");
  if (levels.empty()) {
    out += markup("<p>not available</p>\n");
    return out;
  }
  const ColourScale volts{0.0, highest(levels, &LevelFigures::raw_up_v, &LevelFigures::raw_down_v)};
  // A corrected indication is clamped to the range of the external loop, so full pressure ends the scale.
  const ColourScale full{0.0, evaluation.full_scale_psi > 0.0 ? evaluation.full_scale_psi : 1.0};

  const Strip raw{"frames-raw",
                  "Indication: output voltage",
                  "Indication",
                  &LevelFigures::raw_up_v,
                  &LevelFigures::raw_down_v,
                  &LevelFigures::raw_std_up,
                  &LevelFigures::raw_std_down,
                  &LevelFigures::raw_distance,
                  evaluation.full_scale_v,
                  volts,
                  distance_scale(levels, &LevelFigures::raw_up_v, &LevelFigures::raw_down_v, evaluation.full_scale_v)};
  const Strip compensated{
      "frames-compensated",
      "Corrected indication: pressure",
      "Corrected indication",
      &LevelFigures::comp_up_psi,
      &LevelFigures::comp_down_psi,
      &LevelFigures::comp_std_up,
      &LevelFigures::comp_std_down,
      &LevelFigures::comp_distance,
      evaluation.full_scale_psi,
      full,
      distance_scale(levels, &LevelFigures::comp_up_psi, &LevelFigures::comp_down_psi, evaluation.full_scale_psi)};
  out += StripWriter(input, levels, raw).write();
  out += colour_bar(volts, "Colour scale of the frames of the indication", "V", 2);
  out += colour_bar(raw.distance_scale, "Colour scale of the hysteresis of the indication", "% FS", 0);
  out += StripWriter(input, levels, compensated).write();
  out += pressure_bar(full, "Colour scale of the frames of the corrected indication", input.unit, 0);
  out +=
      colour_bar(compensated.distance_scale, "Colour scale of the hysteresis of the corrected indication", "% FS", 0);
  out += markup(
      "<p class=\"note\">Row 0 on top, column 0 on the left. Below each strip stand its colour scales, of the frames "
      "and "
      "of the hysteresis (hyst.), the difference between increasing (incr.) and decreasing (decr.) pressure. A cross "
      "marks a taxel without a value (no model). s: standard deviation over the taxels with a model. FS of the "
      "indication: highest mean output, {} V; of the corrected indication: full pressure, {}. At the top of the range "
      "increasing and decreasing pressure meet in one frame.</p>\n",
      html::fixed(evaluation.full_scale_v, 3), html::pressure(evaluation.full_scale_psi, input.unit, 1));
  return out;
}

}  // namespace tactbench::analysis
