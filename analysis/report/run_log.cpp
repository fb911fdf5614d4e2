#include "analysis/report/run_log.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <sstream>

#include "analysis/json_io.h"

namespace tactbench::analysis {
namespace {

void add_surroundings(std::vector<EnvironmentRange>& ranges, const db::EventRecord& event) {
  char* end = nullptr;
  const double value = std::strtod(event.detail.c_str(), &end);
  if (end == event.detail.c_str() || !std::isfinite(value)) return;
  auto range = std::ranges::find(ranges, event.id, &EnvironmentRange::quantity);
  if (range == ranges.end()) range = ranges.insert(range, {event.id, value, value, 0});
  range->low = std::min(range->low, value);
  range->high = std::max(range->high, value);
  ++range->readings;
}

// States are stored as "running -> paused: why".
std::string kind_of_state(const std::string& detail) {
  if (detail.find("-> paused") != std::string::npos) return "pause";
  if (detail.find("-> suspended") != std::string::npos) return "suspension";
  return {};
}

void add_event(RunLog& history, const db::EventRecord& event) {
  static const std::set<std::string> reported = {"attempt", "branch-broken", "warning", "fault", "prompt", "word"};
  if (event.kind == "environment") return add_surroundings(history.surroundings, event);
  if (event.kind == "time") {
    history.time_spent = event.detail;
    return;
  }
  std::string kind = event.kind == "state" ? kind_of_state(event.detail) : event.kind;
  if (event.kind != "state" && !reported.contains(event.kind)) {
    if (event.kind != "seating") return;
    kind = "note";  // why the check was left out
  }
  if (kind.empty()) return;
  history.events.push_back({1e-9 * static_cast<double>(event.time_ns), kind, event.detail});
}

// Loaded minus unloaded in volt; empty when the check is not of that shape.
std::vector<double> seating_response(const db::CheckRecord& check) {
  const auto json = try_json(check.detail_json);
  if (!json.is_object() || !json.contains("volts_per_count") || !json["volts_per_count"].is_number()) return {};
  const double volts_per_count = json["volts_per_count"].get<double>();
  const std::size_t taxels = check.data.size() / 2;
  std::vector<double> response;
  for (std::size_t i = 0; i < taxels; ++i)
    response.push_back(volts_per_count * (check.data[taxels + i] - check.data[i]));
  return response;
}

// Null: the run has none.
const db::CheckRecord* newest_seating(const RunLog& history) {
  const auto own = std::find_if(history.checks.rbegin(), history.checks.rend(),
                                [](const db::CheckRecord& check) { return check.kind == "seating"; });
  return own == history.checks.rend() ? nullptr : &*own;
}

}  // namespace

RunLog load_run_log(const StoredRun& run) {
  RunLog history;
  history.loaded = true;
  history.checks = run.checks;
  for (const db::EventRecord& event : run.events) add_event(history, event);
  const std::vector<db::SequenceRecord>& sequences = run.record.sequences;
  std::set<std::int64_t> voids;
  for (const db::BranchRecord& branch : run.branches) {
    history.presses = history.presses || branch.from_n || branch.to_n;
    if (!branch.is_void) continue;
    voids.insert(branch.branch);
    const auto sequence = std::ranges::find(sequences, branch.sequence, &db::SequenceRecord::sequence);
    history.voids.push_back({sequence == sequences.end() ? "" : sequence->name, branch.repeat, branch.ordinal,
                             branch.attempt, branch.void_reason});
  }
  for (const db::FrameRecord& frame : run.frames) {
    history.presses = history.presses || frame.wrench.has_value();
    if (voids.contains(frame.branch)) {
      ++history.void_frames;
      continue;
    }
    ++history.frames;
    if (!frame.flags.empty()) ++history.flagged;
    std::istringstream text(frame.flags);
    for (std::string word; text >> word;) ++history.flags[word];
  }
  if (const db::CheckRecord* own = newest_seating(history)) history.seating_v = seating_response(*own);
  return history;
}

void add_earlier_seating(RunLog& history, const db::RunReader& store, const db::RunRecord& run) {
  const db::CheckRecord* own = newest_seating(history);
  if (own == nullptr) return;
  for (const char* verdict : {"pass", "warning"}) {
    const std::optional<db::CheckRecord> earlier = store.last_check(run.sensor_serial, "seating", verdict, run.run);
    if (!earlier || earlier->data.size() != own->data.size()) continue;
    history.earlier_seating_v = seating_response(*earlier);
    history.earlier_seating_run = earlier->run;
    return;
  }
}

}  // namespace tactbench::analysis
