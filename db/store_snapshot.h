// Complete copies of a store: snapshots on request, and the backup before a migration.
#pragma once

#include <string>

#include "db/sqlite.h"

namespace tactbench::db {

// Copies the store behind `source` into a file of this name, which must not exist yet (TB-STORE-EXISTS); the file
// appears complete or not at all. Throws TB-STORE-NETWORK, TB-STORE-FULL, TB-STORE-OPEN.
void copy_store(const sqlite::Connection& source, const std::string& path);

// Copies a store of an older schema to backup_path() before it is migrated; does not copy an empty or current one. If
// the copy fails, the store stays as it was.
void keep_before_migration(sqlite::Connection& connection, const std::string& path);

}  // namespace tactbench::db
