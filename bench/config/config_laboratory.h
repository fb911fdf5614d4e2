// Reads the laboratory file: facts for reports that no instrument can supply. Unknown keys are errors; missing
// ones are empty, except for the required `schema` and an instrument's `serial`.
#pragma once

#include <string>
#include <vector>

#include "analysis/report/laboratory.h"
#include "sequences/toml/strict_toml.h"

namespace tactbench::bench {

// Throws FileError.
analysis::Laboratory read_laboratory(const std::string& path);
analysis::Laboratory parse_laboratory(const std::string& text, const std::string& name);
std::vector<sequences::KeyFacts> laboratory_keys();

}  // namespace tactbench::bench
