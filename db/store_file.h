// Looks at a store's file before SQLite may touch it: is it there, is it ours, does it lie on a local disk.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace tactbench::db {

enum class FileKind { kMissing, kEmpty, kStore };

// By the file's header alone: opening a foreign database through SQLite could already change it. TB-STORE-OPEN when the
// folder is missing or the file is something else.
FileKind look_at_file(const std::string& path);

// Locks and shared memory of WAL do not hold over a network. TB-STORE-NETWORK, with the reason.
void refuse_network(const std::string& path);

// The name of a network file system, by statfs's magic number and the type in the mount table (for FUSE, whose number
// says nothing). Nothing for a local one.
std::optional<std::string> network_file_system(std::uint64_t magic, const std::string& mount_type);

}  // namespace tactbench::db
