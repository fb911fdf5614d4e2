// Versions of the shared objects with which this room stores and hashes.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace tactbench::db {

std::vector<std::pair<std::string, std::string>> library_versions();

}  // namespace tactbench::db
