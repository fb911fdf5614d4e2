// Metadata of a run as KEY=VALUE pairs: lot, order and others. They are those of its tags that contain "="; like all
// tags they are remarks and not part of its content (db/hash_chain.h).
#pragma once

#include <map>
#include <string>

#include "db/record.h"

namespace tactbench::analysis {

std::map<std::string, std::string> metadata_of(const db::RunRecord& run);

}  // namespace tactbench::analysis
