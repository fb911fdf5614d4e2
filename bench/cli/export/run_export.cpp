// runs export: all data of a run for programs that do not read SQLite. Raw counts, every scan.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <ostream>
#include <set>

#include "analysis/documents/run_json.h"
#include "analysis/json_fields.h"
#include "analysis/json_io.h"
#include "bench/cli/export/run_export_csv.h"
#include "bench/cli/runs/from_fleet.h"
#include "bench/cli/session.h"
#include "bench/common/output_file.h"

namespace tactbench::bench {

namespace {

struct RunExportOptions {
  std::int64_t run = 0;
  std::string format = "csv", output;
};

nlohmann::ordered_json frame_json(const db::FrameRecord& f, const db::BranchRecord& b) {
  nlohmann::ordered_json json = {
      JSON_FIELDS(b, sequence, repeat),
      {"branch", b.ordinal},
      {"attempt", b.attempt},
      {"void", b.is_void},
      {"step", f.ordinal},
      JSON_FIELDS(f, setpoint_psi, feedback_psi, reference_psi, setpoint_counts, feedback_counts, reference_counts,
                  time_ns, since_command_ns, in_band_ns, device_time_us, status, flags, rows, columns, scans, counts)};
  if (f.wrench) {
    json["target_n"] = f.wrench->target_n;
    json["wrench_n_nmm"] = f.wrench->wrench;
    json["wrench_raw"] = f.wrench->raw;
    json["place_mm"] = f.wrench->place_mm;
  }
  return json;
}

using PutItem = std::function<void(const nlohmann::ordered_json&)>;

// A member of the document that is a list; `fill` puts its items one by one.
void write_list(std::ostream& stream, const char* name, const std::function<void(const PutItem&)>& fill) {
  stream << ",\"" << name << "\":[";
  bool first = true;
  fill([&](const nlohmann::ordered_json& item) {
    stream << (first ? "" : ",") << analysis::printable_json(item);
    first = false;
  });
  stream << "]";
}

// Writes the document frame by frame: a JSON tree takes seven times the memory of its text.
void run_document(const db::RunStore& store, const db::RunRecord& run, std::ostream& stream) {
  nlohmann::ordered_json json = {{"schema", "tactbench.run"}, {"version", analysis::kRunSchemaVersion}};
  json.update(analysis::run_json(run));
  json["bench_toml"] = run.bench_toml;
  json["sensor_toml"] = run.sensor_toml;
  for (std::size_t i = 0; i < run.sequences.size(); ++i) json["recipes"][i]["toml"] = run.sequences[i].recipe_toml;
  for (std::size_t i = 0; i < run.devices.size(); ++i) {
    json["devices"][i]["calibration"] = analysis::ordered_json_or_null(run.devices[i].calibration_json);
  }
  std::string head = analysis::printable_json(json);
  head.pop_back();  // the closing brace comes last
  stream << head;
  write_list(stream, "frames", [&](const PutItem& put) {
    const std::vector<db::BranchRecord> branches = store.branches(run.run);
    store.each_frame(run.run, [&](const db::FrameRecord& f) { put(frame_json(f, branch_in(branches, f.branch))); });
  });
  write_list(stream, "series", [&](const PutItem& put) {
    for (const db::SeriesRecord& s : store.series(run.run)) {
      put({JSON_FIELDS(s, sequence, taxel, input, output)});
    }
  });
  write_list(stream, "events", [&](const PutItem& put) {
    for (const db::EventRecord& e : store.events(run.run)) {
      put({JSON_FIELDS(e, time_ns, kind, id, detail)});
    }
  });
  write_list(stream, "checks", [&](const PutItem& put) {
    for (const db::CheckRecord& c : store.checks(run.run)) {
      put({JSON_FIELDS(c, time_ns, kind, verdict), {"detail", analysis::ordered_json_or_null(c.detail_json)}});
    }
  });
  stream << ",\"verdicts\":"
         << analysis::printable_json(verdicts_json(analysis::figures_of(store.verdicts(run.run)), run.origin)) << "}\n";
}

void export_run(const RunExportOptions& options, const Session& session) {
  const db::RunStore store = db::RunStore::open_read_only(session.db);
  const db::RunRecord run = store.run(options.run);
  const bool frames = store.series(run.run).empty();
  const std::string kind = options.format == "json" ? kRunDocument : frames ? kRunTable : kind_of_file(kSeriesHead);
  const auto write = [&](std::ostream& stream) {
    if (options.format == "json") return run_document(store, run, stream);
    if (frames) return frames_csv(store, run, stream);
    series_csv(store, run, stream);
  };
  const std::size_t bytes = write_output(options.output, kind, write, session.replace);
  if (session.json) {
    print_json("runs.export",
               {{"run", run.run}, {"format", options.format}, {"path", options.output}, {"bytes", bytes}});
  } else {
    tty::print("run {}: {} bytes of {} in {}\n", run.run, bytes, options.format, options.output);
    if (options.format == "csv" && !session.quiet)
      tty::print("to read it: pandas.read_csv(\"{}\", comment=\"#\")\n", options.output);
  }
}

void copy_runs(std::vector<std::int64_t> runs, const std::string& file, const Session& session) {
  std::ranges::sort(runs);
  runs.erase(std::ranges::unique(runs).begin(), runs.end());
  const db::RunStore source = db::RunStore::open_read_only(session.db);
  for (const std::int64_t run : runs) (void)source.run(run);  // unknown runs throw before a file is made
  db::RunStore target = db::RunStore::open(file);
  const std::vector<std::int64_t> numbers = target.copy_runs_from(source, runs);
  auto list = nlohmann::ordered_json::array(), left = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < runs.size(); ++i) {
    list.push_back({{"run", runs[i]}, {"copy", numbers[i]}});
    if (!session.json) tty::print("run {} is run {} of {}\n", runs[i], numbers[i], file);
  }
  // A verdict belongs to the judged run and is exported with it.
  for (const std::int64_t run : runs) {
    std::set<std::int64_t> judged;
    for (const db::VerdictRecord& verdict : source.verdicts_of_models(run))
      if (std::ranges::find(runs, verdict.run) == runs.end()) judged.insert(verdict.run);
    for (const std::int64_t other : judged) {
      left.push_back({{"models_of", run}, {"judged_on", other}});
      if (!session.json)
        tty::print(
            "note: the models of run {0} were judged on run {1}, which is not copied: that verdict is left behind; to "
            "include it, copy both into a new store: tactbench runs copy {0} {1} --to FILE\n",
            run, other);
    }
  }
  if (session.json)
    print_json("runs.copy", {{"store", session.fleet.empty() ? session.db : session.fleet},
                             {"to", file},
                             {"runs", list},
                             {"verdicts_left_behind", left}});
}

// Also while a run is written.
void snapshot_db(const std::string& file, const Session& session) {
  const db::RunStore store = db::RunStore::open_read_only(session.db);
  store.snapshot(file);
  const auto bytes = std::filesystem::file_size(file);
  if (session.json) {
    print_json("runs.copy", {{"store", session.db}, {"to", file}, {"bytes", bytes}});
  } else {
    tty::print("{}: copy of all of {}, {} bytes\n", file, session.db, bytes);
  }
}

}  // namespace

void add_run_copy(CLI::App& runs, Session& session) {
  auto names = std::make_shared<std::vector<std::string>>();
  auto file = std::make_shared<std::string>();
  auto from = std::make_shared<std::string>();
  CLI::App* verb = runs.add_subcommand("copy", "copy runs with models, verdicts and remarks, or the whole store");
  verb->footer(
      "A verdict is copied with the judged run; when only the models' run is copied, a note names the verdicts left "
      "behind.");
  verb->add_option("runs", *names,
                   "numbers of ended runs; with --from also UUIDs; none: the whole store into a new "
                   "file, also while a run is written")
      ->take_all();
  add_from(*verb, *from);
  verb->add_option("--to", *file, "the other store; made if it does not exist")->required();
  verb->callback([names, file, from, &session] {
    if (names->empty() && !from->empty())
      throw Error("TB-USAGE", "of a fleet runs are copied, and none is named", "--from", "name them by their UUIDs");
    if (names->empty()) return snapshot_db(*file, session);
    std::vector<std::int64_t> numbers;
    if (from->empty()) {
      for (const std::string& name : *names) numbers.push_back(run_number(name));
      return copy_runs(numbers, *file, session);
    }
    FromFleet fleet(session, *from);
    std::vector<db::fleet::FleetRun> chosen;
    for (const std::string& name : *names) {
      chosen.push_back(run_named(fleet.link(), name));
      numbers.push_back(chosen.back().run);
    }
    fleet.take(chosen);
    copy_runs(numbers, *file, session);
  });
}

void add_run_export(CLI::App& runs, Session& session) {
  auto options = std::make_shared<RunExportOptions>();
  CLI::App* verb = runs.add_subcommand("export", "write a run's frames as CSV, or all of it as JSON");
  verb->add_option("run", options->run, "run number")->required();
  verb->add_option("--format", options->format, "csv: one line per scan, raw counts and volts; json: the whole run")
      ->check(CLI::IsMember({"csv", "json"}))
      ->capture_default_str();
  verb->add_option("-o,--output", options->output, "file to write")->required();
  add_replace(*verb, session);
  verb->callback([options, &session] { export_run(*options, session); });
}

}  // namespace tactbench::bench
