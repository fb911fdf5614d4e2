// Sensor type file and limits file.
#include <fmt/format.h>

#include "analysis/statistics/conformity/verdict.h"
#include "bench/config/config.h"
#include "db/run_store.h"

namespace tactbench::bench {

using sequences::TomlDocument;
using sequences::TomlTable;

namespace {

SensorType sensor_type_of(const TomlDocument& document) {
  const TomlTable root = document.root();
  SensorType type;
  type.text = document.text();
  (void)root.integer("schema", 1, 1);
  type.name = root.name("name");
  type.rows = static_cast<int>(root.integer("rows", 1, 64));
  type.columns = static_cast<int>(root.integer("columns", 1, 64));
  type.pitch_mm = root.number_in("pitch_mm", 2.54, 0.01, 100.0);
  type.taxel_area_mm2 = root.number_in("taxel_area_mm2", type.pitch_mm * type.pitch_mm, 1e-4, 1e4);
  type.orientation_deg = root.number_in("orientation_deg", 0.0, 0.0, 360.0);
  std::tie(type.output_low_v, type.output_high_v) = root.span("output_range_v", {0.0, 5.0});
  type.full_scale = root.word("full_scale", {"highest mean output of the run"});
  root.finish();
  return type;
}

}  // namespace

SensorType read_sensor_type(const std::string& path, const std::vector<sequences::Override>& overrides) {
  TomlDocument document = TomlDocument::from_file(path);
  for (const sequences::Override& override_value : overrides) document.set(override_value);
  return sensor_type_of(document);
}

SensorType parse_sensor_type(const std::string& text, const std::string& name) {
  return sensor_type_of(TomlDocument::from_text(text, name));
}

namespace {

analysis::Limits::Mpe mpe_of(const TomlTable& row) {
  analysis::Limits::Mpe mpe;
  if (row.has("span_psi") == row.has("pressure_psi"))
    row.fail(row.has("span_psi") ? "span_psi" : "pressure_psi",
             "an [[mpe]] is of one level or of a span, and it names " +
                 std::string(row.has("span_psi") ? "both" : "neither"),
             "write pressure_psi = 20, or span_psi = [4, 60]");
  if (row.has("span_psi"))
    std::tie(mpe.low_psi, mpe.high_psi) = row.span("span_psi", {0.0, 0.0});
  else
    mpe.low_psi = mpe.high_psi = row.number("pressure_psi");
  mpe.mpe_psi = row.number("mpe_psi");
  if (!(mpe.mpe_psi > 0.0)) row.fail("mpe_psi", "a maximum permissible error is above 0", "write mpe_psi = 2.0");
  mpe.share = row.number_in("taxels_percent", 95.0, 1.0, 100.0) / 100.0;
  row.finish();
  return mpe;
}

analysis::Limits limits_of(const TomlDocument& document) {
  const TomlTable root = document.root();
  analysis::Limits limits;
  limits.toml = document.text();
  limits.sha256 = db::sha256_hex(limits.toml);
  (void)root.integer("schema", 1, 1);
  limits.name = root.name("name");
  limits.rule = *analysis::decision_rule_from(
      root.word("rule", "default", {"default", "simple", "guarded", "four-way", "report-only"}));
  limits.mean_compensation_error_psi = root.number("mean_compensation_error_psi");
  limits.worst_taxel_error_psi = root.number("worst_taxel_error_psi");
  limits.distance_of_mean_fs = root.number("distance_of_mean_percent_fs") / 100.0;
  limits.unfit_taxels = root.number("unfit_taxels");
  for (const TomlTable& row : root.tables("mismatch")) {
    analysis::Limits::Mismatch mismatch;
    mismatch.pressure_psi = row.number("pressure_psi");
    mismatch.std_fs = row.number("std_percent_fs") / 100.0;
    row.finish();
    limits.mismatch.push_back(mismatch);
  }
  for (const TomlTable& row : root.tables("mpe")) limits.mpe.push_back(mpe_of(row));
  root.finish();
  return limits;
}

}  // namespace

analysis::Limits read_limits(const std::string& path) { return limits_of(TomlDocument::from_file(path)); }
analysis::Limits parse_limits(const std::string& text, const std::string& name) {
  return limits_of(TomlDocument::from_text(text, name));
}

}  // namespace tactbench::bench
