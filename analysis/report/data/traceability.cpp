#include "analysis/report/data/traceability.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "analysis/json_fields.h"
#include "analysis/report/data/data.h"
#include "analysis/report/report_facts.h"

namespace tactbench::analysis {

namespace {

struct TracedQuantity {
  const char* title;     // of the row
  const char* quantity;  // begins a sentence
  const char* role;      // the device's begins with it
  const char* device;    // in words
};

constexpr TracedQuantity kTracedPressure = {"traceability of the pressure", "Pressure", "pressure reference",
                                            "the pressure reference"};
constexpr TracedQuantity kTracedForce = {"traceability of the force", "Force", "force sensor", "the force sensor"};
constexpr TracedQuantity kTracedPlace = {"traceability of the position", "Place", "stage", "the stage"};

std::string instrument_name(const InstrumentCalibration& calibration) {
  return fmt::format("{}, serial {}", calibration.model.empty() ? "model not stated" : calibration.model,
                     calibration.serial.empty() ? "not stated" : calibration.serial);
}

Traceability traced_to(const TracedQuantity& traced, const db::RunRecord& run, std::span<const InstrumentNote> notes,
                       PressureUnit unit) {
  const auto device = std::ranges::find_if(
      run.devices, [&](const db::DeviceRecord& record) { return record.role.starts_with(traced.role); });
  const std::string no = fmt::format("{} not traceable", traced.quantity);
  if (device == run.devices.end())
    return {traced.title, fmt::format("{}: the run does not state by which instrument it was measured.", no), false};
  const InstrumentCalibration calibration = calibration_of(*device, notes);
  if (!calibration.traceable())
    return {traced.title,
            fmt::format("{}: no certificate of {} ({}) is stated.", no, traced.device, instrument_name(calibration)),
            false};
  std::string statement = fmt::format("{} measured by {}: certificate {}", traced.quantity,
                                      instrument_name(calibration), calibration.certificate);
  if (!calibration.calibrated_by.empty()) statement += fmt::format(" of {}", calibration.calibrated_by);
  if (!calibration.calibrated_on.empty()) statement += fmt::format(", calibrated {}", calibration.calibrated_on);
  if (calibration.stated_u) statement += ", " + display_text(*calibration.stated_u, unit);
  const bool overdue = due_state(calibration, run.started_utc) == DueState::kOverdue;
  statement += calibration.due.empty() ? std::string(", due date not stated.")
               : overdue
                   ? fmt::format(". Overdue since {} when measured: not covered by the certificate.", calibration.due)
                   : fmt::format(", due {}.", calibration.due);
  return {traced.title, statement, !overdue};
}

Traceability pressure_traceability(const db::RunRecord& run, std::span<const InstrumentNote> notes, PressureUnit unit) {
  if (has_reference(run)) {
    Traceability traced = traced_to(kTracedPressure, run, notes, unit);
    if (const auto beyond = reference_uncertainty(run, notes).beyond; traced.traceable && beyond) {
      traced.traceable = false;
      traced.statement += fmt::format(" But {}, and no U is stated there.", display_text(*beyond, unit));
    }
    return traced;
  }
  return {kTracedPressure.title,
          "Pressure not independently traceable: there was no separate measurement standard; the regulator's feedback "
          "was used.",
          false};
}

// The report's runs with the words that name them.
std::vector<std::pair<std::string, const db::RunRecord*>> runs_of(const ReportInput& input) {
  std::vector<std::pair<std::string, const db::RunRecord*>> runs = {{"this run", &input.run}};
  for (const HeldOut& held_out : input.held_out) runs.emplace_back(held_out.title, &held_out.run);
  return runs;
}

}  // namespace

Traceability force_traceability(const db::RunRecord& run, std::span<const InstrumentNote> notes) {
  return traced_to(kTracedForce, run, notes, PressureUnit::kPsi);
}

std::vector<Traceability> traceability_of(const ReportInput& input, PressureUnit unit) {
  const std::vector<InstrumentNote>& notes = input.laboratory.instruments;
  std::vector<Traceability> all;
  if (!input.history.presses || !input.evaluation.levels.empty())
    all.push_back(pressure_traceability(input.run, notes, unit));
  if (input.history.presses) {
    all.push_back(force_traceability(input.run, notes));
    all.push_back(traced_to(kTracedPlace, input.run, notes, unit));
  }
  return all;
}

std::string traceability_json(const ReportInput& input) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Traceability& one : traceability_of(input, PressureUnit::kPsi))
    list.push_back({{"quantity", one.title.substr(one.title.rfind(' ') + 1)}, JSON_FIELDS(one, traceable, statement)});
  return json_text(list);
}

std::vector<std::string> instrument_warnings(const ReportInput& input) {
  std::vector<std::string> out;
  const auto add = [&](const std::string& text) {
    if (std::ranges::find(out, text) == out.end()) out.push_back(text);
  };
  for (const auto& [name, run] : runs_of(input)) {
    const auto beyond = reference_uncertainty(*run, input.laboratory.instruments).beyond;
    if (beyond) add(fmt::format("{}: {}", name, display_text(*beyond, input.unit)));
    for (const db::DeviceRecord& device : run->devices) {
      const InstrumentCalibration calibration = calibration_of(device, input.laboratory.instruments);
      const std::string who = fmt::format("{} ({})", device.role, instrument_name(calibration));
      if (due_state(calibration, run->started_utc) == DueState::kOverdue)
        add(fmt::format("{}: overdue for calibration since {} when measured", who, calibration.due));
      for (const std::string& remark : calibration.remarks) add(fmt::format("{}: {}", who, remark));
    }
  }
  return out;
}

}  // namespace tactbench::analysis
