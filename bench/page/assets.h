// Files inside the program: the page's own (bench/page/assets) and the table of errors (docs/reference-errors.md). The
// build makes their source (bench/page/assets.cmake).
#pragma once

#include <string_view>

namespace tactbench::bench {

// By name: "page.html", "page.js", "reference-errors.md". Empty: there is none.
std::string_view asset(std::string_view name);

}  // namespace tactbench::bench
