#include "analysis/read_whole_file.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <vector>

#include "analysis/error.h"

namespace tactbench::analysis {

namespace fs = std::filesystem;

bool check_file(const std::string& path, bool or_pipe, const std::string& id, const std::string& remedy) {
  std::error_code unknown;
  const fs::file_status status = fs::status(path, unknown);
  if (unknown || status.type() == fs::file_type::not_found)
    throw AnalysisError(id, fmt::format("{} cannot be read", path), remedy);
  if (status.type() == fs::file_type::regular) return fs::file_size(path, unknown) > 0;
  if (or_pipe && status.type() == fs::file_type::fifo) return true;
  throw AnalysisError(id, fmt::format("{} is not a regular file", path),
                      or_pipe ? "name a file or a pipe" : "name a file: devices, folders and pipes are not read");
}

std::string read_whole_file(const std::string& path, const FileBounds& bounds, const std::string& id,
                            const std::string& remedy) {
  if (!check_file(path, bounds.or_pipe, id, remedy)) return {};
  std::ifstream file(path, std::ios::binary);
  if (!file) throw AnalysisError(id, fmt::format("{} cannot be read", path), remedy);
  std::string text;
  std::vector<char> block(std::size_t{1} << 16);
  while (file.read(block.data(), static_cast<std::streamsize>(block.size())), file.gcount() > 0) {
    text.append(block.data(), static_cast<std::size_t>(file.gcount()));
    if (text.size() <= bounds.max_bytes) continue;
    throw AnalysisError(id, fmt::format("{} is longer than {} bytes", path, bounds.max_bytes),
                        "check that it is the right file; longer files are not read");
  }
  if (file.bad())
    throw AnalysisError(id, fmt::format("{}: reading failed after {} bytes", path, text.size()),
                        "check the disk and the file");
  return text;
}

}  // namespace tactbench::analysis
