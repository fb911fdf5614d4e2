#include "analysis/report/parts.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "analysis/identify/stored/model_document.h"
#include "analysis/statistics/figures/levels.h"

namespace tactbench::analysis {

using html::markup;
using html::Markup;
using html::Text;

Markup cell(const html::Safe& content) { return markup("<td>{}</td>", content); }

Markup number_cell(const html::Safe& content) { return markup("<td class=\"n\">{}</td>", content); }

Markup pairs_table(const char* caption, const std::vector<Pair>& rows) {
  Markup out = markup("<table class=\"pairs\"><caption>{}</caption><tbody>\n", Text(caption));
  for (const Pair& row : rows) {
    out += markup("<tr><th scope=\"row\">{}</th><td>{}</td></tr>\n", Text(row.name), row.value);
  }
  out += markup("</tbody></table>\n");
  return out;
}

Markup level_headings(PressureUnit unit, int rows) {
  Markup out;
  for (const PressureUnit shown : {unit, unit.beside()})
    out += markup("<th scope=\"col\"{} class=\"n\">{}</th>", rows > 1 ? markup(" rowspan=\"{}\"", rows) : markup(""),
                  Text(shown.symbol()));
  return out;
}

Markup level_cells(double pressure_psi, PressureUnit unit) {
  return markup("<th scope=\"row\" class=\"n\">{}</th>{}", html::in_unit(pressure_psi, unit, 1),
                number_cell(html::in_unit(pressure_psi, unit.beside(), 1)));
}

const char* branch_in_words(bool up) { return up ? "increasing" : "decreasing"; }

Markup section_start(const char* id, const char* title) {
  return markup("<h2 id=\"{}\">{}</h2>\n", html::Attribute(id), Text(title));
}

Markup code(const std::string& untrusted) {
  if (untrusted.empty()) return markup("{}", Text("not available"));
  return markup("<code>{}</code>", Text(untrusted));
}

Text moment(const std::string& utc) {
  std::string words = utc;
  if (words.size() > 10 && words[10] == 'T') words[10] = ' ';
  return html::stated(words);
}

std::string place_of(int taxel, int columns) {
  const int width = std::max(1, columns);
  return fmt::format("row {}, column {}", taxel / width, taxel % width);
}

std::string model_name(const SensorModel& fit) {
  return fit.model == kElamFit && !fit.options.linearise ? "ELAM" : label_of(fit);
}

bool is_simulated(const ReportInput& input) {
  const auto simulated = [](const db::RunRecord& run) { return run.origin == "simulated"; };
  return simulated(input.run) || std::any_of(input.held_out.begin(), input.held_out.end(),
                                             [&](const HeldOut& held_out) { return simulated(held_out.run); });
}

bool is_certificate(const ReportInput& input) {
  if (input.laboratory.accreditation.empty() || is_simulated(input) || !states_uncertainty(input)) return false;
  const ReferenceUncertainty reference = reference_uncertainty(input.run, input.laboratory.instruments);
  return has_reference(input.run) && reference.calibration.traceable() && !reference.untraced();
}

bool states_uncertainty(const ReportInput& input) { return input.uncertainty && !input.uncertainty->levels.empty(); }

bool has_reference(const db::RunRecord& run) {
  const auto lower = [](std::string text) {
    for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
  };
  const auto is_reference = [&](const db::DeviceRecord& device) {
    const std::string role = lower(device.role);
    return role.find("pressure") != std::string::npos && role.find("reference") != std::string::npos;
  };
  return std::any_of(run.devices.begin(), run.devices.end(), [&](const db::DeviceRecord& device) {
    if (!is_reference(device)) return false;
    // The same instrument entered twice is not an independent witness.
    return std::none_of(run.devices.begin(), run.devices.end(), [&](const db::DeviceRecord& other) {
      return !is_reference(other) && !device.serial.empty() && other.serial == device.serial &&
             other.model == device.model;
    });
  });
}

Markup verdict_mark(Verdict verdict, bool simulated) {
  const bool pass = verdict == Verdict::kPass, fail = verdict == Verdict::kFail;
  return markup("<span class=\"{}\"><span class=\"sign\">{}</span> {}{}</span>",
                html::Attribute(pass   ? "pass"
                                : fail ? "fail"
                                       : "doubt"),
                Text(pass   ? "✓"
                     : fail ? "✗"
                            : "▲"),
                Text(simulated ? "simulated " : ""), Text(to_string(verdict)));
}

Spread spread_of(std::vector<double> values) {
  values = finite_of(values);
  if (values.empty()) return {kNan, kNan, kNan, 0};
  const auto [low, high] = std::ranges::minmax(values);
  return {low, median_of(values), high, values.size()};
}

Deviation deviation(std::span<const double> a, std::span<const double> b) {
  double sum = 0.0, maximum = 0.0;
  std::size_t n = 0;
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    const double difference = std::abs(a[i] - b[i]);
    if (!std::isfinite(difference)) continue;
    sum += difference;
    maximum = std::max(maximum, difference);
    ++n;
  }
  if (n == 0) return {kNan, kNan};
  return {sum / static_cast<double>(n), maximum};
}

int fitted_taxels(const SensorModel& fit) { return static_cast<int>(fit.fitted().size()); }

double observable(const LevelFigures& level, double LevelFigures::*figure, int fitted) {
  return level.flat_taxels < fitted ? level.*figure : kNan;
}

LevelJudgement judge_level(const LevelFigures& level) {
  return {level.made_worse, level.comp_std_up > level.raw_std_up, level.comp_std_down > level.raw_std_down};
}

}  // namespace tactbench::analysis
