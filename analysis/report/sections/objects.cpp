#include <algorithm>
#include <cmath>

#include "analysis/counted.h"
#include "analysis/report/page/figure.h"
#include "analysis/report/page/gum_numbers.h"
#include "analysis/report/parts.h"
#include "analysis/report/sections/sections.h"

namespace tactbench::analysis {

using html::markup;
using html::Markup;
using html::Text;

namespace {

html::Text signed_error(double value, double reference) { return html::fixed(value - reference, 2); }

Markup force_table(const ContactResult& contact) {
  Markup out = markup(
      "<div class=\"wide\" tabindex=\"0\" role=\"region\" aria-label=\"Force, run {}\"><table "
      "class=\"levels\"><caption>Total "
      "force of the array against the force sensor, means over {} a level</caption><thead><tr>"
      "<th scope=\"col\" rowspan=\"2\" class=\"n\">level, N</th><th scope=\"col\" rowspan=\"2\" class=\"n\">force</th>"
      "<th scope=\"col\" rowspan=\"2\" class=\"n\">force sensor, N</th>"
      "<th scope=\"colgroup\" colspan=\"3\">indication</th><th scope=\"colgroup\" "
      "colspan=\"3\">corrected</th></tr><tr>",
      contact.run, Text(counted(contact.levels.front().frames, "frame")));
  for (int way = 0; way < 2; ++way)
    out += markup(
        "<th scope=\"col\" class=\"n\">force, N</th><th scope=\"col\" class=\"n\">less sensor, N</th>"
        "<th scope=\"col\" class=\"n\">area, mm²</th>");
  out += markup("</tr></thead><tbody>\n");
  for (const ContactLevel& level : contact.levels) {
    out += markup("<tr><th scope=\"row\" class=\"n\">{}</th>{}{}", html::fixed(level.target_n, 1),
                  number_cell(Text(branch_in_words(level.rising))), number_cell(html::fixed(level.force_n, 3)));
    for (const ContactFigures* figures : {&level.raw, &level.compensated}) {
      out += number_cell(html::fixed(figures->force_n, 2));
      out += number_cell(signed_error(figures->force_n, level.force_n));
      out += number_cell(html::fixed(figures->area_mm2, 1));
    }
    out += markup("</tr>\n");
  }
  out += markup("</tbody></table></div>\n");
  return out;
}

Markup place_table(const ContactResult& contact) {
  const bool one_place = contact.positions == 1;
  Markup out = markup(
      "<div class=\"wide\" tabindex=\"0\" role=\"region\" aria-label=\"Centre of pressure, run {}\"><table "
      "class=\"levels\"><caption>Centre of pressure and moments</caption><thead><tr>"
      "<th scope=\"col\" rowspan=\"2\" class=\"n\">level, N</th><th scope=\"col\" rowspan=\"2\" class=\"n\">force</th>"
      "<th scope=\"colgroup\" colspan=\"{}\">indication</th><th scope=\"colgroup\" colspan=\"{}\">corrected</th>"
      "<th scope=\"col\" rowspan=\"2\" class=\"n\">force sensor √(Tx² + Ty²), N mm</th></tr><tr>",
      contact.run, one_place ? 6 : 2, one_place ? 6 : 2);
  for (int way = 0; way < 2; ++way) {
    if (one_place)
      out += markup(
          "<th scope=\"col\" class=\"n\">x, mm</th><th scope=\"col\" class=\"n\">y, mm</th>"
          "<th scope=\"col\" class=\"n\">Mx, N mm</th><th scope=\"col\" class=\"n\">My, N mm</th>");
    out += markup("<th scope=\"col\" class=\"n\">wanders, mm</th><th scope=\"col\" class=\"n\">off axis, mm</th>");
  }
  out += markup("</tr></thead><tbody>\n");
  for (const ContactLevel& level : contact.levels) {
    out += markup("<tr><th scope=\"row\" class=\"n\">{}</th>{}", html::fixed(level.target_n, 1),
                  number_cell(Text(branch_in_words(level.rising))));
    for (const bool raw : {true, false}) {
      const ContactFigures& figures = raw ? level.raw : level.compensated;
      if (one_place) {
        for (const double value : {figures.x_mm, figures.y_mm}) out += number_cell(html::fixed(value, 2));
        for (const double value : {figures.moment_x_nmm, figures.moment_y_nmm})
          out += number_cell(html::fixed(value, 1));
      }
      out += number_cell(html::fixed(raw ? level.raw_wander_mm : level.compensated_wander_mm, 3));
      const double off = raw ? level.raw_place_error_mm : level.compensated_place_error_mm;
      out += number_cell(std::isfinite(off) ? html::fixed(off, 2) : Text("–"));
    }
    out += markup("{}</tr>\n", number_cell(html::fixed(level.torque_nmm, 3)));
  }
  out += markup("</tbody></table></div>\n");
  return out;
}

Markup force_charts(const ContactResult& contact) {
  Series raw_up{"indication, incr.", {}, {}, 1}, raw_down{"indication, decr.", {}, {}, 4},
      up{"corrected, incr.", {}, {}, 2}, down{"corrected, decr.", {}, {}, 3};
  double highest = 0.0;
  for (const ContactLevel& level : contact.levels) {
    highest = std::max(highest, level.force_n);
    for (const auto& [series, figures] : {std::pair{level.rising ? &raw_up : &raw_down, &level.raw},
                                          std::pair{level.rising ? &up : &down, &level.compensated}}) {
      series->x.push_back(level.force_n);
      series->y.push_back(figures->force_n);
    }
  }
  Series area_raw{"indication", {}, {}, 1, true}, area{"corrected", {}, {}, 2, true};
  for (const ContactLevel& level : contact.levels) {
    area_raw.x.push_back(level.force_n);
    area_raw.y.push_back(level.raw.area_mm2);
    area.x.push_back(level.force_n);
    area.y.push_back(level.compensated.area_mm2);
  }
  const Series ideal{"force sensor", {0.0, highest}, {0.0, highest}, 0};
  Markup out = markup(
      "<div class=\"pair\">\n<figure>{}<figcaption>Total force.</figcaption></figure>\n",
      line_chart({.title = fmt::format("Total force of the array against the force sensor, {}", contact.sequence),
                  .x_label = "force sensor, N",
                  .y_label = "array, N",
                  .series = {ideal, raw_up, raw_down, up, down},
                  .width = 335,
                  .height = 260,
                  .y_from_zero = true}));
  out += markup("<figure>{}<figcaption>Contact area.</figcaption></figure>\n</div>\n",
                line_chart({.title = fmt::format("Contact area over the force, {}", contact.sequence),
                            .x_label = "force sensor, N",
                            .y_label = "area, mm²",
                            .series = {area_raw, area},
                            .width = 335,
                            .height = 260,
                            .y_from_zero = true}));
  return out;
}

// U of the force that the array's is held against.
Markup force_budget(const InstrumentUncertainty& force) {
  if (force.rows.empty()) return markup("<p>U of the force sensor: not assessed, none is stored with the run.</p>\n");
  Markup out = markup(
      "<table class=\"levels even\"><caption>Budget of the force sensor’s reading (its certificate covers: "
      "{})</caption><thead><tr><th scope=\"col\">contribution</th><th scope=\"col\" class=\"n\">width, {}</th><th "
      "scope=\"col\">distribution</th><th scope=\"col\" class=\"n\">divisor</th><th scope=\"col\" class=\"n\">u, "
      "{}</th></tr></thead><tbody>\n",
      Text(in_words(force.covers)), Text(force.unit), Text(force.unit));
  for (const InstrumentRow& row : force.rows) {
    out += markup("<tr><th scope=\"row\">{}</th>", Text(row.name));
    if (row.assessed())
      out += markup("{}<td>{}</td>{}{}</tr>\n", number_cell(html::significant(row.width, 3)), Text(row.distribution),
                    number_cell(html::significant(row.divisor, 3)), number_cell(gum_uncertainty(row.u())));
    else
      out += markup("<td colspan=\"4\">{}{}</td></tr>\n", Text(row.part.missing.empty() ? "" : "not assessed: "),
                    Text(row.part.missing.empty() ? row.part.from : row.part.missing));
  }
  if (force.u() > 0.0)
    out += markup("<tr><th scope=\"row\">expanded</th><td colspan=\"3\">U = 2 u_c</td>{}</tr>\n",
                  number_cell(gum_uncertainty(force.expanded())));
  out += markup("</tbody></table>\n");
  return out;
}

Markup contact_part(const ContactResult& contact, int rows, int columns, PressureUnit unit) {
  Markup out = markup("<h3>{}, run {}</h3>\n", html::stated(contact.object.empty() ? contact.sequence : contact.object),
                      contact.run);
  out += markup(
      "<p>Sequence {}: places: {}, repeats: {}. Error of the total force over all frames: indication {} N on average, "
      "at most {} N; corrected {} N on average, at most {} N.</p>\n",
      html::stated(contact.sequence), contact.positions, contact.repeats, html::fixed(contact.raw_mean_error_n, 2),
      html::fixed(contact.raw_max_error_n, 2), html::fixed(contact.compensated_mean_error_n, 2),
      html::fixed(contact.compensated_max_error_n, 2));
  if (contact.compensated_mean_error_n > contact.raw_mean_error_n)
    out += markup(
        "<p><span class=\"worse\"><span class=\"sign\">▲</span> The corrected total force is worse than that of the "
        "indication.</span></p>\n");
  if (!contact.force_traceability.empty()) out += markup("<p>{}</p>\n", Text(contact.force_traceability));
  out += force_budget(contact.force_uncertainty);
  out += force_charts(contact);
  out += force_table(contact);
  out += place_table(contact);
  if (contact.mount_run == 0)
    out += markup(
        "<p>Distance of the centre of pressure from the object’s axis: not assessed, no registration of the stage to "
        "the taxels was given.</p>\n");
  else
    out += markup(
        "<p>Off axis: distance of the centre of pressure from the object’s axis by the registration of run "
        "{}.</p>\n",
        contact.mount_run);
  if (contact.positions == 1) out += contact_frames_part(contact, rows, columns, unit);
  double clamped = 0.0;
  for (const ContactLevel& level : contact.levels) clamped = std::max(clamped, level.clamped_taxels);
  if (clamped > 0.0)
    out += markup(
        "<p><span class=\"doubt\"><span class=\"sign\">▲</span> Up to {} taxels stood at the highest pressure of their "
        "models: what lies above is not seen.</span></p>\n",
        html::fixed(clamped, 1));
  return out;
}

}  // namespace

Markup objects_section(const ReportInput& input) {
  Markup out = section_start("objects", "The array under objects");
  if (input.more.contacts.empty()) {
    out += markup("<p>not assessed: no run with an object on the stage was given.</p>\n");
    return out;
  }
  const ArrayGeometry& geometry = input.more.contacts.front().geometry;
  for (const ContactResult& contact : input.more.contacts)
    out += contact_part(contact, input.fit.rows, input.fit.columns, input.unit);
  out += markup(
      "<p class=\"note\">Force of the array: sum of pressure times {} mm², the effective area of a taxel, pitch {} mm. "
      "Centre of pressure and moments (Mx = Σ p A y, My = −Σ p A x) about the array’s centre, x along the columns, y "
      "along "
      "the rows; the force sensor’s torque is about its own axis, which the object stands on. Wanders: distance from "
      "the "
      "mean centre of all levels at that place. In contact are taxels of at least 10 % of the frame’s highest pressure "
      "and of {}; centre, moments and area are theirs, the total force is of all taxels. Indication: every "
      "taxel read by one straight line through the ends of the mean taxel’s external loop. "
      "Corrected: each taxel’s own model, unloaded before each rise. Pressure between the taxels is not seen.</p>\n",
      html::fixed(geometry.taxel_area_mm2, 4), html::fixed(geometry.pitch_mm, 2), html::pressure(0.5, input.unit, 1));
  return out;
}

}  // namespace tactbench::analysis
