// The view of a run in `status` and `watch`: the live run's own status, completed from its store, and followed until
// the run ends. Read-only.
#pragma once

#include <chrono>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "analysis/pressure_unit.h"
#include "bench/common/error.h"
#include "bench/common/stop_request.h"
#include "bench/common/terminal.h"
#include "bench/monitor/heat_map.h"
#include "bench/run/control/control_client.h"
#include "db/run_store.h"

namespace tactbench::bench {

// Whether an event shows the progress of a run; commands to actuators, readings and accounts do not.
bool shows_progress(const db::EventRecord& event);

struct StoredRun {
  db::RunRecord record;
  std::int64_t frames = 0;
  std::vector<db::EventRecord> events;  // the last events that show progress, oldest first
  std::int64_t report = 0;              // for a completed run: reporting_run() of bench/reporting/judgement.h
};

// Throws StoreError: TB-STORE-NOT-FOUND.
StoredRun stored_run(const db::RunStore& store, std::int64_t run);

struct RunView {
  LiveRun live;
  std::optional<StoredRun> stored;
  std::string unread;  // reason why the store cannot be read
};

// Adds what the run's own store holds; if the store cannot be read, only the live status is shown.
RunView view_of(const LiveRun& live);

// As lines of text: run, recipe, phase, pressure or force, time, frames, events; the first `kNeeded` are the most
// important.
inline constexpr std::size_t kNeeded = 6;
std::vector<std::string> view_lines(const RunView& view, analysis::PressureUnit unit = analysis::PressureUnit::kPsi);
// The same in one line, for output that is not a terminal.
nlohmann::ordered_json view_json(const RunView& view);

// Lines of a run without a process. `carried_out`: is_carried_out() of bench/run/control/locks.h.
std::vector<std::string> stored_lines(const StoredRun& run, std::optional<bool> carried_out);
nlohmann::ordered_json stored_json(const StoredRun& run, std::optional<bool> carried_out);
// The command to type after a run that has ended; `db`: the store's path for the command line.
std::string next_command(const StoredRun& run, const std::string& db);
// The exit code that the run should have had, from the stored data: 0 completed, 1 refused by a check, 3 device,
// process or another failure, 4 stopped or aborted, 5 store, 7 the safe state was not verified.
ExitCode exit_code_of(const db::RunRecord& run);

// Follows a live run until it ends: in a terminal one block that is redrawn in place, otherwise plain lines. Read-only.
struct WatchRunOptions {
  bool terminal = false;
  Shades shades = Shades::kCharacters;
  analysis::PressureUnit unit = analysis::PressureUnit::kPsi;
  std::chrono::milliseconds every{500};         // between two requests to the run
  std::chrono::milliseconds line_every{10000};  // plain lines: between two lines of one phase
};

// Returns the run as its store holds it after its end; none: `stop` came first. Throws StoreError when the store of the
// ended run cannot be read.
std::optional<StoredRun> watch_run(const LiveRun& first, const WatchRunOptions& options, const StopRequest& stop);

}  // namespace tactbench::bench
