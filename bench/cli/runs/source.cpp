#include "bench/cli/runs/source.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>
#include <sstream>

#include "analysis/json_io.h"
#include "bench/cli/runs/table_file.h"
#include "bench/reporting/named_runs.h"

namespace tactbench::bench {

analysis::HistoriesOptions options_of(const TableOptions& table, const std::vector<std::string>& fitted) {
  analysis::HistoriesOptions options;
  options.fitted = fitted;
  options.turn = table.turn;
  options.noise = table.noise;
  options.timed = table.timed;
  return options;
}

namespace {

// The series of an imported run, with the units that its table was given.
analysis::Histories imported(const db::RunStore& store, const db::RunRecord& run,
                             const analysis::HistoriesOptions& options) {
  std::vector<analysis::TableSeries> series;
  for (const db::SeriesRecord& record : store.series(run.run)) {
    const auto sequence = std::ranges::find(run.sequences, record.sequence, &db::SequenceRecord::sequence);
    series.push_back({sequence->name, record.taxel, record.input, record.output, {}, {}});
  }
  analysis::Histories histories = analysis::histories_of(series, fmt::format("run {}", run.run), options);
  for (const db::DeviceRecord& device : run.devices) {
    if (device.role != kTableRole) continue;
    const auto json = analysis::parse_json(device.calibration_json);
    histories.input_unit = json.at("input_unit").get<std::string>();
    histories.output_unit = json.at("output_unit").get<std::string>();
  }
  return histories;
}

}  // namespace

analysis::TableLayout layout_of(const TableOptions& options) {
  analysis::TableLayout layout = analysis::table_layout(options.map);
  layout.no_header = options.no_header;
  layout.skip_lines = options.skip_lines;
  layout.skip_bad_rows = options.skip_bad_rows;
  return layout;
}

constexpr const char* kTableOptions = "Of a table";

void add_layout_options(CLI::App& verb, TableOptions& options) {
  verb.add_option("--map", options.map,
                  "meaning of the columns, as input=COL,output=COL,sequence=COL,taxel=COL,time=COL (numbers "
                  "from 1, or names, in double quotes where they hold a comma); output=3-18, output=s* and "
                  "output=s0+s1 are one column a taxel");
  verb.add_flag("--no-header", options.no_header, "no line names the columns; --map numbers them");
  verb.add_option("--skip-lines", options.skip_lines, "pass over so many lines at its beginning, whatever they hold");
  for (const char* const name : {"--map", "--no-header", "--skip-lines"}) verb.get_option(name)->group(kTableOptions);
}

void add_table_options(CLI::App& verb, TableOptions& options) {
  add_layout_options(verb, options);
  verb.add_option("--input-unit", options.input_unit, "unit of its inputs, for display");
  verb.add_option("--noise", options.noise,
                  "standard deviation of its outputs (default: estimated from differences of neighbours "
                  "within the branches that are fitted); the dead band of compensation is six of them")
      ->check(CLI::NonNegativeNumber);
  verb.add_option("--turn", options.turn,
                  "in units of its inputs: an input that goes back by more has turned (default: seven times "
                  "the inputs' own noise, and 0.1 % of their span at least)")
      ->check(CLI::NonNegativeNumber);
  verb.add_flag("--skip-bad-rows", options.skip_bad_rows,
                "leave out rows with blank cells, without numbers, with too few or too many fields, or with "
                "a number far from both its neighbours, and say which");
  verb.add_option("--output-unit", options.output_unit, "unit of its outputs, for display");
  for (const char* const name : {"--input-unit", "--output-unit", "--noise", "--turn", "--skip-bad-rows"})
    verb.get_option(name)->group(kTableOptions);
}

std::vector<RunRange> run_ranges(const std::string& text) {
  std::vector<RunRange> ranges;
  std::istringstream parts(text);
  for (std::string part; std::getline(parts, part, ',');) {
    RunRange range;
    const char *const begin = part.data(), *const end = begin + part.size();
    const auto first = std::from_chars(begin, end, range.first);
    range.last = range.first;
    const char* last = first.ptr;
    if (first.ec == std::errc() && last != end && *last == '-') {
      const auto second = std::from_chars(last + 1, end, range.last);
      if (second.ec != std::errc()) return {};
      last = second.ptr;
    }
    if (first.ec != std::errc() || last != end || range.first < 1 || range.last < range.first) return {};
    ranges.push_back(range);
  }
  return ranges;
}

bool names_run(const std::string& source) {
  constexpr std::size_t kLongest = 18;  // largest number of digits of a run's number
  return !source.empty() && source.size() <= kLongest && source.find_first_not_of("0123456789") == std::string::npos;
}

analysis::Histories read_run(analysis::Runs& runs, std::int64_t number, const std::string& at,
                             const TableOptions& table, const Session& session,
                             const std::vector<std::string>& fitted) {
  const db::RunRecord run = named_runs(runs, {number}, {at}, session.void_too).front();
  analysis::Histories histories = run.origin == "imported" ? imported(runs.store(), run, options_of(table, fitted))
                                                           : analysis::histories_of(runs.dataset(run.run));
  histories.run = run.run;
  histories.content_sha256 = run.content_sha256;
  tell_doubts(histories);
  return histories;
}

analysis::Histories read_source(const std::string& source, const TableOptions& table, const Session& session,
                                const std::vector<std::string>& fitted) {
  if (names_run(source)) {
    const db::RunStore store = db::RunStore::open_read_only(session.db);
    analysis::Runs runs(store);
    return read_run(runs, std::stoll(source), "run " + source, table, session, fitted);
  }
  const TableFile file = read_table_file(source, table);
  tell_reading(source, file.table);
  analysis::Histories histories = analysis::histories_of(file.table.series, source, options_of(table, fitted));
  histories.content_sha256 = file.sha256;
  histories.input_unit = file.table.input_unit;
  histories.output_unit = file.table.output_unit;
  histories.assumed = file.table.assumed;
  tell_doubts(histories);
  return histories;
}

analysis::SensorModel load_model(const std::string& model, const Session& session) {
  if (!names_run(model.substr(0, model.find(':')))) return analysis::load_model(model, nullptr);
  const db::RunStore store = db::RunStore::open_read_only(session.db);
  analysis::Runs runs(store);
  check_model_named(runs, model, "model " + model, session);
  return analysis::load_model(model, &store);
}

void check_model_named(analysis::Runs& runs, const std::string& model, const std::string& at, const Session& session) {
  const std::string run = model.substr(0, model.find(':'));
  if (names_run(run)) (void)named_runs(runs, {std::stoll(run)}, {at}, session.void_too);
}

std::vector<std::string> split_list(const std::string& text) {
  std::vector<std::string> list;
  std::istringstream stream(text);
  for (std::string item; std::getline(stream, item, ',');)
    if (!item.empty()) list.push_back(item);
  return list;
}

}  // namespace tactbench::bench
