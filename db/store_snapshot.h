// Complete copies of a store: snapshots on request, and the backup before a migration.
#pragma once

#include <string>

#include "db/sqlite.h"

namespace tactbench::db {

// Copies the store behind `source` into a file of that name, which must not exist yet (TB-STORE-EXISTS); it appears
// complete or not at all. TB-STORE-NETWORK, TB-STORE-FULL, TB-STORE-OPEN.
void copy_store(const sqlite::Connection& source, const std::string& path);

// A store of an older schema is copied to backup_path() first; an empty or current one is not. If the copy fails, the
// store is left as it was.
void keep_before_migration(sqlite::Connection& connection, const std::string& path);

}  // namespace tactbench::db
