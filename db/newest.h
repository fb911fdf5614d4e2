// The newest rows of a run that another process may be writing, without reading the others: for status and watch of a
// live run.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "db/run_store.h"

namespace tactbench::db {

struct NewestFrame {
  std::int64_t position = 0;  // in the run, from 1
  double setpoint_psi = 0.0, reference_psi = 0.0;
  int rows = 0, columns = 0, scans = 0;
  std::vector<std::uint16_t> counts;  // scans x rows x columns, row-major, scan slowest
  std::optional<double> force_n;      // pressing, at frame time, of a frame taken under an indenter
};

// Both open the store's file again, read-only, and close it again; they wait for nobody. Throw StoreError.
// None: the run has no frame.
std::optional<NewestFrame> newest_frame(const RunStore& store, std::int64_t run);
// Newest first, until `see` returns false.
void newest_events(const RunStore& store, std::int64_t run, const std::function<bool(const EventRecord&)>& see);

}  // namespace tactbench::db
