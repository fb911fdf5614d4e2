#include "bench/cli/runs/source.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "analysis/json_io.h"
#include "bench/cli/runs/import.h"
#include "bench/fleet/facts.h"
#include "bench/reporting/evidence.h"
#include "db/fleet/runs.h"

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
analysis::Histories imported(const db::RunReader& store, const db::RunRecord& run,
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
                  "from 1, or names, in double quotes if they contain a comma); output=3-18, output=s* and "
                  "output=s0+s1 are one column per taxel");
  verb.add_flag("--no-header", options.no_header, "no line names the columns; --map assigns them by number");
  verb.add_option("--skip-lines", options.skip_lines, "skip so many lines at its beginning, whatever they contain");
  for (const char* const name : {"--map", "--no-header", "--skip-lines"}) verb.get_option(name)->group(kTableOptions);
}

void add_table_options(CLI::App& verb, TableOptions& options) {
  add_layout_options(verb, options);
  verb.add_option("--input-unit", options.input_unit, "unit of its inputs, for display");
  verb.add_option("--noise", options.noise,
                  "standard deviation of its outputs (default: estimated from differences of neighbours within the "
                  "fitted branches); the dead band of compensation is six times that")
      ->check(CLI::NonNegativeNumber);
  verb.add_option("--turn", options.turn,
                  "in units of its inputs: an input that goes back by more than this has turned (default: seven times "
                  "the noise of the inputs, at least 0.1 % of their span)")
      ->check(CLI::NonNegativeNumber);
  verb.add_flag("--skip-bad-rows", options.skip_bad_rows,
                "leave out rows with blank cells, without numbers, with too few or too many fields, or with a number "
                "far from both its neighbours, and list them");
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

bool is_run_number(const std::string& source) {
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
  print_table_doubts(histories);
  return histories;
}

analysis::Histories read_source(const std::string& source, const TableOptions& table, const Session& session,
                                const std::vector<std::string>& fitted) {
  if (is_run_number(source)) {
    const db::RunStore store = db::RunStore::open_read_only(session.db);
    analysis::Runs runs(store);
    return read_run(runs, std::stoll(source), "run " + source, table, session, fitted);
  }
  const TableFile file = read_table_file(source, table);
  print_table_assumptions(source, file.table);
  analysis::Histories histories = analysis::histories_of(file.table.series, source, options_of(table, fitted));
  histories.content_sha256 = file.sha256;
  histories.input_unit = file.table.input_unit;
  histories.output_unit = file.table.output_unit;
  histories.assumed = file.table.assumed;
  print_table_doubts(histories);
  return histories;
}

analysis::SensorModel load_model(const std::string& model, const Session& session) {
  if (!is_run_number(model.substr(0, model.find(':')))) return analysis::load_model(model, nullptr);
  const db::RunStore store = db::RunStore::open_read_only(session.db);
  analysis::Runs runs(store);
  check_model_named(runs, model, "model " + model, session);
  return analysis::load_model(model, &store);
}

void check_model_named(analysis::Runs& runs, const std::string& model, const std::string& at, const Session& session) {
  const std::string run = model.substr(0, model.find(':'));
  if (is_run_number(run)) (void)named_runs(runs, {std::stoll(run)}, {at}, session.void_too);
}

std::vector<std::string> split_list(const std::string& text) {
  std::vector<std::string> list;
  std::istringstream stream(text);
  for (std::string item; std::getline(stream, item, ',');)
    if (!item.empty()) list.push_back(item);
  return list;
}

namespace fleet = db::fleet;

namespace {

std::string fleet_named(const std::string& given, Session& session) {
  if (!given.empty() && given != "fleet") return given;
  const OperatorProfile& profile = session.profile.values();
  const auto value = profile.find(ProfileKey::kFleet);
  if (value != profile.end()) return value->second.values.front();
  throw Error(
      "TB-USAGE", "no fleet is named", "fleet",
      "name it: --to \"host=db.lab dbname=tactile user=bench_a sslmode=verify-full\"; or set TACTBENCH_FLEET, or "
      "write fleet = \"...\" into tactbench.toml");
}

}  // namespace

void add_from_option(CLI::App& verb, std::string& from) {
  verb.add_option("--from", from,
                  "read from a fleet instead of a store: `fleet` for the one in TACTBENCH_FLEET or tactbench.toml, or "
                  "a connection string as for psql");
}

std::int64_t run_number(const std::string& text) {
  if (is_run_number(text)) return std::stoll(text);
  throw Error("TB-USAGE", fmt::format("'{}' is not a run number", text), "command line",
              "tactbench runs list shows the numbers; a UUID is accepted only with --from");
}

FleetImport::FleetImport(Session& session, const std::string& given)
    : session_(session), link_(fleet_named(given, session)), folder_("tactbench-fleet"), db_before_(session.db) {
  fleet::check_schema(link_);
  session_.fleet = link_.where();
}

FleetImport::~FleetImport() {
  session_.db = db_before_;
  session_.fleet.clear();
}

void FleetImport::take_one(db::RunStore& store, const fleet::FleetRun& run) {
  const std::string path = folder_.path() + "/body.db";
  for (const char* ending : {"-wal", "-shm"}) std::filesystem::remove(path + ending);
  fleet::unpack_run(fleet::body_of(link_, run), path);
  const db::RunStore body = db::RunStore::open_read_only(path);
  const std::vector<db::RunRecord> runs = body.runs();
  if (runs.size() != 1 || runs.front().uuid != run.uuid || runs.front().content_sha256 != run.content_sha256)
    throw fleet::FleetError(fleet::FleetCause::kStore, "TB-FLEET-CHANGED", "its packed store belongs to another run",
                            "use the run in the bench's own store");
  for (const db::SensorRecord& sensor : body.sensors()) {
    const auto known = store.sensor(sensor.serial);
    if (known && (known->type_sha256 != sensor.type_sha256 || known->scanner_serial != sensor.scanner_serial))
      throw fleet::FleetError(
          fleet::FleetCause::kUsage, "TB-FLEET-CONFLICT",
          fmt::format("these runs contain sensor '{}' with two different types or scanners", sensor.serial),
          "name runs that have the same registration of the sensor");
  }
  store.number_next_run(run.run);
  (void)store.copy_runs_from(body, {runs.front().run});
}

void FleetImport::take(const std::vector<fleet::FleetRun>& runs, const std::vector<fleet::FleetRun>& also) {
  session_.db = folder_.path() + "/fleet.db";
  db::RunStore store = db::RunStore::open(session_.db, db::Durability::kNormal);
  std::map<std::int64_t, std::pair<const fleet::FleetRun*, bool>> all;  // by number, since those of a store grow
  for (const fleet::FleetRun& run : runs) all[run.run] = {&run, true};
  for (const fleet::FleetRun& run : also) all.try_emplace(run.run, &run, false);
  std::map<std::int64_t, ModelsOfVerdicts> copied;
  for (const auto& [number, asked] : all) {
    const auto& [run, needed] = asked;
    const auto leave = [&, own = run, must = needed](const fleet::FleetError& error) {
      const std::string what =
          fmt::format("fleet {}: run {}, pushed by {}: {}", link_.where(), own->run, own->pushed_by, error.what());
      if (must || error.cause() == fleet::FleetCause::kLink)
        throw fleet::FleetError(error.cause(), error.id(), what, error.remedy());
      tty::print(stderr, "warning: {} [{}]; it is left out\n", one_line(what, kMaxTextLength), error.id());
    };
    const auto changed = [&](const std::string& what) {
      leave(fleet::FleetError(fleet::FleetCause::kStore, "TB-FLEET-CHANGED", what,
                              "use the run in the bench's own store"));
    };
    try {
      const ModelsOfVerdicts models = models_of_verdicts(analysis::parse_json(run->facts));
      take_one(store, *run);
      copied[number] = models;
    } catch (const fleet::FleetError& error) {
      leave(error);
    } catch (const db::StoreError& error) {
      if (error.id() == "TB-STORE-FULL") throw;
      changed(error.what());
    } catch (const nlohmann::json::exception& error) {
      changed(fmt::format("its facts cannot be read: {}", error.what()));
    }
  }
  for (const auto& [number, models] : copied) link_verdicts(store, number, models);
}

}  // namespace tactbench::bench
