// Reads a whole file named by a user: regular files or pipes of bounded size.
#pragma once

#include <cstddef>
#include <string>

namespace tactbench::analysis {

struct FileBounds {
  std::size_t max_bytes = 0;
  bool or_pipe = false;  // also accepts a pipe: <(command) of a shell
};

// Whether there is anything to read: false for a file without length, such as those of /proc, because reading some of
// them blocks forever. Throws AnalysisError `id` if `path` cannot be read, or is a folder or a device.
[[nodiscard]] bool check_file(const std::string& path, bool or_pipe, const std::string& id, const std::string& remedy);

// Throws as check_file(), and if the file is too long or reading fails.
std::string read_whole_file(const std::string& path, const FileBounds& bounds, const std::string& id,
                            const std::string& remedy);

}  // namespace tactbench::analysis
