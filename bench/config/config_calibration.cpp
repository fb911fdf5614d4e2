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

std::vector<std::string> placeholders_of(const BenchConfig& config) {
  std::vector<std::string> found;
  for (const sequences::Setting& setting : config.settings)
    if (analysis::is_placeholder(setting.value)) found.push_back(fmt::format("{} ({})", setting.key, setting.origin));
  return found;
}

void refuse_placeholders(const BenchConfig& config) {
  if (config.origin != devices::Origin::kHardware) return;
  const std::vector<std::string> found = placeholders_of(config);
  if (found.empty()) return;
  throw Error(ExitCode::kUsage, "TB-BENCH-FILL-IN",
              fmt::format("the bench file is not filled in: {}", fmt::join(found, ", ")), config.file,
              "replace each FILL-IN by the value on the instrument or its certificate; \"\" where there is none");
}

}  // namespace tactbench::bench
