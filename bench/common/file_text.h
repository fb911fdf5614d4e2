// A file's text in one piece, for files of the program's own.
#pragma once

#include <filesystem>
#include <string>

namespace tactbench::bench {

// Every byte of it; nothing of a file that cannot be opened. Throws std::ios_base::failure where reading fails.
std::string file_text(const std::filesystem::path& path);

}  // namespace tactbench::bench
