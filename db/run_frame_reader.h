// Reads the frames of one run that another process may still be writing, repeatedly and from a given position on, over
// a read-only connection that stays open. For readers that follow a run for hours, such as the page.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "db/run_store.h"

namespace tactbench::db {

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

class RunFrameReader {
 public:
  // Throws StoreError when the store's file cannot be opened. A run that does not exist has no frames.
  RunFrameReader(const RunStore& store, std::int64_t run);
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
