// Packs one run for the fleet database: an SQLite store that holds only this run and everything stored about it,
// compressed with zlib.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "db/run_store.h"

namespace tactbench::db::fleet {

// Largest store of a run, in bytes: about a million frames of 16 x 16 taxels. A value in PostgreSQL is smaller than 1
// GiB.
inline constexpr std::size_t kMaxStoreBytes = 1'000'000'000;

// `scratch`: a temporary folder that nobody else uses. Throws StoreError if the run has changed since it was stored,
// FleetError TB-FLEET-LARGE.
std::string pack_run(const RunStore& store, std::int64_t run, const std::string& scratch);
// Writes the store to `path`. Throws FleetError TB-FLEET-CHANGED when `body` is not a packed run; the file is then
// unusable.
void unpack_run(const std::string& body, const std::string& path);

}  // namespace tactbench::db::fleet
