// Version of the library that this room reads files with: of its header.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace tactbench::sequences {

std::vector<std::pair<std::string, std::string>> library_versions();

}  // namespace tactbench::sequences
