#include <nlohmann/json.hpp>

#include "analysis/json_io.h"
#include "analysis/report/parts.h"
#include "analysis/report/sections/sections.h"

namespace tactbench::analysis {

using html::markup;
using html::Markup;
using html::stated;
using html::Text;

namespace {

// What scaled the raw counts, one member of the JSON object a line; text that is not JSON as it is.
Markup scaling_of(const std::string& json_text) {
  const auto json = try_json(json_text);
  if (json.is_discarded() || !json.is_object()) return markup("{}", stated(json_text));
  Markup out;
  for (const auto& [name, value] : json.items()) {
    if (name == "certificate" || name == "calibrated" || name == "due") continue;
    const std::string text = value.is_string() ? value.get<std::string>() : printable_json(value);
    if (!out.value.empty()) out += markup("<br/>");
    out += markup("{}: {}", Text(name), stated(text));
  }
  return out.value.empty() ? markup("not stated") : out;
}

}  // namespace

Markup instruments_part(const ReportInput& input) {
  const db::RunRecord& run = input.run;
  Markup out = markup(
      "<table><caption>Instruments</caption><thead><tr><th scope=\"col\">role, model</th>"
      "<th scope=\"col\">serial, firmware, origin</th><th scope=\"col\">certificate and due date</th>"
      "<th scope=\"col\">scaling used</th></tr></thead><tbody>\n");
  bool overdue = false;
  for (const db::DeviceRecord& device : run.devices) {
    const InstrumentCalibration fields = calibration_of(device, input.laboratory.instruments);
    Markup words = markup("certificate: {}", stated(fields.certificate));
    if (!fields.calibrated_by.empty() || !fields.calibrated_on.empty())
      words += markup("<br/>calibrated by {} on {}", stated(fields.calibrated_by), stated(fields.calibrated_on));
    if (due_state(fields, run.started_utc) == DueState::kOverdue) {
      overdue = true;
      words += markup(
          "<br/><span class=\"fail\"><span class=\"sign\">✗</span> OVERDUE since {} when the run was made</span>",
          Text(fields.due));
    } else {
      words += markup("<br/>due: {}", stated(fields.due));
    }
    if (fields.stated_u) words += markup("<br/>{}", Text(in_words(*fields.stated_u, input.unit)));
    if (!fields.note.empty()) words += markup("<br/>{}", Text(fields.note));
    for (const std::string& remark : fields.remarks)
      words += markup("<br/><span class=\"doubt\"><span class=\"sign\">▲</span> {}</span>", Text(remark));
    out +=
        markup("<tr><th scope=\"row\">{}<br/>{}</th><td>{}<br/>firmware: {}<br/>{}</td><td>{}</td><td>{}</td></tr>\n",
               stated(fields.role), stated(fields.model), stated(fields.serial), stated(device.firmware),
               stated(device.origin), words, scaling_of(without_placeholders(device.calibration_json)));
  }
  if (run.devices.empty()) out += markup("<tr><td colspan=\"4\">not stated</td></tr>\n");
  out += markup("</tbody></table>\n");
  if (overdue)
    out += markup(
        "<p class=\"fail\"><span class=\"sign\">✗</span> At least one instrument was overdue for calibration when the "
        "run was made: its readings are not covered by its certificate. The date of the run counts, not that of the "
        "report.</p>\n");
  return out;
}

}  // namespace tactbench::analysis
