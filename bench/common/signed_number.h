// Reports that somebody signed, told by their own data.
#pragma once

#include <string>

namespace tactbench::bench {

// The number of the report that a page or a JSON document holds signed, by its own data; empty: it holds none.
std::string signed_number_in(const std::string& text);

}  // namespace tactbench::bench
