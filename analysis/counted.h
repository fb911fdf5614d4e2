// Formats a number with its noun in singular or plural: "1 frame", "2 frames".
#pragma once

#include <concepts>
#include <string>

namespace tactbench::analysis {

// `several`: the plural, if it is not the noun with an s ("branches").
template <std::integral Number>
std::string counted(Number number, const std::string& one, const std::string& several = {}) {
  const std::string& noun = number == Number{1} || several.empty() ? one : several;
  return std::to_string(number) + " " + noun + (number == Number{1} || !several.empty() ? "" : "s");
}

}  // namespace tactbench::analysis
