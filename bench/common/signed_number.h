// Recognises signed reports by their data.
#pragma once

#include <string>

namespace tactbench::bench {

// Number of the signed report in a page or JSON document, from its data; empty: not a signed report.
std::string signed_number_in(const std::string& text);

}  // namespace tactbench::bench
