#include "db/fleet/tables.h"

#include <fmt/format.h>

#include <sstream>

namespace tactbench::db::fleet {

namespace {

// "run:i origin:t", each with the letter of its kind.
std::vector<Column> columns_of(const std::string& text) {
  std::vector<Column> columns;
  std::istringstream words(text);
  for (std::string word; words >> word;)
    columns.push_back({word.substr(0, word.size() - 2), static_cast<Kind>(word.back())});
  return columns;
}

std::string join(const std::vector<Column>& columns, std::size_t from, const char* format) {
  std::string text;
  for (std::size_t i = from; i < columns.size(); ++i)
    text += fmt::format("{}{}", text.empty() ? "" : ", ", fmt::format(fmt::runtime(format), columns[i].name, i + 1));
  return text;
}

// A table that has the same columns on both sides.
Table plain(const std::string& name, const std::vector<Column>& columns, const std::string& order) {
  const std::string key = columns.front().name;
  return {name, columns,
          fmt::format("SELECT {} FROM {} WHERE \"{}\" = ?1 ORDER BY {}", join(columns, 1, "\"{}\""), name, key, order),
          fmt::format("INSERT INTO {} ({}) VALUES ({})", name, names_of(columns), join(columns, 0, "?{1}"))};
}

// A table whose rows have keys of the file's own: in the fleet it has `position` in their place.
Table numbered(const std::string& name, const std::vector<Column>& columns, const std::string& key) {
  return {name, columns,
          fmt::format("SELECT row_number() OVER (ORDER BY {}), {} FROM {} WHERE run = ?1 ORDER BY {}", key,
                      join(columns, 2, "\"{}\""), name, key),
          fmt::format("INSERT INTO {} (run, {}) VALUES (?1, {})", name, join(columns, 2, "\"{}\""),
                      join(columns, 2, "?{1}"))};
}

// A branch's key in a store that was filled from the fleet.
constexpr const char* kBranchKey = "?1 * 1000000";

Table branches() {
  Table table = numbered("branches",
                         columns_of("run:i position:i sequence:i repeat:i ordinal:i attempt:i void:i void_reason:t "
                                    "from_psi:r to_psi:r from_n:r to_n:r"),
                         "branch");
  table.into_store = fmt::format("INSERT INTO branches (branch, run, {}) VALUES ({} + ?2, ?1, {})",
                                 join(table.columns, 2, "\"{}\""), kBranchKey, join(table.columns, 2, "?{1}"));
  return table;
}

Table frames() {
  Table table{"frames",
              columns_of("run:i month:i position:i branch:i ordinal:i setpoint_psi:r feedback_psi:r reference_psi:r "
                         "setpoint_counts:i feedback_counts:i reference_counts:i time_ns:i since_command_ns:i "
                         "in_band_ns:i device_time_us:i status:i exchanges:i dtype:t rows:i columns:i scans:i counts:b "
                         "chain:b flags:t trace:b target_n:r force_start_n:r wrench:b wrench_raw:b place_mm:b"),
              {},
              {}};
  // ?2: the month, the same for all frames of a run.
  table.from_store = fmt::format(
      "WITH placed AS MATERIALIZED (SELECT branch, row_number() OVER (ORDER BY branch) AS place FROM branches "
      "WHERE run = ?1) "
      "SELECT ?2, f.frame - ?1 * 1000000000, p.place, {} FROM frames f JOIN placed p ON p.branch = f.branch "
      "WHERE f.frame > ?1 * 1000000000 AND f.frame < (?1 + 1) * 1000000000 ORDER BY f.frame",
      join(table.columns, 4, "f.\"{}\""));
  table.into_store = fmt::format("INSERT INTO frames (frame, branch, {}) VALUES (?1 * 1000000000 + ?3, {} + ?4, {})",
                                 join(table.columns, 4, "\"{}\""), kBranchKey, join(table.columns, 4, "?{1}"));
  return table;
}

}  // namespace

std::string names_of(const std::vector<Column>& columns) { return join(columns, 0, "\"{}\""); }

std::string copy_into(const Table& table) {
  return fmt::format("COPY fleet.{} ({}) FROM STDIN (FORMAT binary)", table.name, names_of(table.columns));
}

const std::vector<Table>& content_tables() {
  static const std::vector<Table> tables = {
      plain("sequences",
            columns_of("run:i sequence:i name:t recipe_toml:t recipe_sha256:t repeats:i frames_per_repeat:i"),
            "sequence"),
      plain("devices", columns_of("run:i position:i role:t model:t serial:t firmware:t origin:t calibration_json:t"),
            "position"),
      branches(),
      numbered("events", columns_of("run:i position:i time_ns:i kind:t id:t detail:t"), "event"),
      numbered("checks", columns_of("run:i position:i time_ns:i kind:t verdict:t detail_json:t data:b"), "check_row"),
      plain("series", columns_of("run:i sequence:i taxel:i input:b output:b"), "sequence, taxel")};
  return tables;
}

const Table& frames_table() {
  static const Table table = frames();
  return table;
}

const Table& runs_table() {
  static const std::vector<Column> own = columns_of(
      "run:i uuid:t origin:t state:t outcome:t reason:t safe_state:t operator:t purpose:t sensor_serial:t "
      "scanner_serial:t bench_id:t bench_toml:t bench_sha256:t sensor_toml:t sensor_sha256:t overrides_json:t "
      "program_version:t git_commit:t git_dirty:i build_id:t host:t time_zone:t seed:i sensor_seed:i started_utc:t "
      "ended_utc:t content_sha256:t seen_utc:t rest_s:r");
  static const Table table = plain("runs", own, "run");
  return table;
}

const Table& sensors_table() {
  static const Table table = plain(
      "sensors", columns_of("serial:t type:t type_toml:t type_sha256:t scanner_serial:t note:t added_utc:t"), "serial");
  return table;
}

const Table& fits_table() {
  static const Table table = [] {
    Table fits =
        plain("fits",
              columns_of("fit:i model:t options_json:t summary_json:t program_version:t created_utc:t patterns_json:t"),
              "fit");
    fits.from_store = fmt::format("SELECT {} FROM fits WHERE run = ?1 ORDER BY fit", names_of(fits.columns));
    return fits;
  }();
  return table;
}

const Table& fit_taxels_table() {
  static const Table table =
      plain("fit_taxels",
            columns_of("fit:i taxel:i status:t parameters:b ascending_v:b descending_v:b noise_v:r "
                       "j_v2:r mean_error_v:r max_error_v:r full_scale_v:r at_bound:i"),
            "taxel");
  return table;
}

// In the fleet the fit is named by its run's UUID and its hash, so that it need not be there yet.
const Table& verdicts_table() {
  static const Table table = [] {
    Table verdicts{"verdicts",
                   columns_of("revision:i position:i fit_uuid:t fit_sha256:t criterion:t scope:t value:r limit_value:r "
                              "unit:t rule:t verdict:t limits_toml:t limits_sha256:t"),
                   {},
                   {}};
    const std::string rest = join(verdicts.columns, 4, "\"{}\"");
    // The store's number of the fit stands in the place of fit_uuid.
    verdicts.from_store = fmt::format(
        "SELECT row_number() OVER (ORDER BY verdict_row), coalesce(CAST(fit AS TEXT), ''), '', {} FROM verdicts "
        "WHERE run = ?1 ORDER BY verdict_row",
        rest);
    // ?1: the run, ?3: the fit or NULL.
    verdicts.into_store =
        fmt::format("INSERT INTO verdicts (run, fit, {}) VALUES (?1, ?3, {})", rest, join(verdicts.columns, 4, "?{1}"));
    return verdicts;
  }();
  return table;
}

const Table& figures_table() {
  static const Table table = [] {
    Table figures{"figures", columns_of("revision:i subject:t name:t value:r"), {}, {}};
    figures.from_store = "SELECT subject, name, value FROM figures WHERE run = ?1 ORDER BY subject, name";
    figures.into_store = "INSERT INTO figures (run, subject, name, value) VALUES (?1, ?2, ?3, ?4)";
    return figures;
  }();
  return table;
}

const Table& reports_table() {
  static const Table table = [] {
    Table reports{"reports",
                  columns_of("revision:i position:i number:t content_sha256:t approved_by:t approved_utc:t replaces:t "
                             "reason:t"),
                  {},
                  {}};
    const std::string rest = join(reports.columns, 2, "\"{}\"");
    reports.from_store = fmt::format(
        "SELECT row_number() OVER (ORDER BY report_row), {} FROM reports WHERE run = ?1 ORDER BY report_row", rest);
    reports.into_store =
        fmt::format("INSERT INTO reports (run, {}) VALUES (?1, {})", rest, join(reports.columns, 2, "?{1}"));
    return reports;
  }();
  return table;
}

}  // namespace tactbench::db::fleet
