// Complete copies of a store: snapshots on request, and the backup before a migration.
#pragma once

#include <string>

#include "db/schema.h"
#include "db/sqlite.h"

namespace tactbench::db {

// Copies the store behind `source` into a file of this name, which must not exist yet (TB-STORE-EXISTS); the file
// appears complete or not at all. Throws TB-STORE-NETWORK, TB-STORE-FULL, TB-STORE-OPEN.
void copy_store(const sqlite::Connection& source, const std::string& path);

// Makes the tables of an empty file, or migrates the store of an older schema after a copy to backup_path(). Throws
// TB-STORE-OTHER-SCHEMA, TB-STORE-FOREIGN, TB-STORE-OPEN and as copy_store; the store is then as it was.
void migrate_store(sqlite::Connection& connection, const std::string& path,
                   const Migrations& known = builtin_migrations());

}  // namespace tactbench::db
