#include "bench/config/calibration_text.h"

#include <fmt/format.h>

#include <algorithm>

#include "analysis/statistics/uncertainty/reference_uncertainty.h"
#include "bench/config/config_calibration.h"

namespace tactbench::bench {

using analysis::DueState;
using analysis::InstrumentCalibration;

std::string calibration_text(const InstrumentCalibration& calibration, const std::string& day,
                             analysis::PressureUnit unit) {
  std::string text =
      fmt::format("certificate {}", calibration.certificate.empty() ? "not stated" : calibration.certificate);
  if (!calibration.calibrated_on.empty()) text += fmt::format(", calibrated {}", calibration.calibrated_on);
  const DueState state = due_state(calibration, day);
  text += state == DueState::kNotStated ? std::string(", no due date stated")
          : state == DueState::kOverdue ? fmt::format(", OVERDUE since {}", calibration.due)
                                        : fmt::format(", due {}", calibration.due);
  if (calibration.stated_u) text += ", " + display_text(*calibration.stated_u, unit);
  for (const std::string& remark : calibration.remarks) text += fmt::format("; {}", remark);
  return text;
}

std::vector<std::string> calibration_warnings(const BenchConfig& config, const std::vector<db::DeviceRecord>& records,
                                              const std::string& day, const std::vector<sequences::Step>& steps,
                                              analysis::PressureUnit unit) {
  std::vector<std::string> lines;
  for (const db::DeviceRecord& record : records) {
    const InstrumentCalibration calibration = analysis::calibration_of(record);
    if (due_state(calibration, day) != DueState::kOverdue) continue;
    lines.push_back(fmt::format("{} ({}, serial {}) is OVERDUE for calibration since {}", record.role, record.model,
                                calibration.serial.empty() ? "not stated" : calibration.serial, calibration.due));
  }
  db::RunRecord planned;
  planned.devices = records;
  bool first = true;
  for (const sequences::Step& step : steps) {
    if (step.kind != sequences::StepKind::kMeasure) continue;
    const double level = step.setpoint.value();
    planned.lowest_psi = first ? level : std::min(planned.lowest_psi, level);
    planned.highest_psi = first ? level : std::max(planned.highest_psi, level);
    first = false;
  }
  if (const auto beyond = analysis::reference_uncertainty(planned).beyond)
    lines.push_back(display_text(*beyond, unit) + "; no U is stated there, and verdicts on errors are inconclusive");
  for (const std::string& place : placeholders_of(config)) lines.push_back(fmt::format("not filled in: {}", place));
  return lines;
}

}  // namespace tactbench::bench
