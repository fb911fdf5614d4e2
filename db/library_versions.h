// Versions of the shared libraries that db/ uses to store and to hash.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace tactbench::db {

std::vector<std::pair<std::string, std::string>> library_versions();

}  // namespace tactbench::db
