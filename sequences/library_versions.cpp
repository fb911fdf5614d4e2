#include "sequences/library_versions.h"

#include <fmt/format.h>
#include <toml++/impl/version.h>

namespace tactbench::sequences {

std::vector<std::pair<std::string, std::string>> library_versions() {
  return {{"toml++", fmt::format("{}.{}.{}", TOML_LIB_MAJOR, TOML_LIB_MINOR, TOML_LIB_PATCH)}};
}

}  // namespace tactbench::sequences
