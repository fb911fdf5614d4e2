#include <nlohmann/json.hpp>

#include "analysis/report/page.h"

namespace tactbench::analysis {
namespace {

using html::markup;
using html::Markup;
using html::stated;
using html::Text;

Markup line(const html::Safe& content) { return markup("{}", content); }

const db::DeviceRecord* scanner_of(const db::RunRecord& run) {
  for (const db::DeviceRecord& device : run.devices) {
    if (device.role.find("scanner") != std::string::npos) return &device;
  }
  return nullptr;
}

// What scaled the raw counts of a device, one member of the JSON object a line; text that is not JSON as it is.
Markup calibration(const std::string& json_text) {
  const auto json = nlohmann::json::parse(json_text, nullptr, false);
  if (json.is_discarded() || !json.is_object()) return line(stated(json_text));
  Markup out;
  bool certificate = false;
  for (const auto& [name, value] : json.items()) {
    const std::string text = value.is_string() ? value.get<std::string>()
                                               : value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    if (!out.value.empty()) out += markup("<br/>");
    certificate = certificate || name.find("certificate") != std::string::npos;
    out += markup("{}: {}", Text(name), stated(text));
  }
  if (!certificate) {
    if (!out.value.empty()) out += markup("<br/>");
    out += markup("certificate: not stated");
  }
  return out;
}

Markup instruments(const db::RunRecord& run) {
  Markup out = markup(
      "<table><caption>Instruments</caption><thead><tr><th scope=\"col\">role</th><th scope=\"col\">model</th>"
      "<th scope=\"col\">serial</th><th scope=\"col\">firmware</th><th scope=\"col\">origin</th>"
      "<th scope=\"col\">calibration used</th></tr></thead><tbody>\n");
  for (const db::DeviceRecord& device : run.devices) {
    out += markup("<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
                  stated(device.role), stated(device.model), stated(device.serial), stated(device.firmware),
                  stated(device.origin), calibration(device.calibration_json));
  }
  if (run.devices.empty()) out += markup("<tr><td colspan=\"6\">not stated</td></tr>\n");
  out += markup("</tbody></table>\n");
  return out;
}

Markup method(const db::RunRecord& run) {
  Markup out = markup(
      "<table><caption>Method: sequences run</caption><thead><tr><th scope=\"col\">sequence</th>"
      "<th scope=\"col\" class=\"n\">repeats</th><th scope=\"col\" class=\"n\">frames a repeat</th>"
      "<th scope=\"col\">SHA-256 of the recipe</th></tr></thead><tbody>\n");
  for (const db::SequenceRecord& sequence : run.sequences) {
    out += markup("<tr><th scope=\"row\">{}</th><td class=\"n\">{}</td><td class=\"n\">{}</td><td>{}</td></tr>\n",
                  stated(sequence.name), sequence.repeats, sequence.frames_per_repeat, code(sequence.recipe_sha256));
  }
  if (run.sequences.empty()) out += markup("<tr><td colspan=\"4\">not stated</td></tr>\n");
  out += markup("</tbody></table>\n");
  return out;
}

}  // namespace

Markup identification_section(const ReportInput& input) {
  const db::RunRecord& run = input.run;
  const db::DeviceRecord* scanner = scanner_of(run);
  const std::string scanner_serial =
      !run.scanner_serial.empty() || !input.sensor ? run.scanner_serial : input.sensor->scanner_serial;

  Markup out = section_start("identification", "Identification");
  out +=
      pairs_table("Item calibrated", {{"sensor, serial number", line(stated(run.sensor_serial))},
                                      {"sensor type", line(stated(input.sensor ? input.sensor->type : ""))},
                                      {"array", markup("{} rows × {} columns", input.fit.rows, input.fit.columns)},
                                      {"scanner electronics, serial number", line(stated(scanner_serial))},
                                      {"scanner firmware", line(stated(scanner != nullptr ? scanner->firmware : ""))},
                                      {"cable", line(stated(""))},
                                      {"note on the sensor", line(stated(input.sensor ? input.sensor->note : ""))}});
  out += pairs_table("Run", {{"run number", markup("{}", run.run)},
                             {"UUID", code(run.uuid)},
                             {"origin of the data", line(stated(run.origin))},
                             {"outcome", markup("{}{}{}", Text(db::to_string(run.outcome)),
                                                Text(run.reason.empty() ? "" : ": "), Text(run.reason))},
                             {"safe state at the end", line(Text(db::to_string(run.safe_state)))},
                             {"operator", line(stated(run.operator_name))},
                             {"purpose", line(stated(run.purpose))},
                             {"calibration started (UTC)", line(moment(run.started_utc))},
                             {"calibration ended (UTC)", line(moment(run.ended_utc))},
                             {"bench", line(stated(run.bench_id))},
                             {"computer", line(stated(run.host))},
                             {"frames stored", markup("{}", input.frame_count)},
                             {"frames evaluated", markup("{}", input.evaluation.frames)},
                             {"seeds", markup("noise and faults {}, sensor {}", run.seed, run.sensor_seed)},
                             {"settings changed on the command line", line(stated(run.overrides_json))}});
  out += pairs_table(
      "Laboratory", {{"laboratory", line(stated(""))},
                     {"place", line(stated(""))},
                     {"customer", line(stated(""))},
                     {"environment", line(stated(""))},
                     {"date of issue", line(stated(""))},
                     {"authorised by", line(stated(""))},
                     {"accreditation", line(Text("This report was not issued by an accredited laboratory."))},
                     {"traceability of the pressure",
                      line(Text(has_reference(run)
                                    ? "Pressure measured by a pressure reference separate from the regulator; for its "
                                      "certificate see Instruments."
                                    : "Pressure not independently traceable: no separate pressure reference took part, "
                                      "the regulator's feedback stands in."))}});
  out += instruments(run);
  out += method(run);
  out += pairs_table(
      "Program and files",
      {{"program of the run", markup("{}, commit {}{}", stated(run.program_version), stated(run.git_commit),
                                     Text(run.git_dirty ? ", source changed since that commit (dirty)" : ""))},
       {"build", line(stated(run.build_id))},
       {"program of this report", line(stated(input.program_version))},
       {"SHA-256 of the run's content", code(run.content_sha256)},
       {"SHA-256 of the bench configuration", code(run.bench_sha256)},
       {"SHA-256 of the sensor type file", code(run.sensor_sha256)},
       {"SHA-256 of the limits file", code(input.verdicts.empty() ? "" : input.verdicts.front().limits_sha256)}});
  return out;
}

}  // namespace tactbench::analysis
