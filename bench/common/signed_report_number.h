// Finds the number of a signed report in the data that its page or JSON document contains.
#pragma once

#include <string>

namespace tactbench::bench {

// Number of the signed report in a page or JSON document, from its data; empty: not a signed report.
std::string signed_report_number_in(const std::string& text);

}  // namespace tactbench::bench
