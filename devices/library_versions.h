// Versions of the instrument libraries that devices/ uses: of the loaded shared object if the library reports it, else
// of its header.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace tactbench::devices {

std::vector<std::pair<std::string, std::string>> library_versions();

}  // namespace tactbench::devices
