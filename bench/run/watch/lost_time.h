// What of a stored run's time says nothing of its recipe: waiting for people and conditions, the rest between an end
// and a resume, and what was done again because of them. Read from the run's own events, so of older stores, too.
#pragma once

#include <cstdint>
#include <vector>

#include "db/run_store.h"

namespace tactbench::bench {

struct LostTime {
  std::int64_t position = 0;  // of the first frame that comes later by it
  std::int64_t ns = 0;
};

// In the order of positions, at most one before a frame. `last`: the run's last position. Throws StoreError.
std::vector<LostTime> lost_times(const db::RunStore& store, std::int64_t run, std::int64_t last);

}  // namespace tactbench::bench
