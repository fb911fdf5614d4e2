// A table of another program becomes a run of origin imported: all its rows at full precision, bound by a hash.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "analysis/counted.h"
#include "analysis/json_io.h"
#include "bench/cli/runs/table_file.h"
#include "bench/common/utc.h"
#include "bench/run/run_record.h"

namespace tactbench::bench {

TableFile read_table_file(const std::string& path, const TableOptions& options) {
  const analysis::ColumnMap map = analysis::column_map_from(options.map);
  std::string text = analysis::table_text(path);  // read once: a pipe has nothing the second time
  TableFile file;
  file.sha256 = db::sha256_hex(text);
  std::istringstream stream(std::move(text));
  file.series = analysis::read_table(stream, path, map);
  return file;
}

namespace {

struct ImportOptions {
  std::string file, operator_name, purpose;
  TableOptions table;
};

void import(const ImportOptions& options, const Session& session) {
  const TableFile file = read_table_file(options.file, options.table);
  (void)analysis::histories_of(file.series, options.file);  // refuses what no model could be fitted on
  db::RunRecord run = program_record();
  run.origin = "imported";
  run.operator_name = options.operator_name;
  run.purpose = options.purpose;
  std::vector<db::SeriesRecord> series;
  std::size_t rows = 0;
  for (const analysis::TableSeries& own : file.series) {
    auto sequence = std::ranges::find(run.sequences, own.sequence, &db::SequenceRecord::name);
    if (sequence == run.sequences.end()) {
      const auto number = static_cast<int>(run.sequences.size());
      sequence = run.sequences.insert(sequence, {number, own.sequence, "", "", 1, 0});
    }
    sequence->frames_per_repeat = std::max(sequence->frames_per_repeat, static_cast<int>(own.input.size()));
    series.push_back({sequence->sequence, own.taxel, own.input, own.output});
    rows += own.input.size();
  }
  const nlohmann::ordered_json calibration = {
      {"input_unit", options.table.input_unit}, {"output_unit", options.table.output_unit}, {"map", options.table.map}};
  run.devices = {{kTableRole, std::filesystem::path(options.file).filename().string(), file.sha256, "", "imported",
                  analysis::json_line(calibration)}};
  db::RunStore store = db::RunStore::open(session.db);
  const std::int64_t number = store.begin_run(run);
  store.append_series(number, series);
  store.end_run(number, db::Outcome::kCompleted, "imported", db::SafeState::kUnknown, utc_now());
  if (session.json) {
    print_json("import",
               {{"run", number}, {"rows", rows}, {"sequences", run.sequences.size()}, {"sha256", file.sha256}});
    return;
  }
  tty::print("run {}: {} in {} imported from {}\n", number, analysis::counted(rows, "row"),
             analysis::counted(run.sequences.size(), "sequence"), options.file);
}

}  // namespace

void add_import(CLI::App& app, Session& session) {
  auto options = std::make_shared<ImportOptions>();
  CLI::App* verb = app.add_subcommand(
      "import", "make a run of a table with columns sequence,step,input,output[,taxel] (history in row order)");
  verb->add_option("file", options->file, "comma, semicolon or tab separated text; the first line names the columns")
      ->required();
  add_table_options(*verb, options->table);
  verb->add_option("--operator", options->operator_name, "who imports it");
  verb->add_option("--purpose", options->purpose, "what it is");
  add_common(*verb, session);
  verb->callback([options, &session] { import(*options, session); });
}

}  // namespace tactbench::bench
