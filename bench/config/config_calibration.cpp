#include "bench/config/config_calibration.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "analysis/statistics/uncertainty/instrument_calibration.h"
#include "bench/common/error.h"

namespace tactbench::bench {

std::string read_date(const sequences::TomlTable& table, const std::string& key) {
  std::string text = table.date_text(key);
  if (text.empty() || analysis::is_date(text) || analysis::is_placeholder(text)) return text;
  table.fail(key, fmt::format("'{}' is not a date", text),
             "write it as \"2026-01-31\" (year, month, day), or leave it empty");
}

StatedCalibration read_stated_calibration(const sequences::TomlTable& table, const std::string& uncertainty_key,
                                          double most) {
  StatedCalibration stated;
  stated.certificate = table.text("certificate", "");
  stated.calibrated = read_date(table, "calibrated");
  stated.due = read_date(table, "due");
  stated.expanded_uncertainty = table.number_in(uncertainty_key, 0.0, 0.0, most);
  const auto calibrated = analysis::day_of(stated.calibrated), due = analysis::day_of(stated.due);
  if (calibrated && due && *due <= *calibrated) {
    table.fail("due", fmt::format("due on {}, which is not after the calibration of {}", stated.due, stated.calibrated),
               "correct the wrong date");
  }
  return stated;
}

void read_chain(const sequences::TomlTable& table, devices::Origin origin, const std::string& drift_key,
                const std::string& input_key, double most, StatedCalibration& stated) {
  const std::vector<std::string> words = {"chain", "transducer"};
  if (origin == devices::Origin::kSimulated)
    stated.covers = table.word("certificate_covers", "chain", words);
  else if (table.has("certificate_covers"))
    stated.covers = table.word("certificate_covers", words);
  stated.drift = table.number_in(drift_key, 0.0, 0.0, most);
  stated.input_limit = table.number_in(input_key, 0.0, 0.0, most);
  if (stated.covers == "chain" && stated.input_limit > 0.0)
    table.fail(input_key, "the certificate covers the whole chain, and so the input that reads it",
               fmt::format("remove {}, or write certificate_covers = \"transducer\"", input_key));
  if (stated.covers == "transducer" && !(stated.input_limit > 0.0))
    table.fail("certificate_covers",
               fmt::format("the certificate covers the transducer alone, and {}, the limit of error of what reads it, "
                           "is not stated",
                           input_key),
               fmt::format("add {} from that instrument's data sheet, or write \"chain\" where both were calibrated "
                           "together",
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
    throw Error(ExitCode::kUsage, "TB-BENCH-COVERS",
                fmt::format("{}: not stated what the certificate covers", fmt::join(unclear, ", ")), config.file,
                "write certificate_covers = \"chain\" where it was calibrated with what reads it here, else "
                "\"transducer\" and the limit of error of what reads it");
  if (found.empty()) return;
  throw Error(ExitCode::kUsage, "TB-BENCH-FILL-IN",
              fmt::format("the bench file is not filled in: {}", fmt::join(found, ", ")), config.file,
              "replace each FILL-IN by the value on the instrument or its certificate; \"\" where there is none");
}

}  // namespace tactbench::bench
