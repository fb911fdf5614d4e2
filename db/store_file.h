// Checks of a store's file before SQLite opens it: it exists, is a store, and is on a local disk.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

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

}  // namespace tactbench::db
