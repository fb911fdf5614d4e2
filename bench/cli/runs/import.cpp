// Imports a table of another program as a run of origin imported: all rows at full precision, under a hash.
#include "bench/cli/runs/import.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "analysis/counted.h"
#include "analysis/json_fields.h"
#include "analysis/json_io.h"
#include "bench/common/utc.h"
#include "bench/common/work_progress.h"
#include "bench/run/run_record.h"

namespace tactbench::bench {

TableFile read_table_file(const std::string& path, const TableOptions& options) {
  const analysis::TableLayout layout = layout_of(options);
  std::string text = analysis::table_text(path);  // read once: a pipe has nothing the second time
  TableFile file;
  file.sha256 = db::sha256_hex(text);
  std::istringstream stream(std::move(text));
  file.table = analysis::read_table(stream, path, layout);
  if (!options.input_unit.empty()) file.table.input_unit = options.input_unit;
  if (!options.output_unit.empty()) file.table.output_unit = options.output_unit;
  return file;
}

void print_table_assumptions(const std::string& path, const analysis::Table& table) {
  for (const std::string& line : table.assumed) tty::print(stderr, "{}: {}\n", path, line);
  const analysis::SkippedRows& skipped = table.skipped;
  if (skipped.count == 0) return;
  for (const std::string& line : skipped.first) tty::print(stderr, "left out: {}\n", line);
  tty::print(stderr, "warning: {}: {} left out by --skip-bad-rows{}\n", path, analysis::counted(skipped.count, "row"),
             skipped.count > skipped.first.size() ? fmt::format("; the first {} are named", skipped.first.size()) : "");
}

void print_table_doubts(const analysis::Histories& histories) {
  for (const std::string& line : histories.warnings) tty::print(stderr, "warning: {}: {}\n", histories.source, line);
}

namespace {

std::string reason_of(const analysis::SkippedRows& skipped) {
  return skipped.count == 0
             ? "imported"
             : fmt::format("imported without {} that cannot be read", analysis::counted(skipped.count, "row"));
}

struct ImportOptions {
  std::string file, operator_name, purpose;
  TableOptions table;
};

void import(const ImportOptions& options, const Session& session) {
  WorkProgress progress("import", session.quiet || session.json,
                        {{"reading the table", 6.0}, {"checking the data", 3.0, false}, {"storing", 1.0, false}});
  const TableFile file = read_table_file(options.file, options.table);
  progress.begin("checking the data");
  print_table_assumptions(options.file, file.table);
  // Refuses a table on which no model can be fitted.
  print_table_doubts(analysis::histories_of(file.table.series, options.file, options_of(options.table)));
  db::RunRecord run = program_record();
  run.origin = "imported";
  run.operator_name = options.operator_name;
  run.purpose = options.purpose;
  std::vector<db::SeriesRecord> series;
  std::size_t rows = 0;
  for (const analysis::TableSeries& own : file.table.series) {
    auto sequence = std::ranges::find(run.sequences, own.sequence, &db::SequenceRecord::name);
    if (sequence == run.sequences.end()) {
      const auto number = static_cast<int>(run.sequences.size());
      sequence = run.sequences.insert(sequence, {number, own.sequence, "", "", 1, 0});
    }
    sequence->frames_per_repeat = std::max(sequence->frames_per_repeat, static_cast<int>(own.input.size()));
    series.push_back({sequence->sequence, own.taxel, own.input, own.output});
    rows += own.input.size();
  }
  nlohmann::ordered_json calibration = {JSON_FIELDS(file.table, input_unit, output_unit), {"map", options.table.map}};
  if (options.table.no_header) calibration["no_header"] = true;
  if (options.table.skip_lines > 0) calibration["skip_lines"] = options.table.skip_lines;
  if (file.table.skipped.count > 0)  // the hash is of all rows
    calibration["rows_left_out"] = file.table.skipped.count;
  run.devices = {{kTableRole, std::filesystem::path(options.file).filename().string(), file.sha256, "", "imported",
                  analysis::json_line(calibration)}};
  progress.begin("storing");
  db::RunStore store = db::RunStore::open(session.db);
  const std::int64_t number = store.begin_run(run);
  store.append_series(number, series);
  store.end_run(number, db::Outcome::kCompleted, reason_of(file.table.skipped), db::SafeState::kUnknown, utc_now());
  if (session.json) {
    print_json("import", {{"run", number},
                          {"rows", rows},
                          {"left_out", file.table.skipped.count},
                          {"sequences", run.sequences.size()},
                          {"sha256", file.sha256}});
    return;
  }
  tty::print("run {}: {} in {} imported from {}\n", number, analysis::counted(rows, "row"),
             analysis::counted(run.sequences.size(), "sequence"), options.file);
}

}  // namespace

void add_import(CLI::App& runs, Session& session) {
  auto options = std::make_shared<ImportOptions>();
  CLI::App* verb = runs.add_subcommand("import",
                                       "make a run from a table of input and output\n"
                                       "Columns sequence, step, input, output and perhaps taxel, or what runs export "
                                       "writes; history in row order.");
  verb->add_option("file", options->file,
                   "text with columns separated by commas, semicolons, tabs or blanks; one line names them, the next "
                   "may contain units")
      ->required();
  add_table_options(*verb, options->table);
  session.profile.add(*verb, "--operator", ProfileKey::kOperator, options->operator_name,
                      "name of the person who imports it");
  verb->add_option("--purpose", options->purpose, "what it is");
  verb->callback([options, &session] { import(*options, session); });
}

}  // namespace tactbench::bench
