// The part of a stored run's time that its recipe did not need: waits for people and conditions, the rest between an
// end and a resume, and work repeated because of them. Derived from the run's events.
#pragma once

#include <cstdint>
#include <vector>

#include "db/run_store.h"

namespace tactbench::bench {

struct LostTime {
  std::int64_t position = 0;  // position of the first frame that it delayed
  std::int64_t ns = 0;
};

// Ordered by position, at most one per frame. `last`: the run's last position. Throws StoreError.
std::vector<LostTime> lost_times(const db::RunStore& store, std::int64_t run, std::int64_t last);

}  // namespace tactbench::bench
