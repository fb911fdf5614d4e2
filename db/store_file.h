// Checks of a store's file before SQLite opens it: that it exists, is a store, and lies on a local disk.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace tactbench::db {

enum class FileKind { kMissing, kEmpty, kStore };

// By the file's header alone: opening a foreign database through SQLite could already change it. TB-STORE-OPEN when the
// folder is missing or the file is something else.
FileKind look_at_file(const std::string& path);

// Locks and shared memory of WAL do not work over a network. TB-STORE-NETWORK, with the reason.
void refuse_network(const std::string& path);
// To read: true for a store on a network file system without a log beside it, which can be read as it stands; warns of
// it (tell_warnings_to), once for each store. With a log TB-STORE-NETWORK. False on a local disk.
bool lies_still_on_network(const std::string& path);

// The name of a network file system, by statfs's magic number and the type in the mount table (for FUSE, whose number
// does not suffice). Nothing for a local one.
std::optional<std::string> network_file_system(std::uint64_t magic, const std::string& mount_type);

}  // namespace tactbench::db
