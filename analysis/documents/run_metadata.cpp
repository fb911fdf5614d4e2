#include "analysis/documents/run_metadata.h"

#include <fmt/format.h>

namespace tactbench::analysis {

std::map<std::string, std::string> metadata_of(const db::RunRecord& run) {
  std::map<std::string, std::string> metadata;
  for (const std::string& tag : run.tags)
    if (const std::size_t equals = tag.find('='); equals != std::string::npos)
      metadata[tag.substr(0, equals)] = tag.substr(equals + 1);
  return metadata;
}

std::string metadata_words(const std::map<std::string, std::string>& metadata) {
  std::string text;
  for (const auto& [key, value] : metadata) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", key, value);
  return text;
}

}  // namespace tactbench::analysis
