// Reads a whole file as text, for files that belong to the program.
#pragma once

#include <filesystem>
#include <string>

namespace tactbench::bench {

// All bytes of the file; empty when it cannot be opened. Throws std::ios_base::failure where reading fails.
std::string file_text(const std::filesystem::path& path);

}  // namespace tactbench::bench
