// The page's own files (bench/page/assets), compiled into the program. The build generates their source
// (bench/page/assets.cmake).
#pragma once

#include <string_view>

namespace tactbench::bench {

// The file `name`: "page.html", "page.js". Empty: there is no such file.
std::string_view asset(std::string_view name);

}  // namespace tactbench::bench
