// runs export: all data of a run for programs that do not read SQLite. Raw counts, every scan.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <iosfwd>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <ostream>
#include <set>

#include "analysis/documents/run_json.h"
#include "analysis/error.h"
#include "analysis/json_fields.h"
#include "analysis/json_io.h"
#include "analysis/scanner_scale.h"
#include "analysis/table_head.h"
#include "bench/cli/runs/source.h"
#include "bench/cli/session.h"
#include "bench/common/error.h"
#include "bench/common/output_file.h"
#include "bench/common/terminal.h"
#include "db/run_store.h"

namespace tactbench::bench {

namespace {

constexpr const char* kSeriesHead = "sequence,name,taxel,position,input,output\n";

// A number in round-trip notation; empty without a reading.
std::string csv_number(double value) { return std::isfinite(value) ? fmt::format("{}", value) : std::string(); }

// All digits of a time: 71850000000 ns as 71.85.
std::string csv_seconds(std::int64_t ns) {
  std::string text =
      fmt::format("{}{}.{:09}", ns < 0 ? "-" : "", std::abs(ns / 1'000'000'000), std::abs(ns % 1'000'000'000));
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

// Typed text may hold commas and quotes (RFC 4180), and what a spreadsheet takes for a formula.
std::string csv_text(std::string text) {
  if (analysis::is_formula(text)) text.insert(0, 1, '\'');
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::string sequence_name(const db::RunRecord& run, int sequence) {
  const auto found = std::ranges::find(run.sequences, sequence, &db::SequenceRecord::sequence);
  return found == run.sequences.end() ? std::string() : found->name;
}

std::optional<double> volts_a_count(const db::RunRecord& run) {
  try {
    return analysis::volts_per_count(run);
  } catch (const analysis::AnalysisError&) {
    return std::nullopt;
  }
}

std::string run_lines(const db::RunRecord& run, const std::optional<double>& scale) {
  std::vector<std::string> recipes;
  for (const db::SequenceRecord& sequence : run.sequences) recipes.push_back(sequence.name);
  std::string text = fmt::format("# tactbench: frames of run {}\n", run.run);
  const auto line = [&](const char* name, const std::string& value) {
    text += fmt::format("# {}: {}\n", name, value.empty() ? "not stated" : one_line(value));
  };
  line("origin", run.origin);
  line("sensor", run.sensor_serial);
  line("scanner", run.scanner_serial);
  line("bench", run.bench_id);
  line("recipes", fmt::format("{}", fmt::join(recipes, ", ")));
  line("operator", run.operator_name);
  for (const auto& [key, value] : analysis::metadata_of(run)) line(("metadata " + key).c_str(), value);
  line("started_utc", run.started_utc);
  line("outcome", db::to_string(run.outcome));
  if (run.is_void()) line("void", run.void_reason);
  line("uuid", run.uuid);
  line("content_sha256", run.content_sha256);
  line("program", fmt::format("{} {}", run.program_version, run.git_commit));
  line("volts_per_count", scale ? fmt::format("{}", *scale) : "");
  text +=
      "# units: by the ending of a column's name (psi, n: N, nmm: N mm, mm, s, us: microseconds); volts_rR_cC: V of "
      "row R and "
      "column C; counts_rR_cC: counts of the converter\n";
  return text;
}

std::string csv_names(int rows, int columns, bool volts) {
  std::string text =
      "frame,sequence,recipe,repeat,branch,attempt,void,step,setpoint_psi,feedback_psi,reference_psi,target_n,"
      "fx_n,fy_n,fz_n,tx_nmm,ty_nmm,tz_nmm,x_mm,y_mm,z_mm,time_s,since_command_s,in_band_s,device_time_us,status,flags,"
      "scan";
  for (const char* what : {"counts", "volts"}) {
    if (what[0] == 'v' && !volts) continue;
    for (int row = 0; row < rows; ++row)
      for (int column = 0; column < columns; ++column) text += fmt::format(",{}_r{}_c{}", what, row, column);
  }
  return text + "\n";
}

// The branch of a frame; `branches` as the store gives them. Throws Error TB-STORE-SQL when there is none.
const db::BranchRecord& branch_in(const std::vector<db::BranchRecord>& branches, std::int64_t key) {
  const auto found = std::ranges::lower_bound(branches, key, {}, &db::BranchRecord::branch);
  if (found != branches.end() && found->branch == key) return *found;
  throw Error("TB-STORE-SQL", fmt::format("a frame names the branch {}, which the run lacks", key), "runs export",
              "tactbench verify RUN shows what else differs");
}

// First lines about the run, which begin with '#'; then the names of the columns, which end in their unit; then one
// line per scan: the values of its frame, raw counts and, if the scanner's volts per count are stored, volts. Times
// have all their digits, volts seven; a value that was not measured is empty. Written frame by frame, because a long
// run does not fit in memory.
void frames_csv(const db::RunReader& store, const db::RunRecord& run, std::ostream& stream) {
  const std::vector<db::BranchRecord> branches = store.branches(run.run);
  const std::optional<double> scale = volts_a_count(run);
  std::int64_t position = 0;
  std::string text;
  const auto out = std::back_inserter(text);
  stream << run_lines(run, scale);
  store.for_each_frame(run.run, [&](const db::FrameRecord& f) {
    if (++position == 1) stream << csv_names(f.rows, f.columns, scale.has_value());
    text.clear();
    const db::BranchRecord& b = branch_in(branches, f.branch);
    std::string head =
        fmt::format("{},{},{},{},{},{},{},{},{},{},{},", position, b.sequence, csv_text(sequence_name(run, b.sequence)),
                    b.repeat, b.ordinal, b.attempt, b.is_void ? 1 : 0, f.ordinal, csv_number(f.setpoint_psi),
                    csv_number(f.feedback_psi), csv_number(f.reference_psi));
    head += f.wrench ? csv_number(f.wrench->target_n) : std::string();
    for (std::size_t i = 0; i < 6; ++i)
      head += fmt::format(",{}", f.wrench ? csv_number(f.wrench->wrench.at(i)) : std::string());
    for (std::size_t i = 0; i < 3; ++i)
      head += fmt::format(",{}", f.wrench ? csv_number(f.wrench->place_mm.at(i)) : std::string());
    head += fmt::format(",{},{},{},{},{},{}", csv_seconds(f.time_ns), csv_seconds(f.since_command_ns),
                        csv_seconds(f.in_band_ns), f.device_time_us, f.status, csv_text(f.flags));
    const auto taxels = static_cast<std::size_t>(f.rows) * static_cast<std::size_t>(f.columns);
    for (std::size_t scan = 0; scan * taxels < f.counts.size(); ++scan) {
      fmt::format_to(out, "{},{}", head, scan);
      for (std::size_t i = 0; i < taxels; ++i) fmt::format_to(out, ",{}", f.counts.at(scan * taxels + i));
      for (std::size_t i = 0; scale && i < taxels; ++i)
        fmt::format_to(out, ",{:.7g}", *scale * f.counts.at(scan * taxels + i));
      text += "\n";
    }
    stream << text;
  });
  if (position == 0) stream << csv_names(0, 0, false);
}

void series_csv(const db::RunReader& store, const db::RunRecord& run, std::ostream& stream) {
  stream << kSeriesHead;
  for (const db::SeriesRecord& s : store.series(run.run)) {
    for (std::size_t i = 0; i < s.input.size(); ++i) {
      stream << fmt::format("{},{},{},{},{},{}\n", s.sequence, csv_text(sequence_name(run, s.sequence)), s.taxel, i,
                            csv_number(s.input[i]), csv_number(s.output.at(i)));
    }
  }
}

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
    store.for_each_frame(run.run, [&](const db::FrameRecord& f) { put(frame_json(f, branch_in(branches, f.branch))); });
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
            "note: the models of run {0} were judged on run {1}, which is not copied, so that verdict is left behind; "
            "to "
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
                   "numbers of ended runs; with --from also UUIDs; none: copy the whole store into a new file, "
                   "possible even while a run is written")
      ->take_all();
  add_from_option(*verb, *from);
  verb->add_option("--to", *file, "the other store; made if it does not exist")->required();
  verb->callback([names, file, from, &session] {
    if (names->empty() && !from->empty())
      throw Error("TB-USAGE", "--from copies runs of a fleet, but no run is named", "--from",
                  "name them by their UUIDs");
    if (names->empty()) return snapshot_db(*file, session);
    std::vector<std::int64_t> numbers;
    if (from->empty()) {
      for (const std::string& name : *names) numbers.push_back(run_number(name));
      return copy_runs(numbers, *file, session);
    }
    FleetImport fleet(session, *from);
    std::vector<db::fleet::FleetRun> chosen;
    for (const std::string& name : *names) {
      chosen.push_back(find_run_by_name(fleet.link(), name));
      numbers.push_back(chosen.back().run);
    }
    fleet.take(chosen);
    copy_runs(numbers, *file, session);
  });
}

void add_run_export(CLI::App& runs, Session& session) {
  auto options = std::make_shared<RunExportOptions>();
  CLI::App* verb = runs.add_subcommand("export", "write a run's frames as CSV, or the whole run as JSON");
  verb->add_option("run", options->run, "run number")->required();
  verb->add_option("--format", options->format, "csv: one line per scan, raw counts and volts; json: the whole run")
      ->check(CLI::IsMember({"csv", "json"}))
      ->capture_default_str();
  verb->add_option("-o,--output", options->output, "file to write")->required();
  add_replace(*verb, session);
  verb->callback([options, &session] { export_run(*options, session); });
}

}  // namespace tactbench::bench
