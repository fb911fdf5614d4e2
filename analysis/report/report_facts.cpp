#include "analysis/report/report_facts.h"

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>

#include "analysis/documents/run_json.h"
#include "analysis/identify/stored/model_document.h"
#include "analysis/json_io.h"
#include "analysis/statistics/figures/levels.h"

namespace tactbench::analysis {

const char* direction_text(bool up) { return up ? "increasing" : "decreasing"; }

std::string moment_text(const std::string& utc) {
  std::string words = utc;
  if (words.size() > 10 && words[10] == 'T') words[10] = ' ';
  return doc::stated(words).text;
}

std::string date_of(const std::string& utc) { return doc::stated(utc.substr(0, 10)).text; }

std::string model_name(const SensorModel& fit) {
  return fit.model == kElamFit && !fit.options.linearise ? "ELAM" : label_of(fit);
}

bool is_simulated(const ReportInput& input) {
  const auto simulated = [](const db::RunRecord& run) { return run.origin == "simulated"; };
  return simulated(input.run) || std::ranges::any_of(input.held_out, simulated, &HeldOut::run);
}

bool is_certificate(const ReportInput& input) {
  if (input.laboratory.accreditation.empty() || is_simulated(input) || !states_uncertainty(input)) return false;
  const ReferenceUncertainty reference = reference_uncertainty(input.run, input.laboratory.instruments);
  return has_reference(input.run) && reference.calibration.traceable() && !reference.untraced();
}

bool states_uncertainty(const ReportInput& input) {
  return input.uncertainty && !input.uncertainty->levels.empty() &&
         std::ranges::any_of(input.uncertainty->conditions, &ConditionUncertainty::valid);
}

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

std::string valid_until(const Laboratory& lab, const std::string& measured_utc) {
  if (!lab.valid_until.empty() || lab.recalibrate_after_months <= 0) return lab.valid_until;
  const auto day = day_of(measured_utc);
  if (!day) return {};
  std::chrono::year_month_day until =
      std::chrono::year_month_day(*day) + std::chrono::months(lab.recalibrate_after_months);
  if (!until.ok()) until = until.year() / until.month() / std::chrono::last;
  return fmt::format("{:04}-{:02}-{:02}", static_cast<int>(until.year()), static_cast<unsigned>(until.month()),
                     static_cast<unsigned>(until.day()));
}

std::string cable_of(const ReportInput& input) {
  if (!input.laboratory.cable.empty()) return input.laboratory.cable;
  for (const db::DeviceRecord& device : input.run.devices) {
    if (device.role.find("scanner") == std::string::npos) continue;
    const auto json = try_json(device.calibration_json);
    if (json.is_object() && json.contains("cable") && json["cable"].is_string())
      return json["cable"].get<std::string>();
  }
  return {};
}

std::string order_of(const ReportInput& input) {
  const std::map<std::string, std::string> metadata = metadata_of(input.run);
  const std::string& own = input.laboratory.order;
  const auto typed = metadata.find("order");
  if (typed == metadata.end()) return own;
  return own.empty() || own == typed->second ? typed->second
                                             : fmt::format("{} (laboratory file: {})", typed->second, own);
}

doc::Phrase findings_summary(const Health& health) {
  std::string text;
  const auto add = [&](const std::string& one) { text += (text.empty() ? "" : "; ") + one; };
  const auto left_out = std::ranges::count_if(health.findings, &TaxelHealth::excluded);
  if (left_out > 0) add(fmt::format("{} left out of every figure", left_out));
  if (const int noisy = health.count("noisy"); noisy > 0) add(fmt::format("{} noisy", noisy));
  for (const SwappedLines& swap : health.swaps)
    add(fmt::format("{} {} and {} swapped", swap.rows ? "rows" : "columns", swap.first, swap.second));
  return text.empty() ? doc::Phrase() : doc::Phrase(doc::StyledText{"▲ " + text, doc::TextStyle::kDoubt});
}

Spread spread_of(std::vector<double> values) {
  values = finite_of(values);
  if (values.empty()) return {kNan, kNan, kNan, 0};
  const auto [low, high] = std::ranges::minmax(values);
  return {low, median_of(values), high, values.size()};
}

int fitted_taxels(const SensorModel& fit) { return static_cast<int>(fit.fitted().size()); }

double observable(const LevelFigures& level, double LevelFigures::*figure, int fitted) {
  return level.flat_taxels < fitted ? level.*figure : kNan;
}

}  // namespace tactbench::analysis
