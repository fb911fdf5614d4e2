// What a run left in its store, and what it told of itself while it ran, as lines of text: for tests that compare whole
// runs with what was recorded of them. Seeds and a turned clock make every run the same.
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <numeric>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "db/run_store.h"
#include "tests/support/live_runs.h"
#include "tests/support/process.h"
#include "tests/support/small_run.h"

namespace tactbench::tests {

inline std::string to_millisecond(std::int64_t ns) { return fmt::format("{:.3f}", static_cast<double>(ns) * 1e-9); }

// Numbers of many digits, to six: libraries of mathematics differ in the last ones.
inline std::string with_short_numbers(const std::string& text) {
  static const std::regex kLong("-?[0-9]+\\.[0-9]{6,}(e-?[0-9]+)?");
  std::string cut;
  std::string::const_iterator done = text.begin();
  for (std::sregex_iterator found(text.begin(), text.end(), kLong), end; found != end; ++found) {
    cut.append(done, (*found)[0].first);
    cut += fmt::format("{:.6g}", std::stod(found->str()));
    done = (*found)[0].second;
  }
  return cut.append(done, text.end());
}

// Events and checks in the order of their times; of a check the first six of its data.
inline std::vector<std::string> told_by(const db::RunStore& store, std::int64_t run) {
  struct Line {
    std::int64_t time_ns = 0;
    std::string text;
  };
  std::vector<Line> lines;
  for (const db::EventRecord& event : store.events(run)) {
    const std::string id = event.id.empty() ? "" : " " + event.id;
    lines.push_back({event.time_ns, fmt::format("{}{}: {}", event.kind, id, event.detail)});
  }
  for (const db::CheckRecord& check : store.checks(run)) {
    const auto shown = static_cast<std::ptrdiff_t>(std::min<std::size_t>(check.data.size(), 6));
    const std::vector<double> first(check.data.begin(), check.data.begin() + shown);
    lines.push_back({check.time_ns, fmt::format("check {} {} {}: {:.6g}", check.kind, check.verdict,
                                                with_short_numbers(check.detail_json), fmt::join(first, " "))});
  }
  std::ranges::stable_sort(lines, {}, &Line::time_ns);
  std::vector<std::string> text;
  for (const Line& line : lines) {
    const std::size_t end = line.text.find_last_not_of(' ');
    text.push_back(to_millisecond(line.time_ns) + " " + line.text.substr(0, end + 1));
  }
  return text;
}

// Of a frame: its times; set-point, feedback and reference in psi and counts; its shape and the sum of its counts;
// exchanges; of the trace the number of readings and the sums of its columns; what was pressed with; flags.
inline std::string frame_line(const db::FrameRecord& frame) {
  std::string line = fmt::format(
      "{}: {} s, {} since command, {} in band; {:g} {:.3f} {:.3f} psi, {} {} {}; {}x{}x{} {}; {}", frame.ordinal,
      to_millisecond(frame.time_ns), to_millisecond(frame.since_command_ns), to_millisecond(frame.in_band_ns),
      frame.setpoint_psi, frame.feedback_psi, frame.reference_psi, frame.setpoint_counts, frame.feedback_counts,
      frame.reference_counts, frame.scans, frame.rows, frame.columns,
      std::accumulate(frame.counts.begin(), frame.counts.end(), std::int64_t{0}), frame.exchanges);
  double before_s = 0.0, setpoint = 0.0, feedback = 0.0, reference = 0.0;
  for (const db::TracePoint& point : frame.trace) {
    before_s += static_cast<double>(point.before_frame_s);
    setpoint += static_cast<double>(point.setpoint_psi);
    feedback += static_cast<double>(point.feedback_psi);
    reference += static_cast<double>(point.reference_psi);
  }
  line += fmt::format("; {}: {:.2f} {:.2f} {:.2f} {:.2f}", frame.trace.size(), before_s, setpoint, feedback, reference);
  if (const auto& wrench = frame.wrench) {
    line += fmt::format("; {:g} N from {:.3f}, {:.3f} at {:g} {:g} {:.4f}, raw {:.0f}", wrench->target_n,
                        wrench->force_start_n, fmt::join(wrench->wrench, " "), wrench->place_mm[0], wrench->place_mm[1],
                        wrench->place_mm[2], fmt::join(wrench->raw, " "));
  }
  return frame.flags.empty() ? line : line + "; " + frame.flags;
}

// Branches, each with its frames.
inline std::vector<std::string> measured_by(const db::RunStore& store, std::int64_t run) {
  std::vector<std::string> text;
  const std::vector<db::FrameRecord> frames = store.frames(run);
  for (const db::BranchRecord& branch : store.branches(run)) {
    std::string head = fmt::format("branch {}.{}.{} attempt {}: {:g} to {:g} psi", branch.sequence, branch.repeat,
                                   branch.ordinal, branch.attempt, branch.from_psi, branch.to_psi);
    if (branch.from_n && branch.to_n) head += fmt::format(", {:g} to {:g} N", *branch.from_n, *branch.to_n);
    if (branch.is_void) head += ", void: " + branch.void_reason;
    text.push_back(head);
    for (const db::FrameRecord& frame : frames) {
      if (frame.branch == branch.branch) text.push_back(frame_line(frame));
    }
  }
  return text;
}

inline std::string status_line(const bench::RunStatus& status) {
  std::string line = fmt::format("step {} of {}, {} of {} frames: {}", status.step, status.steps, status.frames,
                                 status.frames_planned, status.phase);
  if (status.target_n) line += fmt::format(", {:g} N", *status.target_n);
  if (const auto& now = status.readings) {
    line += fmt::format("; {:.3f} s {:g} {:.3f} {:.3f} psi{}", now->time_s, now->setpoint_psi, now->feedback_psi,
                        now->reference_psi, now->settled ? " settled" : "");
    if (now->force_n) line += fmt::format(" {:.3f} N", *now->force_n);
  }
  return line;
}

// The status that a client of the run gets as each step begins, the result, and what the run left.
inline std::vector<std::string> lines_of_run(bench::RunRequest request, db::RunStore& store) {
  std::vector<std::string> lines;
  request.on_step = [&](const sequences::Step&) {
    const std::vector<bench::LiveRun> live = live_runs();
    if (live.size() == 1) lines.push_back(status_line(live.front().status));
  };
  const bench::RunResult result = run_small(request, store);
  lines.push_back(fmt::format("{} of {} frames, {} exchanges, {} redone, {:.3f} s, waiting {:.3f} s: {}", result.frames,
                              result.frames_kept, result.most_exchanges_a_step, result.branches_redone,
                              result.process_seconds, result.waiting_seconds, result.time_spent));
  if (result.error) {
    // A person is told where the simulated instrument listens.
    static const std::regex kWhere("[^ ]*/tactbench-[^/ ]+|:[0-9]{4,5} ");
    lines.push_back(fmt::format("{} {}: {} | {} | {} | {}", static_cast<int>(result.error->code()), result.error->id(),
                                std::regex_replace(std::string(result.error->what()), kWhere, "..."),
                                result.error->where(), result.error->remedy(), result.error->rig_state()));
  }
  for (const auto& more : {told_by(store, result.run), measured_by(store, result.run)})
    lines.insert(lines.end(), more.begin(), more.end());
  return lines;
}

// In a store of its own.
inline std::vector<std::string> lines_of_run(const bench::RunRequest& request) {
  const TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
  return lines_of_run(request, store);
}

// The same of a run of one branch up and one down, without the lines on what fails safe; `more`: the end of its recipe.
inline std::vector<std::string> lines_of_two_branches(const std::vector<sequences::Override>& overrides,
                                                      const std::string& more,
                                                      const std::vector<bench::PlannedFault>& faults = {}) {
  bench::RunRequest request = small_request(overrides);
  request.recipes = {recipe_of("unit = \"psi\"\nturning_points = [0, 4, 2]\nstep = 2\nrepeats = 1\n" + more)};
  request.bench.simulation->plant.faults = faults;
  std::vector<std::string> lines = lines_of_run(request);
  std::erase_if(lines, [](const std::string& line) { return line.starts_with("0.000 fail-safe"); });
  return lines;
}

// `expected`: lines, the first after a line break.
inline void check_lines(const std::vector<std::string>& made, const std::string& expected) {
  std::istringstream text(expected.substr(1));
  std::size_t at = 0;
  for (std::string line; std::getline(text, line); ++at) {
    INFO("line " << at + 1);
    CHECK((at < made.size() ? made[at] : "(none)") == line);
  }
  CHECK(made.size() == at);
}

}  // namespace tactbench::tests
