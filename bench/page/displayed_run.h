// Content of the page's first view: the live run of a store, or its last run, described as by `tactbench status`; its
// safe state with the readings that prove it, its newest events with their remedies, and the array's image.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bench/monitor/run_view.h"
#include "bench/page/frames.h"
#include "bench/page/http/http_server.h"
#include "bench/reporting/judgement.h"
#include "bench/run/control/control_client.h"

namespace tactbench::bench {

struct SafeStateText {
  std::string state;  // proved | loaded | unknown | none
  std::string text;
};
// `newest_safe`: the run's newest event of kind "safe". `live`: null when no process carries the run out.
SafeStateText safe_state_text(const LiveRun* live, const StoredRun* stored,
                              const std::optional<db::EventRecord>& newest_safe);

// Data that change many times per second.
nlohmann::json readings_json(const LiveRun& live);

class DisplayedRun {
 public:
  // `bench`: id of the bench whose last run is shown when none is live; empty: any bench.
  DisplayedRun(std::string db, std::string bench) : db_(std::move(db)), bench_(std::move(bench)) {}

  // Reads the store when `live` reports something new, else every few seconds; null: no run is live.
  void look(const LiveRun* live);
  // True once for each newer picture.
  bool consume_new_picture();
  [[nodiscard]] nlohmann::json picture() const;
  // `silent_s`: seconds since the run's last status.
  [[nodiscard]] nlohmann::json state(const LiveRun* live, double silent_s) const;
  // The store, opened once it exists. Null: it cannot be read, for the reason `why`.
  const db::RunStore* store(std::string* why = nullptr);
  [[nodiscard]] std::int64_t run() const { return stored_ ? stored_->record.run : 0; }

 private:
  using RealClock = std::chrono::steady_clock;
  void read_store(const LiveRun* live);
  void read_run(std::int64_t run);
  void update_frames();
  [[nodiscard]] std::int64_t last_run();
  void close();

  std::string db_, bench_, unread_;
  std::optional<db::RunStore> store_;
  std::uint64_t file_ = 0;  // its inode: a store that was replaced is opened again
  std::optional<StoredRun> stored_;
  std::vector<db::EventRecord> events_;  // newest first
  std::optional<db::EventRecord> newest_safe_;
  std::optional<bool> carried_out_;
  Standing calibration_;         // for an ended run: calibration_of()
  std::size_t nights_ = 0;       // stored_nights()
  std::int64_t last_frame_ = 0;  // its position, as stored
  std::int64_t before_ = 0;      // the sensor's last completed run before this one
  std::optional<RunFrames> frames_;
  bool new_picture_ = false;
  RealClock::time_point read_{};
  std::string seen_;  // state of the live run when the store was last read
  bool was_live_ = false;
};

// Finds the live run that belongs to a store and follows it through its control socket; when it ends, looks for the
// next one.
class RunFollower {
 public:
  // `bench`: its id; empty: any bench whose run writes to the store `db`. `heard`: called with each status received,
  // and with none once the run has closed the connection. `server` must outlive this.
  RunFollower(HttpServer& server, std::string db, std::string bench, std::function<void()> heard);
  void look();  // looks for a run if none is followed; to be called a few times per second
  // The newest status; none: no run is followed.
  [[nodiscard]] const std::optional<LiveRun>& live() const { return live_; }
  [[nodiscard]] double silent_s() const;  // since the last status; a run sends one twice a second

 private:
  using RealClock = std::chrono::steady_clock;
  void receive();
  void let_go(bool ours);

  HttpServer& server_;
  std::string db_, bench_;
  std::function<void()> heard_;
  std::unique_ptr<RunConnection> connection_;
  std::shared_ptr<void> watching_;
  std::string name_;       // name of the connected bench
  std::string our_store_;  // the store's path in the run's status; empty: not compared yet
  std::optional<LiveRun> live_;
  RealClock::time_point last_{};
  std::map<std::string, RealClock::time_point>
      foreign_;  // benches with other stores or of untrusted users, and when they were queried
};

}  // namespace tactbench::bench
