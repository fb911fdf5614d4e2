// Versions of the libraries that this room speaks to instruments with: of the shared object in use where the library
// tells, of its header otherwise.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace tactbench::devices {

std::vector<std::pair<std::string, std::string>> library_versions();

}  // namespace tactbench::devices
