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

// Tables 8 and 9: one strip, raw or compensated.
struct ContactStrip {
  const char* caption;
  const char* what;
  const char* unit;
  std::vector<double> ContactLevel::*frame;
  double ContactLevel::*std_share;
  const std::vector<double>* distance;
  double full_scale;
  ColourScale scale, distance_scale;
};

const ContactLevel* level_at(const ContactResult& contact, double target, bool rising) {
  const auto found = std::ranges::find_if(
      contact.levels, [&](const ContactLevel& level) { return level.target_n == target && level.rising == rising; });
  return found == contact.levels.end() ? nullptr : &*found;
}

std::vector<double> targets_of(const ContactResult& contact) {
  std::vector<double> out;
  for (const ContactLevel& level : contact.levels)
    if (level.rising) out.push_back(level.target_n);
  return out;
}

double highest_of(const ContactResult& contact, std::vector<double> ContactLevel::*frame) {
  double highest = 0.0;
  for (const ContactLevel& level : contact.levels)
    for (const double value : level.*frame)
      if (std::isfinite(value)) highest = std::max(highest, value);
  return highest > 0.0 ? highest : 1.0;
}

std::vector<double> strip_distance(const ContactLevel& up, const ContactLevel& down, const ContactStrip& strip) {
  std::vector<double> out;
  for (std::size_t i = 0; i < (up.*strip.frame).size(); ++i)
    out.push_back(100.0 * std::abs((up.*strip.frame)[i] - (down.*strip.frame)[i]) / strip.full_scale);
  return out;
}

Markup strip_markup(const ContactResult& contact, const ContactStrip& strip, int rows, int columns) {
  const std::vector<double> targets = targets_of(contact);
  Markup out = markup("<table class=\"strip\"><caption>{}</caption><thead><tr><td></td>", Text(strip.caption));
  for (const double target : targets) out += markup("<th scope=\"col\">{} N</th>", html::fixed(target, 0));
  out += markup("</tr></thead><tbody>\n");
  const auto picture = [&](const std::string& title, std::vector<double> values, const ColourScale& scale) {
    return cell(frame_map({title, rows, columns, std::move(values), scale, 78.0}));
  };
  for (const bool rising : {true, false}) {
    out += markup("<tr><th scope=\"row\">{}</th>", Text(rising ? "incr." : "decr."));
    for (const double target : targets) {
      const ContactLevel* level = level_at(contact, target, rising);
      out += level == nullptr ? cell(Text("–"))
                              : picture(fmt::format("{}, {}, {:g} N", strip.what, branch_in_words(rising), target),
                                        level->*strip.frame, strip.scale);
    }
    out += markup("</tr>\n<tr><th scope=\"row\">s, % FS</th>");
    for (const double target : targets) {
      const ContactLevel* level = level_at(contact, target, rising);
      out += cell(level == nullptr ? Text("–") : html::percent(level->*strip.std_share, 1));
    }
    out += markup("</tr>\n");
  }
  out += markup("<tr><th scope=\"row\">hyst.</th>");
  for (const double target : targets) {
    const ContactLevel *up = level_at(contact, target, true), *down = level_at(contact, target, false);
    out += down == nullptr ? cell(Text("–"))
                           : picture(fmt::format("{}, hysteresis, {:g} N", strip.what, target),
                                     strip_distance(*up, *down, strip), strip.distance_scale);
  }
  out += markup("</tr>\n<tr><th scope=\"row\">mean, % FS</th>");
  for (const double distance : *strip.distance)
    out += cell(std::isfinite(distance) ? html::percent(distance, 1) : Text("–"));
  out += markup("</tr>\n</tbody></table>\n");
  return out;
}

}  // namespace

Markup contact_frames_part(const ContactResult& contact, int rows, int columns, PressureUnit unit) {
  const ContactStrip raw{"Under the object: indication, output voltage",
                         "Indication under the object",
                         "V",
                         &ContactLevel::raw_v,
                         &ContactLevel::raw_std,
                         &contact.raw_distance,
                         contact.full_scale_v,
                         {0.0, highest_of(contact, &ContactLevel::raw_v)},
                         {0.0, 30.0}};
  const ContactStrip compensated{"Under the object: corrected indication, pressure",
                                 "Corrected indication under the object",
                                 "psi",
                                 &ContactLevel::compensated_psi,
                                 &ContactLevel::compensated_std,
                                 &contact.compensated_distance,
                                 contact.full_scale_psi,
                                 {0.0, highest_of(contact, &ContactLevel::compensated_psi)},
                                 {0.0, 30.0}};
  Markup out = strip_markup(contact, raw, rows, columns);
  out += colour_bar(raw.scale, "Colour scale of the frames of the indication under the object", "V", 2);
  out += strip_markup(contact, compensated, rows, columns);
  out += pressure_bar(compensated.scale, "Colour scale of the corrected frames under the object", unit, 0);
  out += colour_bar(raw.distance_scale, "Colour scale of the hysteresis under the object", "% FS", 0);
  std::string worse;
  const std::vector<double> targets = targets_of(contact);
  for (std::size_t i = 0; i < contact.raw_distance.size(); ++i)
    if (contact.compensated_distance[i] > contact.raw_distance[i])
      worse += fmt::format("{}{:g} N", worse.empty() ? "" : ", ", targets[i]);
  if (!worse.empty())
    out += markup(
        "<p><span class=\"worse\"><span class=\"sign\">▲</span> Hysteresis of the corrected indication larger than "
        "that of the "
        "indication</span> at "
        "{}.</p>\n",
        Text(worse));
  out += markup(
      "<p class=\"note\">Means of the repeats. FS: that of the chamber run, {} V and {}; s over the taxels with a "
      "model, which under an object is its shape as well as non-uniformity.</p>\n",
      html::fixed(contact.full_scale_v, 3), html::pressure(contact.full_scale_psi, unit, 1));
  return out;
}

}  // namespace tactbench::analysis
