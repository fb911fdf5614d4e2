// Reads the runs of a store: rows, frames, events, checks, series. Separate functions check by the stored hashes that a
// run is unchanged. Writes nothing.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "db/record.h"

namespace tactbench::db {

class Database;

struct ContentCheck {
  std::string stored_sha256, computed_sha256;  // in hex; stored is empty until the run ends
  std::int64_t frames = 0;
  // The first difference from what was stored, as text, as far as the stored links of the chain show it; empty: none.
  std::string difference;
  // Set if the frames were removed by a retention rule: the rest of the run was checked, the frames were not.
  std::optional<PrunedRecord> pruned;
  [[nodiscard]] bool holds() const { return difference.empty(); }
};

struct RunFilter {
  std::string sensor_serial = {}, since_utc = {}, content_sha256 = {};  // empty: any
};

// Part of a RunStore, and valid as long as the store. TB-STORE-NOT-FOUND names the existing runs. frames(),
// for_each_frame() and content_hash(): TB-STORE-PRUNED for a run whose frames were removed.
class RunReader {
 public:
  explicit RunReader(Database& database) : database_(&database) {}

  [[nodiscard]] const std::string& path() const;  // of the store, as it was given
  [[nodiscard]] std::optional<SensorRecord> sensor(const std::string& serial) const;
  [[nodiscard]] std::vector<SensorRecord> sensors() const;

  // Newest last; without sequences and devices. Uses an index: runs left out by the filter cost no time.
  [[nodiscard]] std::vector<RunRecord> runs() const;
  [[nodiscard]] std::vector<RunRecord> runs(const RunFilter& filter) const;
  [[nodiscard]] RunRecord run(std::int64_t number) const;
  // The run with this UUID, which is the same run in every store; 0: none.
  [[nodiscard]] std::int64_t run_of_uuid(const std::string& uuid) const;
  [[nodiscard]] std::vector<BranchRecord> branches(std::int64_t run) const;
  [[nodiscard]] std::vector<FrameRecord> frames(std::int64_t run) const;  // in the order written
  void for_each_frame(std::int64_t run,
                      const std::function<void(const FrameRecord&)>& see) const;  // only one in memory at a time
  [[nodiscard]] std::int64_t frame_count(std::int64_t run) const;
  [[nodiscard]] std::int64_t void_frame_count(std::int64_t run) const;     // in void branches
  [[nodiscard]] std::int64_t flagged_frame_count(std::int64_t run) const;  // with any flag, also in void branches
  [[nodiscard]] int scans_of_first_frame(std::int64_t run) const;          // 0: the run has no frame
  [[nodiscard]] std::optional<PrunedRecord> pruned(std::int64_t run) const;
  [[nodiscard]] std::vector<EventRecord> events(std::int64_t run) const;
  // Newest first, until `see` returns false; the others are not read.
  void newest_events(std::int64_t run, const std::function<bool(const EventRecord&)>& see) const;
  [[nodiscard]] std::vector<CheckRecord> checks(std::int64_t run) const;
  [[nodiscard]] std::vector<SeriesRecord> series(std::int64_t run) const;  // by sequence, then taxel
  // The newest check of that kind and verdict from an earlier run of this sensor; void runs do not count.
  [[nodiscard]] std::optional<CheckRecord> last_check(const std::string& sensor_serial, const std::string& kind,
                                                      const std::string& verdict, std::int64_t before_run) const;
  [[nodiscard]] std::int64_t last_time_ns(std::int64_t run) const;  // time of its newest frame or event; 0: none

  // For time estimates; fast, because no frame is read. The sequences of the `newest` completed runs of a bench, newest
  // first.
  [[nodiscard]] std::vector<TimedSequence> timed_sequences(const std::string& bench_id, int newest) const;
  [[nodiscard]] std::int64_t last_position(
      std::int64_t run) const;  // position of the run's last frame, from 1; 0: no frame
  [[nodiscard]] std::optional<FrameTime> frame_time(std::int64_t run, std::int64_t position) const;
  [[nodiscard]] std::vector<TimedEvent> timed_events(std::int64_t run) const;  // in the order written

  // SHA-256 chained over the run's canonical content: everything except UUID, wall-clock times and time zone, host,
  // tags, notes and the run's number, which belongs to the file (hash_chain.h). Recomputed from the stored rows.
  [[nodiscard]] std::string content_hash(std::int64_t run) const;
  // Checks that a run's rows are unchanged since it ended. Accepts any run; one that has not ended has no stored hash,
  // so only the chain's links are checked.
  [[nodiscard]] ContentCheck check_content(std::int64_t run) const;
  // Checks that the run's fits, verdicts, approvals and void are unchanged since they were stored: one line per
  // difference.
  [[nodiscard]] std::vector<std::string> check_seals(std::int64_t run) const;
  // SQLite's own checks of the file (integrity_check, foreign_key_check), foreign objects, and gaps in the numbers of
  // runs and baselines, because none is ever deleted: one line per defect; empty: none.
  [[nodiscard]] std::vector<std::string> check_structure() const;

 protected:
  Database* database_;
};

struct StoredFrame {
  std::int64_t position = 0;  // in the run, from 1
  std::int64_t time_ns = 0;
  double setpoint_psi = 0.0, feedback_psi = 0.0, reference_psi = 0.0;
  int rows = 0, columns = 0, scans = 0;
  std::vector<std::uint16_t> counts;  // scans x rows x columns, row-major, scan slowest
  std::string flags;
  bool is_void = false;  // its branch was repeated, or will be
  std::optional<WrenchRecord> wrench;
};

// Mean of the frame's scans for each taxel, in counts.
std::vector<double> mean_counts(const StoredFrame& frame);

// Reads the frames of one run that another process may still be writing, repeatedly and from a given position on, over
// a read-only connection that stays open. For readers that follow a run for hours, such as the page.
class RunFrameReader {
 public:
  // Throws StoreError when the store's file cannot be opened. A run that does not exist has no frames.
  RunFrameReader(const RunReader& store, std::int64_t run);
  RunFrameReader(RunFrameReader&&) noexcept;
  RunFrameReader& operator=(RunFrameReader&&) noexcept;
  ~RunFrameReader();
  [[nodiscard]] std::int64_t run() const { return run_; }
  // The frames after `position` (0: from the first), oldest first, at most `most`; only one is in memory at a time.
  // Does not wait for the writer. Throws StoreError, also for a frame whose counts do not fit its shape.
  void frames_after(std::int64_t position, int most, const std::function<void(const StoredFrame&)>& see);
  std::optional<StoredFrame> newest();
  // Position of the frame before the newest `most`; 0: there are no older ones.
  std::int64_t before_newest(int most);

 private:
  struct Queries;
  std::int64_t run_;
  std::unique_ptr<Queries> queries_;
};

}  // namespace tactbench::db
