#include "bench/common/overrides.h"

#include <fmt/format.h>

#include "bench/common/error.h"
#include "sequences/toml/pressure_text.h"

namespace tactbench::bench {

SplitOverrides split_overrides(const std::vector<std::string>& set) {
  SplitOverrides split;
  const std::string prefix = "recipe.";
  for (const std::string& text : set) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw Error("TB-USAGE", fmt::format("'{}' is not key=value", text), "--set " + text,
                  "write --set table.key=value, for a recipe --set recipe.key=value");
    }
    const sequences::Override item{text.substr(0, equals), text.substr(equals + 1)};
    split.all.push_back(item);
    if (item.key.starts_with(prefix)) {
      split.recipe.push_back({item.key.substr(prefix.size()), item.value});
    } else {
      const bool pressure = item.key.ends_with("_psi");
      split.bench.push_back({item.key, pressure ? sequences::as_number_in("psi", item.value) : item.value, item.value});
    }
  }
  return split;
}

}  // namespace tactbench::bench
