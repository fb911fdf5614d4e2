#include "bench/cli/export/run_export_csv.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <optional>
#include <ostream>

#include "analysis/documents/run_metadata.h"
#include "analysis/error.h"
#include "analysis/scanner_scale.h"
#include "analysis/table_fields.h"
#include "bench/common/error.h"
#include "bench/common/for_people.h"

namespace tactbench::bench {

namespace {

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

}  // namespace

const db::BranchRecord& branch_in(const std::vector<db::BranchRecord>& branches, std::int64_t key) {
  const auto found = std::ranges::lower_bound(branches, key, {}, &db::BranchRecord::branch);
  if (found != branches.end() && found->branch == key) return *found;
  throw Error("TB-STORE-SQL", fmt::format("a frame names the branch {}, which the run lacks", key), "runs export",
              "tactbench verify RUN shows what else differs");
}

void frames_csv(const db::RunStore& store, const db::RunRecord& run, std::ostream& stream) {
  const std::vector<db::BranchRecord> branches = store.branches(run.run);
  const std::optional<double> scale = volts_a_count(run);
  std::int64_t position = 0;
  std::string text;
  const auto out = std::back_inserter(text);
  stream << run_lines(run, scale);
  store.each_frame(run.run, [&](const db::FrameRecord& f) {
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

void series_csv(const db::RunStore& store, const db::RunRecord& run, std::ostream& stream) {
  stream << kSeriesHead;
  for (const db::SeriesRecord& s : store.series(run.run)) {
    for (std::size_t i = 0; i < s.input.size(); ++i) {
      stream << fmt::format("{},{},{},{},{},{}\n", s.sequence, csv_text(sequence_name(run, s.sequence)), s.taxel, i,
                            csv_number(s.input[i]), csv_number(s.output.at(i)));
    }
  }
}

}  // namespace tactbench::bench
