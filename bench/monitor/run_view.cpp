#include "bench/monitor/run_view.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <utility>

#include "analysis/counted.h"
#include "analysis/documents/run_json.h"
#include "analysis/json_fields.h"
#include "bench/common/error_table.h"
#include "bench/common/terminal.h"
#include "bench/reporting/judgement.h"
#include "bench/run/control/locks.h"

namespace tactbench::bench {
namespace {

constexpr std::size_t kEvents = 3;
constexpr double kSilent = 5.0;  // s without a sign of work, from which on it is reported

double seconds_of(const db::EventRecord& event) { return static_cast<double>(event.time_ns) * 1e-9; }

std::string recipes_of(const db::RunRecord& run) {
  std::vector<std::string> names;
  for (const db::SequenceRecord& sequence : run.sequences) names.push_back(sequence.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

std::string event_line(const db::EventRecord& event) {
  return fmt::format("{} {}{}{}: {}", clock_text(seconds_of(event)), event.kind, event.id.empty() ? "" : " ", event.id,
                     event.detail);
}

std::string readings_text(const RunStatus& status, analysis::PressureUnit unit) {
  if (!status.readings) return "not read yet";
  const RunReadings& now = *status.readings;
  if (status.target_n) {
    return fmt::format("level {:.2f} N, measured {}", *status.target_n,
                       now.force_n ? fmt::format("{:.2f} N", *now.force_n) : "not read yet");
  }
  return fmt::format("set-point {}, feedback {}, reference {}, {}", unit.fixed(now.setpoint_psi, 1),
                     unit.fixed(now.feedback_psi, 2), unit.text(now.reference_psi, 2),
                     now.settled ? "settled" : "not settled");
}

std::string left_text(const RunStatus& status) {
  if (status.left_high_s <= 0.0)
    return status.left_s > 0.0 ? fmt::format("about {} left", clock_text(status.left_s)) : "time left not known yet";
  const std::string prompts =
      status.prompts_left == 0 ? "" : fmt::format(" + {}", analysis::counted(status.prompts_left, "prompt"));
  return fmt::format("{} left{} ({} to {})", clock_text(status.left_s), prompts, clock_text(status.left_low_s),
                     clock_text(status.left_high_s));
}

std::string time_text(const RunStatus& status) {
  const std::string elapsed =
      status.readings ? "elapsed " + clock_text(status.readings->time_s) + " of process time, " : "";
  const std::string pace = status.rate == 1.0  ? ""
                           : status.rate > 0.0 ? fmt::format("; {:g} x real time", status.rate)
                                               : "; simulated clock";
  const std::string silent = status.age_s < kSilent ? "" : fmt::format("; nothing new for {:.0f} s", status.age_s);
  return elapsed + left_text(status) + pace + silent;
}

std::string line(const char* name, const std::string& text) { return fmt::format("  {:<10}{}", name, text); }

std::string who_text(const db::RunRecord& run) {
  return fmt::format("{}; sensor {}, operator {}", recipes_of(run), run.sensor_serial, run.operator_name);
}

}  // namespace

bool shows_progress(const db::EventRecord& event) {
  constexpr std::array kQuiet{"command", "stage", "environment", "fail-safe", "relays", "time", "prompt"};
  return std::ranges::find(kQuiet, event.kind) == kQuiet.end();
}

StoredRun stored_run(const db::RunStore& store, std::int64_t run) {
  StoredRun stored{store.run(run), store.frame_count(run), {}, 0};
  if (stored.record.outcome == db::Outcome::kCompleted) stored.report = reporting_run(store, standing(store, run), run);
  store.newest_events(run, [&](const db::EventRecord& event) {
    if (shows_progress(event)) stored.events.push_back(event);
    return stored.events.size() < kEvents;
  });
  std::ranges::reverse(stored.events);
  return stored;
}

RunView view_of(const LiveRun& live) {
  RunView view{live, {}, {}};
  try {
    view.stored = stored_run(db::RunStore::open_read_only(live.status.store), live.status.run);
  } catch (const db::StoreError& error) {
    view.unread = error.what();
  }
  return view;
}

std::vector<std::string> view_lines(const RunView& view, analysis::PressureUnit unit) {
  const RunStatus& status = view.live.status;
  std::vector<std::string> lines;
  lines.push_back(fmt::format("run {} on bench '{}'{}: {}", status.run, view.live.bench,
                              view.stored && view.stored->record.origin == "simulated" ? " (simulated)" : "",
                              to_string(status.state)));
  if (view.stored) lines.push_back(line("recipe", who_text(view.stored->record)));
  if (!view.unread.empty()) lines.push_back(line("store", view.unread));
  lines.push_back(line("phase", status.phase));
  lines.push_back(line(status.target_n ? "force" : "pressure", readings_text(status, unit)));
  lines.push_back(line("time", time_text(status)));
  const std::string in_void =
      status.frames_void == 0 ? "" : fmt::format("; {} more in void branches", status.frames_void);
  lines.push_back(
      line("frames", fmt::format("{} stored, {} planned{}", status.frames, status.frames_planned, in_void)));
  if (!view.stored) return lines;
  const char* name = "events";
  for (const db::EventRecord& event : view.stored->events)
    lines.push_back(line(std::exchange(name, ""), one_line(event_line(event))));
  return lines;
}

namespace {

void add_events(nlohmann::ordered_json& json, const StoredRun& run) {
  nlohmann::ordered_json& events = json["events"] = nlohmann::ordered_json::array();
  for (const db::EventRecord& event : run.events)
    events.push_back({{"time_s", seconds_of(event)}, JSON_FIELDS(event, kind, id, detail)});
}

void add_record(nlohmann::ordered_json& json, const db::RunRecord& run) {
  const nlohmann::ordered_json whole = analysis::run_json(run);
  for (const char* key : {"recipes", "sensor", "operator", "origin", "started_utc"}) json[key] = whole.at(key);
}

}  // namespace

nlohmann::ordered_json view_json(const RunView& view) {
  nlohmann::json status;
  add_status_json(status, view.live.status);
  nlohmann::ordered_json json = {
      {"run", view.live.status.run}, {"bench", view.live.bench}, {"process", view.live.server.process}};
  for (const char* key : {"store", "state", "phase", "question", "reason", "step", "steps", "frames", "frames_void",
                          "frames_planned", "left_s", "left_low_s", "left_high_s", "prompts_left", "rate", "age_s"})
    json[key] = status.at(key);
  json["target_n"] = status.value("target_n", nlohmann::json());
  json["readings"] = status.value("readings", nlohmann::json());
  if (view.stored) {
    add_record(json, view.stored->record);
    add_events(json, *view.stored);
  } else {
    json["store_unread"] = view.unread;
  }
  return json;
}

std::vector<std::string> stored_lines(const StoredRun& run, std::optional<bool> carried_out) {
  const db::RunRecord& record = run.record;
  const bool open = record.outcome == db::Outcome::kIncomplete;
  const char* process = !open                  ? ""
                        : carried_out == true  ? " (a process carries it out)"
                        : carried_out == false ? " (no process carries it out)"
                                               : "";
  std::vector<std::string> lines;
  lines.push_back(fmt::format("run {} on bench '{}'{}: {}{}, {}", record.run, record.bench_id,
                              record.origin == "simulated" ? " (simulated)" : "", db::to_string(record.outcome),
                              process, analysis::counted(run.frames, "frame")));
  lines.push_back(line("recipe", who_text(record)));
  if (!record.reason.empty()) lines.push_back(line("reason", one_line(record.reason)));
  if (!open) lines.push_back(line("safe", db::to_string(record.safe_state)));
  lines.push_back(line(open ? "started" : "ended", open ? record.started_utc : record.ended_utc));
  return lines;
}

nlohmann::ordered_json stored_json(const StoredRun& run, std::optional<bool> carried_out) {
  nlohmann::ordered_json json = analysis::run_json(run.record);
  json["frames"] = run.frames;
  if (carried_out) json["lives"] = *carried_out;
  add_events(json, run);
  return json;
}

std::string next_command(const StoredRun& run, const std::string& db) {
  const std::string store = db == "runs.db" ? "" : " --db " + db;
  if (run.report != 0) return fmt::format("tactbench report {}{}", run.report, store);
  const bool done = run.record.outcome == db::Outcome::kCompleted;
  return fmt::format("tactbench {} {}{}", done ? "fit" : "resume", run.record.run, store);
}

ExitCode exit_code_of(const db::RunRecord& run) {
  const bool ended = run.outcome != db::Outcome::kIncomplete && run.outcome != db::Outcome::kInterrupted;
  if (ended && run.safe_state != db::SafeState::kVerified) return ExitCode::kUnsafe;
  if (run.outcome == db::Outcome::kCompleted) return ExitCode::kPass;
  if (run.outcome == db::Outcome::kStopped || run.outcome == db::Outcome::kAborted) return ExitCode::kStopped;
  const ErrorRow* error = error_row(std::string_view(run.reason).substr(0, run.reason.find(':')));
  return error != nullptr ? error->exit_code : ExitCode::kDevice;
}

namespace {

using WatchClock = std::chrono::steady_clock;

constexpr std::size_t kLeastMap = 5;  // lines

std::string view_line(const RunView& view, analysis::PressureUnit unit = analysis::PressureUnit::kPsi) {
  const RunStatus& status = view.live.status;
  return fmt::format("run {} {}: {}; {}; {}; {} stored", status.run, to_string(status.state), status.phase,
                     readings_text(status, unit), time_text(status), analysis::counted(status.frames, "frame"));
}

// The lines with the array below them, for a screen of that size. If it is too small, first events are left out, then
// the map is drawn coarser, and below five lines the map is left out.
std::vector<PaintedLine> watch_block(const std::vector<std::string>& lines, const std::optional<ArrayView>& array,
                                     Shades shades, ScreenSize size) {
  const std::size_t room = std::max<std::size_t>(size.rows, 2) - 1;
  std::size_t texts = std::min(lines.size(), room);
  std::vector<PaintedLine> map;
  if (array) {
    const auto whole = static_cast<std::size_t>(array->rows) + 1;
    if (texts + whole > room) texts = std::min(texts, std::max(kNeeded, room - std::min(room, whole)));
    texts = std::min(texts, room);
    if (room - texts >= std::min(kLeastMap, whole)) map = heat_map(*array, shades, size.columns, room - texts);
    if (map.empty()) texts = std::min(lines.size(), room);
  }
  std::vector<PaintedLine> block;
  for (std::size_t i = 0; i < texts; ++i) block.push_back({{lines[i]}});
  block.insert(block.end(), map.begin(), map.end());
  return block;
}

class Watching {
 public:
  Watching(const LiveRun& first, const WatchRunOptions& options)
      : name_(first.name), options_(options), last_{first, {}, {}} {}

  std::optional<StoredRun> until_end(const StopRequest& stop) {
    for (std::optional<LiveRun> answer = last_.live; stop.signal() == 0;
         answer = send_command(name_, Command::kStatus, last_.live.server)) {
      const bool ours =
          answer && !answer->denied && answer->status.run == run() && answer->status.store == last_.live.status.store;
      if (ours) {
        last_ = view_of(*answer);
        show({});
      } else if (auto ended = end_of_run()) {
        return ended;
      } else {
        show("it does not answer: its process is stopped, or is ending");
      }
      (void)::poll(nullptr, 0, static_cast<int>(options_.every.count()));  // a signal ends it early
    }
    return std::nullopt;
  }

 private:
  [[nodiscard]] std::int64_t run() const { return last_.live.status.run; }

  // None: a process still carries it out.
  std::optional<StoredRun> end_of_run() {
    const db::RunStore store = db::RunStore::open_read_only(last_.live.status.store);
    StoredRun stored = stored_run(store, run());
    const bool open = stored.record.outcome == db::Outcome::kIncomplete;
    const std::optional<bool> carried_out = open ? is_carried_out(store.path(), run()) : false;
    if (carried_out == true) return std::nullopt;
    const std::vector<std::string> lines = stored_lines(stored, carried_out);
    if (options_.terminal) {
      paint(lines, newest_array(store, stored.record, options_.unit));
    } else {
      for (const std::string& line : lines) tty::print("{}\n", line);
    }
    return stored;
  }

  void show(const std::string& notice) {
    if (options_.terminal) {
      std::vector<std::string> lines = view_lines(last_, options_.unit);
      if (!notice.empty()) lines.front() += "; " + notice;
      return paint(lines, array());
    }
    const std::string phase = stage_of(last_.live.status.phase) + notice;
    const auto now = WatchClock::now();
    if (phase == shown_phase_ && now - shown_ < options_.line_every) return;
    shown_phase_ = phase;
    shown_ = now;
    tty::print("{}{}{}\n", view_line(last_, options_.unit), notice.empty() ? "" : "; ", notice);
    (void)std::fflush(stdout);
  }

  // Read again only when there is a new frame.
  const std::optional<ArrayView>& array() {
    if (!last_.stored || (array_ && array_frames_ == last_.stored->frames)) return array_;
    try {
      array_ = newest_array(db::RunStore::open_read_only(last_.live.status.store), last_.stored->record, options_.unit);
      array_frames_ = last_.stored->frames;
    } catch (const db::StoreError&) {  // the next poll tries again
    }
    return array_;
  }

  void paint(const std::vector<std::string>& lines, const std::optional<ArrayView>& array) {
    const ScreenSize size = screen_size(STDOUT_FILENO);
    screen_.paint(watch_block(lines, array, options_.shades, size), size);
  }

  std::string name_;
  const WatchRunOptions& options_;
  RunView last_;
  ScreenBlock screen_;
  std::optional<ArrayView> array_;
  std::int64_t array_frames_ = 0;
  std::string shown_phase_;
  WatchClock::time_point shown_{};
};

}  // namespace

std::optional<StoredRun> watch_run(const LiveRun& first, const WatchRunOptions& options, const StopRequest& stop) {
  return Watching(first, options).until_end(stop);
}

}  // namespace tactbench::bench
