// The tables of a store as numbered migrations; the number reached is the file's user_version. From the first release
// on a migration is never edited: a change is a new one.
#pragma once

#include <cstdint>

#include "db/sqlite.h"

namespace tactbench::db {

inline constexpr std::int64_t kApplicationId = 0x54424348;  // "TBCH", in the file's header: tells our files from others

// A frame's key is run * kFramesPerRun + its position in the run, from 1: the frames of a run lie together and are
// found without an index, whose second page a commit would cost a third of the time to store a frame.
inline constexpr std::int64_t kFramesPerRun = 1'000'000'000;

// Refuses a file of a newer schema (TB-STORE-NEWER).
void check_version(sqlite::Connection& connection);
// Brings an empty or older file up to kSchemaVersion, in one transaction.
void migrate(sqlite::Connection& connection);

}  // namespace tactbench::db
