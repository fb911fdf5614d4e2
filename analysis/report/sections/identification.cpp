#include <nlohmann/json.hpp>

#include "analysis/counted.h"
#include "analysis/documents/run_metadata.h"
#include "analysis/json_io.h"
#include "analysis/report/data/traceability.h"
#include "analysis/report/parts.h"
#include "analysis/report/sections/sections.h"

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

// The operator's entry, else as the run stored it with the scanner.
std::string cable_of(const Laboratory& laboratory, const db::DeviceRecord* scanner) {
  if (!laboratory.cable.empty() || scanner == nullptr) return laboratory.cable;
  const auto json = try_json(scanner->calibration_json);
  const bool there = json.is_object() && json.contains("cable") && json["cable"].is_string();
  return there ? json["cable"].get<std::string>() : std::string();
}

// As typed with the run, else by the laboratory file; both where they differ.
std::string order_of(const db::RunRecord& run, const Laboratory& laboratory) {
  const std::map<std::string, std::string> metadata = metadata_of(run);
  const auto typed = metadata.find("order");
  if (typed == metadata.end()) return laboratory.order;
  const bool differs = !laboratory.order.empty() && laboratory.order != typed->second;
  return differs ? fmt::format("{} (laboratory file: {})", typed->second, laboratory.order) : typed->second;
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

// As entered, one a line; what is not a list of settings as it stands.
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
  const bool calibrates = states_uncertainty(input);
  const int rows = input.fit.rows > 0 ? input.fit.rows : input.health.rows;
  const int columns = input.fit.columns > 0 ? input.fit.columns : input.health.columns;

  Markup out = section_start("identification", "Identification");
  out += pairs_table(calibrates ? "Item calibrated" : "Item tested",
                     {{"sensor, serial number", line(stated(run.sensor_serial))},
                      {"sensor type", line(stated(input.sensor ? input.sensor->type : ""))},
                      {"array", markup("{} × {}", Text(counted(rows, "row")), Text(counted(columns, "column")))},
                      {"scanner electronics, serial number", line(stated(scanner_serial_of(run, input.sensor)))},
                      {"scanner firmware", line(stated(scanner != nullptr ? scanner->firmware : ""))},
                      {"cable", line(stated(cable_of(laboratory, scanner)))},
                      {"received", line(stated(laboratory.received))},
                      {"condition when received", line(stated(laboratory.condition))},
                      {"note on the sensor", line(stated(input.sensor ? input.sensor->note : ""))}});
  const bool accredited = is_certificate(input);
  std::vector<Pair> laboratory_rows = {
      {"laboratory", line(stated(laboratory.laboratory))},
      {"address", line(stated(laboratory.address))},
      {calibrates ? "place of the calibration" : "place of the test", line(stated(laboratory.place))},
      {"customer", line(stated(laboratory.customer))},
      {"address of the customer", line(stated(laboratory.customer_address))},
      {"order", line(stated(order_of(run, laboratory)))},
      {"accreditation", accredited ? markup("No. {}", Text(laboratory.accreditation))
                                   : line(Text("This report was not issued by an accredited laboratory."))}};
  const std::vector<Traceability> traced = traceability_of(input, input.unit);
  for (const Traceability& one : traced) laboratory_rows.push_back({one.title.c_str(), line(Text(one.statement))});
  laboratory_rows.push_back({"remarks", line(stated(laboratory.remarks))});
  out += pairs_table("Laboratory and customer", laboratory_rows);
  std::vector<Pair> run_rows = {
      {"run number", markup("{}", run.run)},
      {"UUID", code(run.uuid)},
      {"origin of the data", line(stated(run.origin))},
      {"outcome",
       markup("{}{}{}", Text(db::to_string(run.outcome)), Text(run.reason.empty() ? "" : ": "), Text(run.reason))},
      {"declared void", line(Text(run.is_void() ? fmt::format("VOID: {}", run.void_reason) : "no"))},
      {"vented and retracted at the end", line(Text(db::to_string(run.safe_state)))},
      {"operator", line(stated(run.operator_name))},
      {"purpose", line(stated(run.purpose))}};
  // No word of a person's own can pass for one of the report's.
  const std::map<std::string, std::string> metadata = metadata_of(run);
  std::vector<std::string> names;
  for (const auto& [key, value] : metadata) names.push_back(key == "lot" || key == "order" ? key : "metadata " + key);
  for (std::size_t i = 0; const auto& [key, value] : metadata)
    run_rows.push_back({names[i++].c_str(), line(Text(value))});
  for (Pair& more : std::vector<Pair>{
           {calibrates ? "calibration started (UTC)" : "measurement started (UTC)", line(moment(run.started_utc))},
           {calibrates ? "calibration ended (UTC)" : "measurement ended (UTC)", line(moment(run.ended_utc))},
           {"bench", line(stated(run.bench_id))},
           {"computer", line(stated(run.host))},
           {"frames stored", markup("{}", input.frame_count)},
           {"frames evaluated", markup("{}", input.evaluation.frames)},
           {"further runs used", further_runs(input)},
           {"seeds", markup("noise and faults {}, sensor {}", run.seed, run.sensor_seed)},
           {"settings changed on the command line", settings_changed(run.overrides_json)}})
    run_rows.push_back(std::move(more));
  out += pairs_table("Run", run_rows);
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
       {"SHA-256 of the limits file", code(input.judgement.limits_sha256)}});
  return out;
}

}  // namespace tactbench::analysis
