// Reads a whole file named by a user: regular files or pipes of bounded size.
#pragma once

#include <cstddef>
#include <string>

namespace tactbench::analysis {

struct FileBounds {
  std::size_t max_bytes = 0;
  bool or_pipe = false;  // a pipe, too: <(command) of a shell
};

// Whether there is anything to read: not in a file without length, such as those of /proc, of which some are waited for
// without end. Throws AnalysisError `id` where `path` names nothing that can be read, or a folder or a device.
[[nodiscard]] bool check_file(const std::string& path, bool or_pipe, const std::string& id, const std::string& remedy);

// Throws as check_file(), and where the file is longer or reading fails.
std::string read_whole_file(const std::string& path, const FileBounds& bounds, const std::string& id,
                            const std::string& remedy);

}  // namespace tactbench::analysis
