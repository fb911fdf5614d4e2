// The file of a store before SQLite opens it (it exists, is a store, and is on a local disk), and complete copies of
// it: snapshots on request, and the backup before a migration.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "db/schema.h"
#include "db/sqlite.h"

namespace tactbench::db {

enum class FileKind { kMissing, kEmpty, kStore };

// Reads only the file's header, because opening a foreign database through SQLite could already change it.
// TB-STORE-OPEN when the folder is missing or the file is something else.
FileKind check_store_file(const std::string& path);

// Throws TB-STORE-NETWORK with the reason: locks and shared memory of WAL do not work over a network.
void refuse_network(const std::string& path);
// For reading. True for a store on a network file system that has no write-ahead log, so that it can be read directly;
// warns once per store (set_warning_handler). With a log throws TB-STORE-NETWORK. False on a local disk.
bool is_readable_on_network(const std::string& path);

// The process that has locked the store for writing, according to the kernel: "python3 (pid 812)"; empty: not known.
// Opens no file of the store, because closing one would release this process's own locks (fcntl(2)).
std::string writer_of(const std::string& path);

// Name of a network file system, from statfs's magic number and the type in the mount table (for FUSE, where the number
// does not suffice). Empty for a local one.
std::optional<std::string> network_file_system(std::uint64_t magic, const std::string& mount_type);

// Sets the function that receives warnings, one sentence each, for the whole program, since db/ prints nothing. Empty
// (the default): warnings are dropped. Set it before threads are started.
void set_warning_handler(std::function<void(const std::string&)> handler);

// Schema version of the file, read without writing or migrating. TB-STORE-OPEN if it is not a store.
int schema_version_of(const std::string& path);

// `wanted`, or the first of wanted.2, wanted.3 ... that is no file yet.
std::string free_name(const std::string& wanted);
// Name of the backup made when an older store is opened: next to it, first free name ("runs.db.schema-2.backup").
std::string backup_path(const std::string& path, int version);

// Copies the store behind `source` into a file of this name, which must not exist yet (TB-STORE-EXISTS); the file
// appears complete or not at all. Throws TB-STORE-NETWORK, TB-STORE-FULL, TB-STORE-OPEN.
void copy_store(const sqlite::Connection& source, const std::string& path);

// Makes the tables of an empty file, or migrates the store of an older schema after a copy to backup_path(). Throws
// TB-STORE-OTHER-SCHEMA, TB-STORE-FOREIGN, TB-STORE-OPEN and as copy_store; the store is then as it was.
void migrate_store(sqlite::Connection& connection, const std::string& path,
                   const Migrations& known = builtin_migrations());

}  // namespace tactbench::db
