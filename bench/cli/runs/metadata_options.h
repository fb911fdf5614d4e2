// --lot, --order and --meta KEY=VALUE on the command line. They become tags of the run, "lot=A7"
// (analysis/documents/run_metadata.h).
#pragma once

#include <string>
#include <vector>

#include "db/record.h"

namespace CLI {
class App;
}

namespace tactbench::bench {

struct MetadataOptions {
  std::string lot, order;
  std::vector<std::string> pairs;  // KEY=VALUE
};
// To be recorded with a run, or as a filter (`filter`: --meta KEY alone asks only whether the key is there).
void add_metadata_options(CLI::App& verb, MetadataOptions& options, bool filter = false);

// As tags. Throws Error TB-USAGE for a pair without "=", a key named twice, or what is no tag (db::RunStore::set_tags).
std::vector<std::string> metadata_tags(const MetadataOptions& options);
// Whether a run's metadata is as asked.
bool fits_metadata(const MetadataOptions& asked, const db::RunRecord& run);

}  // namespace tactbench::bench
