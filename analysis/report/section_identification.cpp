#include <nlohmann/json.hpp>

#include "analysis/json_io.h"
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

// As typed, else as the run stored it with the scanner.
std::string cable_of(const Laboratory& laboratory, const db::DeviceRecord* scanner) {
  if (!laboratory.cable.empty() || scanner == nullptr) return laboratory.cable;
  const auto json = try_json(scanner->calibration_json);
  const bool there = json.is_object() && json.contains("cable") && json["cable"].is_string();
  return there ? json["cable"].get<std::string>() : std::string();
}

Markup further_runs(const ReportInput& input) {
  Markup out;
  for (const db::RunRecord& run : input.further) {
    std::string names;
    for (const db::SequenceRecord& sequence : run.sequences)
      names += fmt::format("{}{}", names.empty() ? "" : ", ", sequence.name);
    if (!out.value.empty()) out += markup("<br/>");
    out += markup("run {}: {}, {}", run.run, stated(names), moment(run.started_utc));
  }
  return out.value.empty() ? markup("none") : out;
}

// As they were typed, one a line; what is not a list of settings as it stands.
Markup settings_changed(const std::string& overrides_json) {
  const auto json = try_json(overrides_json);
  if (!json.is_array()) return line(stated(overrides_json));
  Markup out;
  for (const auto& setting : json) {
    if (!setting.is_object() || !setting.contains("key") || !setting["key"].is_string() || !setting.contains("value") ||
        !setting["value"].is_string())
      return line(stated(overrides_json));
    if (!out.value.empty()) out += markup("<br/>");
    out += markup("{} = {}", Text(setting["key"].get<std::string>()), Text(setting["value"].get<std::string>()));
  }
  return out.value.empty() ? markup("none") : out;
}

}  // namespace

Markup identification_section(const ReportInput& input) {
  const db::RunRecord& run = input.run;
  const db::DeviceRecord* scanner = scanner_of(run);
  const Laboratory& laboratory = input.laboratory;
  const std::string scanner_serial =
      !run.scanner_serial.empty() || !input.sensor ? run.scanner_serial : input.sensor->scanner_serial;
  const int rows = input.fit.rows > 0 ? input.fit.rows : input.health.rows;
  const int columns = input.fit.columns > 0 ? input.fit.columns : input.health.columns;

  Markup out = section_start("identification", "Identification");
  out +=
      pairs_table("Item calibrated", {{"sensor, serial number", line(stated(run.sensor_serial))},
                                      {"sensor type", line(stated(input.sensor ? input.sensor->type : ""))},
                                      {"array", markup("{} rows × {} columns", rows, columns)},
                                      {"scanner electronics, serial number", line(stated(scanner_serial))},
                                      {"scanner firmware", line(stated(scanner != nullptr ? scanner->firmware : ""))},
                                      {"cable", line(stated(cable_of(laboratory, scanner)))},
                                      {"received", line(stated(laboratory.received))},
                                      {"condition when received", line(stated(laboratory.condition))},
                                      {"note on the sensor", line(stated(input.sensor ? input.sensor->note : ""))}});
  const bool accredited = is_certificate(input);
  out += pairs_table(
      "Laboratory and customer",
      {{"laboratory", line(stated(laboratory.laboratory))},
       {"address", line(stated(laboratory.address))},
       {"place of the calibration", line(stated(laboratory.place))},
       {"customer", line(stated(laboratory.customer))},
       {"address of the customer", line(stated(laboratory.customer_address))},
       {"order", line(stated(laboratory.order))},
       {"accreditation", accredited ? markup("No. {}", Text(laboratory.accreditation))
                                    : line(Text("This report was not issued by an accredited laboratory."))},
       {"traceability of the pressure",
        line(Text(has_reference(run) ? "Pressure measured by a pressure reference separate from the regulator; for its "
                                       "certificate see Instruments."
                                     : "Pressure not independently traceable: no separate pressure reference took "
                                       "part, the regulator's feedback stands in."))},
       {"remarks", line(stated(laboratory.remarks))}});
  out += pairs_table("Run", {{"run number", markup("{}", run.run)},
                             {"UUID", code(run.uuid)},
                             {"origin of the data", line(stated(run.origin))},
                             {"outcome", markup("{}{}{}", Text(db::to_string(run.outcome)),
                                                Text(run.reason.empty() ? "" : ": "), Text(run.reason))},
                             {"void", line(Text(run.is_void() ? fmt::format("VOID: {}", run.void_reason) : "no"))},
                             {"safe state at the end", line(Text(db::to_string(run.safe_state)))},
                             {"operator", line(stated(run.operator_name))},
                             {"purpose", line(stated(run.purpose))},
                             {"calibration started (UTC)", line(moment(run.started_utc))},
                             {"calibration ended (UTC)", line(moment(run.ended_utc))},
                             {"bench", line(stated(run.bench_id))},
                             {"computer", line(stated(run.host))},
                             {"frames stored", markup("{}", input.frame_count)},
                             {"frames evaluated", markup("{}", input.evaluation.frames)},
                             {"further runs used", further_runs(input)},
                             {"seeds", markup("noise and faults {}, sensor {}", run.seed, run.sensor_seed)},
                             {"settings changed on the command line", settings_changed(run.overrides_json)}});
  out += instruments_part(input);
  out += method_part(input);
  out += pairs_table(
      "Program and files",
      {{"program of the run", markup("{}, commit {}{}", stated(run.program_version), stated(run.git_commit),
                                     Text(run.git_dirty ? ", source changed since that commit (dirty)" : ""))},
       {"build", line(stated(run.build_id))},
       {"program of this report", line(stated(input.program_version))},
       {"SHA-256 of the run's content", code(run.content_sha256)},
       {"SHA-256 of the bench configuration", code(run.bench_sha256)},
       {"SHA-256 of the sensor type file", code(run.sensor_sha256)},
       {"SHA-256 of the models", code(input.fit.taxels.empty() ? "" : model_sha256(input.fit))},
       {"SHA-256 of the laboratory file", code(laboratory.sha256)},
       {"SHA-256 of the limits file", code(input.verdicts.empty() ? "" : input.verdicts.front().limits_sha256)}});
  return out;
}

}  // namespace tactbench::analysis
