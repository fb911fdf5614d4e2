#include <algorithm>
#include <nlohmann/json.hpp>

#include "analysis/json_io.h"
#include "analysis/report/page.h"

namespace tactbench::analysis {

using html::markup;
using html::Markup;
using html::stated;
using html::Text;

namespace {

struct CertificateFields {
  std::string certificate, by, on, due, note;
};

// What the run stored with the instrument, and what was typed for its serial number.
CertificateFields certificate_of(const db::DeviceRecord& device, const Laboratory& laboratory) {
  CertificateFields fields;
  const auto json = try_json(device.calibration_json);
  const auto text = [&](const char* name) {
    const bool there = json.is_object() && json.contains(name) && json[name].is_string();
    return there ? json[name].get<std::string>() : std::string();
  };
  fields.certificate = text("certificate");
  fields.due = text("due");
  const auto typed = std::ranges::find(laboratory.instruments, device.serial, &InstrumentNote::serial);
  if (typed == laboratory.instruments.end() || device.serial.empty()) return fields;
  if (!typed->certificate.empty()) fields.certificate = typed->certificate;
  if (!typed->due.empty()) fields.due = typed->due;
  fields.by = typed->calibrated_by;
  fields.on = typed->calibrated_on;
  fields.note = typed->note;
  return fields;
}

// What scaled the raw counts, one member of the JSON object a line; text that is not JSON as it is.
Markup scaling_of(const std::string& json_text) {
  const auto json = try_json(json_text);
  if (json.is_discarded() || !json.is_object()) return markup("{}", stated(json_text));
  Markup out;
  for (const auto& [name, value] : json.items()) {
    if (name == "certificate" || name == "due") continue;
    const std::string text = value.is_string() ? value.get<std::string>() : printable_json(value);
    if (!out.value.empty()) out += markup("<br/>");
    out += markup("{}: {}", Text(name), stated(text));
  }
  return out.value.empty() ? markup("not stated") : out;
}

}  // namespace

bool is_overdue(const std::string& due, const std::string& utc) {
  const auto is_date = [](const std::string& text) { return text.size() >= 10 && text[4] == '-' && text[7] == '-'; };
  return is_date(due) && is_date(utc) && due.substr(0, 10) < utc.substr(0, 10);  // ISO dates sort as text
}

Markup instruments_part(const ReportInput& input) {
  const db::RunRecord& run = input.run;
  Markup out = markup(
      "<table><caption>Instruments</caption><thead><tr><th scope=\"col\">role, model</th>"
      "<th scope=\"col\">serial, firmware, origin</th><th scope=\"col\">certificate and due date</th>"
      "<th scope=\"col\">scaling used</th></tr></thead><tbody>\n");
  bool overdue = false;
  for (const db::DeviceRecord& device : run.devices) {
    const CertificateFields fields = certificate_of(device, input.laboratory);
    Markup words = markup("certificate: {}", stated(fields.certificate));
    if (!fields.by.empty() || !fields.on.empty())
      words += markup("<br/>calibrated by {} on {}", stated(fields.by), stated(fields.on));
    if (is_overdue(fields.due, run.started_utc)) {
      overdue = true;
      words += markup(
          "<br/><span class=\"fail\"><span class=\"sign\">✗</span> OVERDUE since {} when the run was made</span>",
          Text(fields.due));
    } else {
      words += markup("<br/>due: {}", stated(fields.due));
    }
    if (!fields.note.empty()) words += markup("<br/>{}", Text(fields.note));
    out +=
        markup("<tr><th scope=\"row\">{}<br/>{}</th><td>{}<br/>firmware: {}<br/>{}</td><td>{}</td><td>{}</td></tr>\n",
               stated(device.role), stated(device.model), stated(device.serial), stated(device.firmware),
               stated(device.origin), words, scaling_of(device.calibration_json));
  }
  if (run.devices.empty()) out += markup("<tr><td colspan=\"4\">not stated</td></tr>\n");
  out += markup("</tbody></table>\n");
  if (overdue)
    out += markup(
        "<p class=\"fail\"><span class=\"sign\">✗</span> At least one instrument was overdue for calibration when the "
        "run was made: its readings are not covered by its certificate.</p>\n");
  return out;
}

}  // namespace tactbench::analysis
