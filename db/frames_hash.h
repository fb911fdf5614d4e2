// Hash of a run's measured frames, independent of the program, commit and build that took them.
#pragma once

#include <cstdint>
#include <string>

#include "db/run_store.h"

namespace tactbench::db {

// SHA-256 chained over the run's frames, each with the place of its branch, as in hash_chain.h but without header and
// closing part: equal for two runs that measured the same, whatever program, commit or build carried them out. In hex
// digits. Of a run whose frames were removed, the hash that was kept. StoreError as RunStore::each_frame().
std::string frames_hash(const RunStore& store, std::int64_t run);

}  // namespace tactbench::db
