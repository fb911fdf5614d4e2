#include "bench/common/file_text.h"

#include <array>
#include <fstream>

namespace tactbench::bench {

std::string file_text(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  file.exceptions(std::ios::badbit);
  std::string text;
  std::array<char, std::size_t{1} << 14> block;
  while (file.read(block.data(), block.size()), file.gcount() > 0)
    text.append(block.data(), static_cast<std::size_t>(file.gcount()));
  return text;
}

}  // namespace tactbench::bench
