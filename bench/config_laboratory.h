// The laboratory file: what a report says and no instrument knows. Unknown keys are errors; missing ones are empty.
#pragma once

#include <string>

#include "analysis/report/laboratory.h"

namespace tactbench::bench {

// Throws FileError.
analysis::Laboratory read_laboratory(const std::string& path);
analysis::Laboratory parse_laboratory(const std::string& text, const std::string& name);
bool is_iso_date(const std::string& text);  // "2026-01-31"

}  // namespace tactbench::bench
