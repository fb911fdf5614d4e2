// Recipes and what --set does to them. The input is a recipe file; lines "!key=value" before it are typed overrides.
// What is accepted has the steps that were counted, and no more than a run may have.
#include "sequences/recipe.h"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

using namespace tactbench;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::string text(reinterpret_cast<const char*>(data), size);
  std::vector<sequences::Override> overrides;
  while (text.starts_with('!')) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string line = text.substr(1, end - 1);
    const std::size_t equals = line.find('=');
    if (equals != std::string::npos && equals > 0)
      overrides.push_back({line.substr(0, equals), line.substr(equals + 1)});
    text.erase(0, std::min(end + 1, text.size()));
  }
  try {
    const sequences::Recipe recipe =
        sequences::parse_recipe(sequences::TomlDocument::from_text(text, "fuzzed.toml"), overrides);
    const double count = sequences::step_count(recipe);
    if (!(count >= 1.0 && count <= sequences::kMaxSteps)) std::abort();
    constexpr double kQuick = 20'000.0;  // more of them would only take time
    if (count <= kQuick && static_cast<double>(sequences::compile(recipe, 0).size()) != count) std::abort();
  } catch (const sequences::FileError& error) {
    if (error.id().empty() || error.where().empty() || error.remedy().empty()) std::abort();
  }
  return 0;
}
