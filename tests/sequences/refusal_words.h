// What a refusal says in full: "id | message | place | remedy".
#pragma once

#include <fmt/format.h>

#include <functional>
#include <string>

#include "sequences/toml/strict_toml.h"

namespace tactbench::sequences {

// "accepted" when `act` throws nothing.
inline std::string words_of(const std::function<void()>& act) {
  try {
    act();
  } catch (const FileError& error) {
    return fmt::format("{} | {} | {} | {}", error.id(), error.what(), error.where(), error.remedy());
  }
  return "accepted";
}

}  // namespace tactbench::sequences
