// runs merge: several stores into one.
#pragma once

#include <string>
#include <vector>

#include "bench/cli/night/nightly.h"

namespace tactbench::bench {

struct MergeOptions {
  std::vector<std::string> parts;
  NightFiles files;  // files of the last night
};

// Merges into session.db; prints the result and sets session.code as `nightly` does. Throws as merge_stores(), and
// Error TB-MERGE-NIGHT when files of a night are requested and the stores contain no night.
void merge_and_report(const MergeOptions& options, Session& session);

}  // namespace tactbench::bench
