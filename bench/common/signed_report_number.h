// Recognises signed reports by the data that they contain.
#pragma once

#include <string>

namespace tactbench::bench {

// Number of the signed report in a page or JSON document, from its data; empty: not a signed report.
std::string signed_report_number_in(const std::string& text);

}  // namespace tactbench::bench
