// The tables of a store as numbered migrations; the file's user_version is the number of the last one applied. After
// the first release a migration is never edited; each change is a new one.
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

// The SQL that migrates from `version` to the next one.
std::string migration(std::int64_t version);
std::string frames_view_migration();     // from 6 to 7
std::string nights_migration();          // from 7 to 8
std::string report_reasons_migration();  // from 8 to 9

// Refuses a newer schema (TB-STORE-NEWER), a version that no program has written, and a file with more pages than its
// header states, because a write would overwrite them (TB-STORE-OPEN).
void check_version(sqlite::Connection& connection);

// Differences between the file's tables, indexes, views and triggers and those of this program for the file's version.
struct ForeignObjects {
  std::vector<std::string>
      changed;  // own ones that are missing or differ: the file cannot be trusted, not even for reading
  std::vector<std::string> added;  // foreign ones besides the store's
};
ForeignObjects foreign_objects(sqlite::Connection& connection);
// Throws TB-STORE-FOREIGN. Reading tolerates additions, since no trigger fires and no view is read.
enum class Foreign { kRefuseChanged, kRefuseAll };
void refuse_foreign(sqlite::Connection& connection, Foreign refused);

// Migrates an empty or older file to kSchemaVersion, in one transaction.
void migrate(sqlite::Connection& connection);

}  // namespace tactbench::db
