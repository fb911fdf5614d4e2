// Sensor type file and limits file.
#include "bench/config/config.h"
#include "db/run_store.h"
#include "sequences/toml/key_table.h"

namespace tactbench::bench {

using sequences::KeyTable;
using sequences::kOne;
using sequences::kPercent;
using sequences::TomlDocument;
using sequences::TomlTable;
namespace key = sequences::key;

namespace {

constexpr sequences::Unit kPercentOfFullScale{"% of full scale", 1.0, 100.0};

KeyTable type_keys(SensorType& type) {
  return {key::schema(), key::name("name", type.name, "Name of the sensor type; on reports"),
          key::required(key::number("rows", type.rows, kOne, {1, 64}, "Rows of the array")),
          key::required(key::number("columns", type.columns, kOne, {1, 64}, "Columns of the array")),
          key::number("pitch_mm", type.pitch_mm, {"mm"}, {0.01, 100.0}, "Distance of two neighbouring taxels")};
}

KeyTable geometry_keys(SensorType& type) {
  type.taxel_area_mm2 = type.pitch_mm * type.pitch_mm;
  return {key::described(key::number("taxel_area_mm2", type.taxel_area_mm2, {"mm²"}, {1e-4, 1e4},
                                     "Effective area of one taxel, for forces"),
                         "the square of pitch_mm"),
          key::number("orientation_deg", type.orientation_deg, {"°"}, {0.0, 360.0},
                      "Direction of row 0 against the bench's x axis"),
          key::span("output_range_v", type.output_low_v, type.output_high_v, {"V"},
                    "Lowest and highest voltage that the array can give"),
          key::required(key::word("full_scale", type.full_scale, {"highest mean output of the run"},
                                  "What 100 % of full scale is, in figures that are given as a share of it"))};
}

SensorType sensor_type_of(const TomlDocument& document) {
  const TomlTable root = document.root();
  SensorType type;
  type.text = document.text();
  read_keys(root, type_keys(type));
  read_whole(root, geometry_keys(type));
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

KeyTable rule_keys(analysis::Limits& limits) {
  return {key::schema(),
          key::name("name", limits.name, "Name of these limits; on reports"),
          key::word("rule", limits.rule, {"default", "simple", "guarded", "four-way", "report-only"},
                    "Decision rule (ILAC-G8:09/2019). simple: value <= limit; guarded: value <= limit - U; four-way: "
                    "pass, conditional pass, conditional fail, fail; report-only: no verdict; default: four-way where "
                    "U is known, else simple"),
          key::required(key::number("mean_compensation_error_psi", limits.mean_compensation_error_psi, {"psi"}, {},
                                    "Largest mean error |estimate - reference| over all fitted taxels and frames")),
          key::required(key::number("worst_taxel_error_psi", limits.worst_taxel_error_psi, {"psi"}, {},
                                    "Largest mean error of the worst taxel")),
          key::required(key::number("distance_of_mean_percent_fs", limits.distance_of_mean_fs, kPercentOfFullScale, {},
                                    "Largest mean distance of the array's mean pressure between rise and fall")),
          key::required(key::number("unfit_taxels", limits.unfit_taxels, kOne, {},
                                    "Largest number of dead, stuck, saturated or not modelled taxels"))};
}

KeyTable mismatch_keys(analysis::Limits::Mismatch& mismatch) {
  return {key::required(key::number("pressure_psi", mismatch.pressure_psi, {"psi"}, {},
                                    "Level at which the taxels are compared; it must be a level of the judged run")),
          key::required(key::number("std_percent_fs", mismatch.std_fs, kPercentOfFullScale, {},
                                    "Largest standard deviation of the compensated pressure over the taxels there"))};
}

KeyTable where_keys(analysis::Limits::Mpe& mpe) {
  return {key::optional(key::span("span_psi", mpe.low_psi, mpe.high_psi, {"psi"},
                                  "Lowest and highest pressure between which it counts; or pressure_psi")),
          key::optional(key::number("pressure_psi", mpe.low_psi, {"psi"}, {},
                                    "Level for which the maximum permissible error counts; or span_psi"))};
}

KeyTable mpe_keys(analysis::Limits::Mpe& mpe) {
  return {
      key::required(key::number("mpe_psi", mpe.mpe_psi, {"psi"}, {},
                                "Maximum permissible error: |error| + U of one reading must stay within it")),
      key::number("taxels_percent", mpe.share, kPercent, {1.0, 100.0}, "Share of the taxels that must stay within it")};
}

analysis::Limits::Mpe mpe_of(const TomlTable& row) {
  analysis::Limits::Mpe mpe;
  const bool span = row.has("span_psi");
  if (span == row.has("pressure_psi"))
    row.fail(span ? "span_psi" : "pressure_psi",
             std::string("an [[mpe]] is of one level or of a span, and it names ") + (span ? "both" : "neither"),
             "write pressure_psi = 20, or span_psi = [4, 60]");
  read_keys(row, where_keys(mpe));
  if (!span) mpe.high_psi = mpe.low_psi;
  read_keys(row, mpe_keys(mpe));
  if (!(mpe.mpe_psi > 0.0)) row.fail("mpe_psi", "a maximum permissible error is above 0", "write mpe_psi = 2.0");
  row.finish();
  return mpe;
}

analysis::Limits limits_of(const TomlDocument& document) {
  const TomlTable root = document.root();
  analysis::Limits limits;
  limits.toml = document.text();
  limits.sha256 = db::sha256_hex(limits.toml);
  read_keys(root, rule_keys(limits));
  for (const TomlTable& row : root.tables("mismatch")) {
    read_whole(row, mismatch_keys(limits.mismatch.emplace_back()));
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

std::vector<sequences::KeyFacts> sensor_type_keys() {
  SensorType type;
  std::vector<sequences::KeyFacts> all;
  add_facts(all, "", type_keys(type));
  add_facts(all, "", geometry_keys(type));
  return all;
}

std::vector<sequences::KeyFacts> limits_keys() {
  analysis::Limits limits;
  analysis::Limits::Mismatch mismatch;
  analysis::Limits::Mpe mpe;
  std::vector<sequences::KeyFacts> all;
  add_facts(all, "", rule_keys(limits));
  add_facts(all, "mismatch[]", mismatch_keys(mismatch));
  add_facts(all, "mpe[]", where_keys(mpe));
  add_facts(all, "mpe[]", mpe_keys(mpe));
  return all;
}

}  // namespace tactbench::bench
