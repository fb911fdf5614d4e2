// Versions of the libraries that this room uses for instruments: of the shared object in use where the library reports
// it, of its header otherwise.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace tactbench::devices {

std::vector<std::pair<std::string, std::string>> library_versions();

}  // namespace tactbench::devices
