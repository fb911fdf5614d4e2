#include <algorithm>
#include <cmath>

#include "analysis/report/page/figure.h"
#include "analysis/report/parts.h"
#include "analysis/report/sections/sections.h"

namespace tactbench::analysis {

using html::markup;
using html::Markup;
using html::Text;

namespace {

Markup runs_list(const std::vector<std::int64_t>& runs) {
  Markup out;
  for (const std::int64_t run : runs) out += markup("{}{}", Text(out.value.empty() ? "" : ", "), run);
  return out;
}

Markup map_figure(const std::string& title, const std::vector<double>& values, int rows, int columns,
                  const ColourScale& scale, double factor) {
  FrameMap map{title, rows, columns, {}, scale, 190.0};
  for (const double value : values) map.values.push_back(factor * value);
  return markup("<figure>{}<figcaption>{}</figcaption></figure>\n", frame_map(map), Text(title));
}

// Symmetric about 0: the middle of the scale is no deviation.
ColourScale symmetric_scale(const std::vector<double>& values, double factor) {
  double most = 0.0;
  for (const double value : values)
    if (std::isfinite(value)) most = std::max(most, factor * std::abs(value));
  return {-most, most > 0.0 ? most : 1.0};
}

}  // namespace

Markup remount_part(const Remount& remount, int rows, int columns, PressureUnit unit) {
  Markup out = markup("<h3>Reproducibility: mounting</h3>\n");
  if (!remount.assessed()) {
    out += markup("<p>not assessed: {}.</p>\n", Text(remount.not_assessed));
    return out;
  }
  out += markup(
      "<p>{} mounts of the sensor, runs {}, all corrected with the models of the first. Root mean square over the "
      "levels from a tenth of the highest on: within a mount {} % of the reading, between mounts {} % of the reading "
      "({} degrees of freedom).</p>\n",
      remount.runs.size(), runs_list(remount.runs), html::percent(remount.within_share, 2),
      html::percent(remount.s_share, 2), remount.degrees);
  out += markup(
      "<div class=\"pair\">\n<figure>{}<figcaption>Standard deviations over the levels.</figcaption></figure>\n",
      line_chart(pressures({.title = "Standard deviation within and between mounts per level",
                            .x_label = "gauge pressure",
                            .y_label = "standard deviation",
                            .series = {{"within a mount", remount.pressure_psi, remount.within_psi, 2},
                                       {"between mounts", remount.pressure_psi, remount.between_psi, 1},
                                       {"between, array mean", remount.pressure_psi, remount.mean_between_psi, 3}},
                            .width = 335,
                            .height = 255,
                            .y_from_zero = true},
                           unit)));
  const Spread spread = spread_of(remount.taxel_between_psi);
  const ColourScale scale{0.0, spread.count > 0 && spread.high > 0.0 ? spread.high : 1.0};
  out += map_figure("Standard deviation between mounts of each taxel", remount.taxel_between_psi, rows, columns, scale,
                    1.0);
  out += markup("</div>\n");
  out += pressure_bar(scale, "Colour scale of the map of mounts", unit, 2);
  out += markup(
      "<table><caption>Standard deviation of one taxel’s pressure, root mean square over the "
      "taxels</caption><thead><tr>{}"
      "<th scope=\"col\" class=\"n\">within a mount</th><th scope=\"col\" class=\"n\">between mounts</th>"
      "<th scope=\"col\" class=\"n\">between, array mean</th></tr></thead><tbody>\n",
      level_headings(unit));
  for (std::size_t i = 0; i < remount.pressure_psi.size(); ++i) {
    out += markup("<tr>{}{}{}{}</tr>\n", level_cells(remount.pressure_psi[i], unit),
                  number_cell(html::pressure(remount.within_psi[i], unit, 3)),
                  number_cell(html::pressure(remount.between_psi[i], unit, 3)),
                  number_cell(html::pressure(remount.mean_between_psi[i], unit, 3)));
  }
  out += markup(
      "</tbody></table>\n<p class=\"note\">On sweeps of increasing pressure from the lowest to the highest, estimates "
      "moved to the set-points. Within: between the sweeps of one mount; between: of the mounts, what “within” "
      "explains taken "
      "off (one-way analysis of variance, not below 0). Time passes between mounts: drift is contained in "
      "“between”.</p>\n");
  return out;
}

Markup uniformity_part(const Uniformity& u, int rows, int columns, PressureUnit unit) {
  Markup out = markup("<h3>Uniformity of the chamber</h3>\n");
  if (!u.assessed()) {
    out += markup("<p>not assessed: {}.</p>\n", Text(u.not_assessed));
    return out;
  }
  Markup angles;
  for (const int angle : u.angles_deg) angles += markup("{}{}°", Text(angles.value.empty() ? "" : ", "), angle);
  out += markup(
      "<p>Runs {} of the sensor turned in the chamber by {} (counter-clockwise, row 0 on top). Estimates of pressure "
      "are "
      "taken apart by least squares, level by level, into a map that stays with the sensor, one that stays with the "
      "chamber, and a residual. Levels at which estimates come to the end of the models’ range are left out.</p>\n",
      runs_list(u.runs), angles);
  out += pairs_table(
      "Chamber",
      {{"non-uniformity, relative standard uncertainty", markup("{} % of the pressure", html::percent(u.u_share, 2))},
       {"the part that does not grow with pressure, standard uncertainty",
        markup("{}", html::pressure(u.u_offset_psi, unit, 3))},
       {"residual, standard deviation over all levels", markup("{}", html::pressure(u.residual_rms_psi, unit, 3))},
       {"residual with the angles in the other sense",
        markup("{}{}", html::pressure(u.residual_other_sense_psi, unit, 3),
               u.residual_other_sense_psi < 0.9 * u.residual_rms_psi
                   ? markup(" <span class=\"doubt\"><span class=\"sign\">▲</span> smaller: were the angles "
                            "taken clockwise?</span>")
                   : markup(""))},
       {"undetermined", markup("{} sets of places that one taxel can come to: what all places of a set have in "
                               "common, such as a bowl about the centre, may be the chamber’s or the "
                               "sensor’s. It is counted to the sensor here, and the uncertainty above does not "
                               "hold it.",
                               u.undetermined)}});
  const ColourScale scale = symmetric_scale(u.chamber_share, 100.0), sensor = symmetric_scale(u.sensor_share, 100.0);
  out += markup("<div class=\"pair\">\n");
  out += map_figure("The chamber’s part, % of the pressure", u.chamber_share, rows, columns, scale, 100.0);
  out += map_figure("The sensor’s part (error of its models), % of the pressure", u.sensor_share, rows, columns, sensor,
                    100.0);
  out += markup("</div>\n");
  out += colour_bar(scale, "Colour scale of the chamber’s part", "%", 2);
  out += colour_bar(sensor, "Colour scale of the sensor’s part", "%", 2);
  out +=
      markup("<figure>{}<figcaption>Standard deviation over the array, per level.</figcaption></figure>\n",
             line_chart(pressures(
                 {.title = "Standard deviation of the chamber’s part and of the residual per level",
                  .x_label = "gauge pressure",
                  .y_label = "standard deviation",
                  .series = {{"chamber", u.pressure_psi, u.u_psi, 1}, {"residual", u.pressure_psi, u.residual_psi, 2}},
                  .width = 682,
                  .height = 225,
                  .y_from_zero = true},
                 unit)));
  return out;
}

}  // namespace tactbench::analysis
