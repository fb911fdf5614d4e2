// runs export: all data of a run for programs that do not read SQLite. Raw counts, every scan.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <ostream>
#include <set>

#include "analysis/documents/run_json.h"
#include "analysis/json_io.h"
#include "bench/cli/export/run_export.h"
#include "bench/cli/session.h"
#include "bench/common/output_file.h"

namespace tactbench::bench {

namespace {

struct RunExportOptions {
  std::int64_t run = 0;
  std::string format = "csv", output;
};

// A number in round-trip notation; empty without a reading.
std::string csv_number(double value) { return std::isfinite(value) ? fmt::format("{}", value) : std::string(); }

// Typed text may hold commas and quotes (RFC 4180).
std::string csv_text(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::string sequence_name(const db::RunRecord& run, int sequence) {
  const auto found = std::ranges::find(run.sequences, sequence, &db::SequenceRecord::sequence);
  return found == run.sequences.end() ? std::string() : found->name;
}

const db::BranchRecord& branch_in(const std::vector<db::BranchRecord>& branches, std::int64_t key) {
  const auto found = std::ranges::lower_bound(branches, key, {}, &db::BranchRecord::branch);
  if (found != branches.end() && found->branch == key) return *found;
  throw Error(ExitCode::kStore, "TB-STORE-SQL", fmt::format("a frame names the branch {}, which the run lacks", key),
              "runs export", "tactbench verify RUN shows what else differs");
}

std::string csv_names(int rows, int columns) {
  std::string text =
      "frame,sequence,recipe,repeat,branch,attempt,void,step,setpoint_psi,feedback_psi,reference_psi,target_n,"
      "fx_n,fy_n,fz_n,tx_nmm,ty_nmm,tz_nmm,time_s,since_command_s,in_band_s,device_time_us,status,flags,scan";
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) text += fmt::format(",counts_r{}_c{}", row, column);
  }
  return text + "\n";
}

// Frame by frame: a long run needs too much memory.
void frames_csv(const db::RunStore& store, const db::RunRecord& run, std::ostream& stream) {
  const std::vector<db::BranchRecord> branches = store.branches(run.run);
  std::int64_t position = 0;
  std::string text;
  const auto out = std::back_inserter(text);
  store.each_frame(run.run, [&](const db::FrameRecord& f) {
    if (++position == 1) stream << csv_names(f.rows, f.columns);
    text.clear();
    const db::BranchRecord& b = branch_in(branches, f.branch);
    std::string head =
        fmt::format("{},{},{},{},{},{},{},{},{},{},{},", position, b.sequence, csv_text(sequence_name(run, b.sequence)),
                    b.repeat, b.ordinal, b.attempt, b.is_void ? 1 : 0, f.ordinal, csv_number(f.setpoint_psi),
                    csv_number(f.feedback_psi), csv_number(f.reference_psi));
    head += f.wrench ? csv_number(f.wrench->target_n) : std::string();
    for (std::size_t i = 0; i < 6; ++i)
      head += fmt::format(",{}", f.wrench ? csv_number(f.wrench->wrench.at(i)) : std::string());
    const auto seconds = [](std::int64_t ns) { return csv_number(static_cast<double>(ns) * 1e-9); };
    head += fmt::format(",{},{},{},{},{},{}", seconds(f.time_ns), seconds(f.since_command_ns), seconds(f.in_band_ns),
                        f.device_time_us, f.status, csv_text(f.flags));
    const auto taxels = static_cast<std::size_t>(f.rows) * static_cast<std::size_t>(f.columns);
    for (std::size_t scan = 0; scan * taxels < f.counts.size(); ++scan) {
      fmt::format_to(out, "{},{}", head, scan);
      for (std::size_t i = 0; i < taxels; ++i) fmt::format_to(out, ",{}", f.counts.at(scan * taxels + i));
      text += "\n";
    }
    stream << text;
  });
  if (position == 0) stream << csv_names(0, 0);
}

constexpr const char* kSeriesHead = "sequence,name,taxel,position,input,output\n";

std::string series_csv(const db::RunStore& store, const db::RunRecord& run) {
  std::string text = kSeriesHead;
  for (const db::SeriesRecord& s : store.series(run.run)) {
    for (std::size_t i = 0; i < s.input.size(); ++i) {
      text += fmt::format("{},{},{},{},{},{}\n", s.sequence, csv_text(sequence_name(run, s.sequence)), s.taxel, i,
                          csv_number(s.input[i]), csv_number(s.output.at(i)));
    }
  }
  return text;
}

nlohmann::ordered_json frame_json(const db::FrameRecord& f, const db::BranchRecord& b) {
  nlohmann::ordered_json json = {{"sequence", b.sequence},
                                 {"repeat", b.repeat},
                                 {"branch", b.ordinal},
                                 {"attempt", b.attempt},
                                 {"void", b.is_void},
                                 {"step", f.ordinal},
                                 {"setpoint_psi", f.setpoint_psi},
                                 {"feedback_psi", f.feedback_psi},
                                 {"reference_psi", f.reference_psi},
                                 {"setpoint_counts", f.setpoint_counts},
                                 {"feedback_counts", f.feedback_counts},
                                 {"reference_counts", f.reference_counts},
                                 {"time_ns", f.time_ns},
                                 {"since_command_ns", f.since_command_ns},
                                 {"in_band_ns", f.in_band_ns},
                                 {"device_time_us", f.device_time_us},
                                 {"status", f.status},
                                 {"flags", f.flags},
                                 {"rows", f.rows},
                                 {"columns", f.columns},
                                 {"scans", f.scans},
                                 {"counts", f.counts}};
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
      put({{"sequence", s.sequence}, {"taxel", s.taxel}, {"input", s.input}, {"output", s.output}});
    }
  });
  write_list(stream, "events", [&](const PutItem& put) {
    for (const db::EventRecord& e : store.events(run.run)) {
      put({{"time_ns", e.time_ns}, {"kind", e.kind}, {"id", e.id}, {"detail", e.detail}});
    }
  });
  write_list(stream, "checks", [&](const PutItem& put) {
    for (const db::CheckRecord& c : store.checks(run.run)) {
      put({{"time_ns", c.time_ns},
           {"kind", c.kind},
           {"verdict", c.verdict},
           {"detail", analysis::ordered_json_or_null(c.detail_json)}});
    }
  });
  stream << ",\"verdicts\":" << analysis::printable_json(verdicts_json(store.verdicts(run.run), run.origin)) << "}\n";
}

void export_run(const RunExportOptions& options, const Session& session) {
  const db::RunStore store = db::RunStore::open_read_only(session.db);
  const db::RunRecord run = store.run(options.run);
  std::size_t bytes = 0;
  if (options.format == "hdf5") {
    check_output(options.output, kHdf5File, session.replace);
    bytes = write_run_hdf5(store, run, options.output);
  } else {
    const bool frames = store.series(run.run).empty();
    const std::string kind = options.format == "json" ? kRunDocument : frames ? kRunTable : kind_of_file(kSeriesHead);
    const auto write = [&](std::ostream& stream) {
      if (options.format == "json") return run_document(store, run, stream);
      if (frames) return frames_csv(store, run, stream);
      stream << series_csv(store, run);
    };
    bytes = write_output(options.output, kind, write, session.replace);
  }
  if (session.json) {
    print_json("runs.export",
               {{"run", run.run}, {"format", options.format}, {"path", options.output}, {"bytes", bytes}});
  } else {
    tty::print("run {}: {} bytes of {} in {}\n", run.run, bytes, options.format, options.output);
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
    print_json("runs.copy", {{"store", session.db}, {"to", file}, {"runs", list}, {"verdicts_left_behind", left}});
}

}  // namespace

void add_run_copy(CLI::App& runs, Session& session) {
  auto numbers = std::make_shared<std::vector<std::int64_t>>();
  auto file = std::make_shared<std::string>();
  CLI::App* verb =
      runs.add_subcommand("copy", "copy ended runs with their models, verdicts and remarks into another store");
  verb->footer(
      "A verdict is copied with the judged run; when only the models' run is copied, a note names the verdicts left "
      "behind.");
  verb->add_option("runs", *numbers, "run numbers")->required()->take_all();
  verb->add_option("--to", *file, "the other store; made if it does not exist")->required();
  add_common(*verb, session);
  verb->callback([numbers, file, &session] { copy_runs(*numbers, *file, session); });
}

void add_run_export(CLI::App& runs, Session& session) {
  auto options = std::make_shared<RunExportOptions>();
  CLI::App* verb =
      runs.add_subcommand("export", "write a run's frames (or an imported run's series) as CSV, JSON or HDF5");
  verb->add_option("run", options->run, "run number")->required();
  verb->add_option("--format", options->format, "csv: one line per scan, raw counts; json, hdf5: the whole run")
      ->check(CLI::IsMember({"csv", "json", "hdf5"}))
      ->capture_default_str();
  verb->add_option("-o,--output", options->output, "file to write")->required();
  add_replace(*verb, session);
  add_common(*verb, session);
  verb->callback([options, &session] { export_run(*options, session); });
}

}  // namespace tactbench::bench
