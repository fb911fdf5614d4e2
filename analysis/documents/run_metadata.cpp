#include "analysis/documents/run_metadata.h"

namespace tactbench::analysis {

std::map<std::string, std::string> metadata_of(const db::RunRecord& run) {
  std::map<std::string, std::string> metadata;
  for (const std::string& tag : run.tags)
    if (const std::size_t equals = tag.find('='); equals != std::string::npos)
      metadata[tag.substr(0, equals)] = tag.substr(equals + 1);
  return metadata;
}

}  // namespace tactbench::analysis
