// Version of the library that sequences/ uses to read files, from its header.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace tactbench::sequences {

std::vector<std::pair<std::string, std::string>> library_versions();

}  // namespace tactbench::sequences
