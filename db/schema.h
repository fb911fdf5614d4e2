// The tables of a store as numbered migrations; the file's user_version is the number of the last one applied.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "db/sqlite.h"

namespace tactbench::db {

inline constexpr std::int64_t kApplicationId = 0x54424348;  // "TBCH", in the file's header: marks a store
inline constexpr std::uint32_t kPageSize = 4096;

inline constexpr const char* kDamagedRemedy =
    "keep a copy, take your last snapshot, and check the disk; sqlite3's .recover may save the rest";

// A frame's key is run * kFramesPerRun + its position in the run, from 1: a run's frames are contiguous and need no
// index, which would add a second page to each commit, a third of the time to store a frame.
inline constexpr std::int64_t kFramesPerRun = 1'000'000'000;

// The SQL of each step takes a store from one schema to the next; the first makes the tables. From the first release on
// no step is edited: a change is a new step.
using Migrations = std::vector<std::string>;
std::string schema_1();
const Migrations& builtin_migrations();  // kSchemaVersion of them

// Refuses a schema above those of `known` (TB-STORE-OTHER-SCHEMA), a version that no program has written, and a file
// with more pages than its header states, because a write would overwrite them (TB-STORE-OPEN).
void check_version(sqlite::Connection& connection, const Migrations& known = builtin_migrations());

// Differences between the file's tables, indexes, views and triggers and those of `known` for the file's version.
struct ForeignObjects {
  std::vector<std::string> changed;  // objects of the store that are missing or differ: the file cannot be read
  std::vector<std::string> added;    // objects that do not belong to the store
};
ForeignObjects foreign_objects(sqlite::Connection& connection, const Migrations& known = builtin_migrations());
// Throws TB-STORE-OTHER-SCHEMA if the store's own objects differ, TB-STORE-FOREIGN for additions. Reading tolerates
// additions, because no trigger fires and no view is read.
enum class Additions { kTolerate, kRefuse };
void refuse_foreign(sqlite::Connection& connection, Additions additions,
                    const Migrations& known = builtin_migrations());

// Migrates an empty or older file to the last schema of `known`, in one transaction.
void migrate(sqlite::Connection& connection, const Migrations& known = builtin_migrations());

}  // namespace tactbench::db
