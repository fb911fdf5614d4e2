// runs merge: several stores into one.
#pragma once

#include <string>
#include <vector>

#include "bench/cli/night/nightly.h"

namespace tactbench::bench {

struct MergeOptions {
  std::vector<std::string> parts;
  NightFiles files;  // of the last night
};

// Into session.db; prints what came of it and sets session.code as `nightly` does. Throws as merge_stores(), and Error
// TB-MERGE-NIGHT when files of a night are asked for and none came.
void merge_and_report(const MergeOptions& options, Session& session);

}  // namespace tactbench::bench
