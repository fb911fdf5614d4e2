#include "bench/config/config_calibration.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "analysis/statistics/uncertainty/instruments.h"
#include "analysis/statistics/uncertainty/reference_uncertainty.h"
#include "bench/common/error.h"

namespace tactbench::bench {

namespace key = sequences::key;

sequences::Key date_key(const char* name, std::string& date, const char* meaning) {
  return key::made({name, "date", "-", "", "`\"\"`", meaning}, [name, &date](const sequences::TomlTable& table) {
    date = table.date_text(name);
    if (date.empty() || analysis::is_date(date) || analysis::is_placeholder(date)) return;
    table.fail(name, fmt::format("'{}' is not a date", date),
               "write it as \"2026-01-31\" (year, month, day), or leave it empty");
  });
}

sequences::KeyTable stated_keys(StatedCalibration& stated, const char* uncertainty_key, const sequences::Unit& unit,
                                const char* certificate_meaning, const char* uncertainty_meaning) {
  return {
      key::text("certificate", stated.certificate, certificate_meaning),
      date_key("calibrated", stated.calibrated, "Date of the calibration, as \"2026-01-31\""),
      date_key("due", stated.due,
               "Last day on which the calibration is valid; figures of later runs that depend on it are inconclusive"),
      key::number(uncertainty_key, stated.expanded_uncertainty, unit, {0.0, 10.0}, uncertainty_meaning)};
}

void check_dates(const sequences::TomlTable& table, const StatedCalibration& stated) {
  const auto calibrated = analysis::day_of(stated.calibrated), due = analysis::day_of(stated.due);
  if (calibrated && due && *due <= *calibrated) {
    table.fail("due", fmt::format("due on {}, which is not after the calibration of {}", stated.due, stated.calibrated),
               "correct the wrong date");
  }
}

sequences::KeyTable chain_keys(StatedCalibration& stated, devices::Origin origin, const ChainKeys& names) {
  const bool simulated = origin == devices::Origin::kSimulated;
  if (simulated) stated.covers = "chain";
  const sequences::Key covers =
      key::word("certificate_covers", stated.covers, {"chain", "transducer"}, names.covers_meaning);
  return {simulated ? covers : key::optional(covers),
          key::number(names.drift, stated.drift, {names.drift_unit}, {0.0, 10.0},
                      "Largest change until the due date, by its history or data sheet"),
          key::number(names.input, stated.input_limit, {names.input_unit}, {0.0, 10.0}, names.input_meaning)};
}

void check_chain(const sequences::TomlTable& table, const StatedCalibration& stated, const std::string& input_key) {
  if (stated.covers == "chain" && stated.input_limit > 0.0)
    table.fail(input_key, "the certificate covers the whole chain, including the input that reads it",
               fmt::format("remove {}, or write certificate_covers = \"transducer\"", input_key));
  if (stated.covers == "transducer" && !(stated.input_limit > 0.0))
    table.fail(
        "certificate_covers",
        fmt::format("the certificate covers only the transducer, but {}, the limit of error of the input that reads "
                    "it, is not stated",
                    input_key),
        fmt::format("add {} from that instrument's data sheet, or write \"chain\" if both were calibrated together",
                    input_key));
}

namespace {

// Tables that state a certificate, or its U, without saying what it covers.
std::vector<std::string> without_covers(const BenchConfig& config) {
  std::vector<std::string> tables;
  const auto look = [&](const StatedCalibration& stated, bool more, const std::string& table) {
    if (stated.covers.empty() && (more || !stated.certificate.empty() || stated.expanded_uncertainty > 0.0))
      tables.push_back(table);
  };
  if (config.reference_independent && !config.reference_gauge)
    look(config.reference_stated, !config.reference_correction.empty(), "[reference]");
  if (config.force) look(config.force->stated, false, "[force]");
  for (const EnvironmentSensor& sensor : config.environment)
    look(sensor.stated, false, fmt::format("[[environment.sensor]] {}", sensor.quantity));
  return tables;
}

}  // namespace

std::vector<std::string> placeholders_of(const BenchConfig& config) {
  std::vector<std::string> found;
  for (const sequences::Setting& setting : config.settings)
    if (analysis::is_placeholder(setting.value)) found.push_back(fmt::format("{} ({})", setting.key, setting.origin));
  return found;
}

void refuse_placeholders(const BenchConfig& config) {
  if (config.origin != devices::Origin::kHardware) return;
  const std::vector<std::string> found = placeholders_of(config), unclear = without_covers(config);
  if (found.empty() && !unclear.empty())
    throw Error("TB-BENCH-COVERS",
                fmt::format("{}: what the certificate covers is not stated", fmt::join(unclear, ", ")), config.file);
  if (found.empty()) return;
  throw Error("TB-BENCH-FILL-IN", fmt::format("the bench file still contains FILL-IN: {}", fmt::join(found, ", ")),
              config.file);
}

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
