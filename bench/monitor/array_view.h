// The newest image of the array in a run's store: the last frame or, before the first frame, the one of the seating
// check.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/pressure_unit.h"
#include "db/run_frame_reader.h"
#include "db/run_store.h"

namespace tactbench::bench {

struct ArrayView {
  std::string title;  // "frame 19 at 40.0 psi"
  int rows = 0, columns = 0;
  std::vector<double> volts;    // rows x columns, row-major; mean of the frame's scans
  double full_scale_v = 0.0;    // of the converter
  std::vector<int> dead;        // row * columns + column
  std::vector<int> saturated;   // taxels of a frame with a scan at the converter's limit
  bool dead_are_known = false;  // true if there is an unloaded frame to compare with and the whole array is loaded
};

// Data that do not change during a run.
struct ArrayBasis {
  double volts_per_count = 0.0;
  std::vector<double> unloaded_v;  // by the newest seating check; empty: there is none
};
// None: the scanner's scale is not known yet. Throws StoreError.
std::optional<ArrayBasis> array_basis(const db::RunStore& store, const db::RunRecord& run);
ArrayView view_of_frame(const ArrayBasis& basis, const db::StoredFrame& frame,
                        analysis::PressureUnit unit = analysis::PressureUnit::kPsi);

// None: the run has neither a frame nor a seating check, or its scanner's scale is not known yet. Throws StoreError.
std::optional<ArrayView> newest_array(const db::RunStore& store, const db::RunRecord& run,
                                      analysis::PressureUnit unit = analysis::PressureUnit::kPsi);

}  // namespace tactbench::bench
