// Makes a user's own file as a copy of a shipped one: `plan --copy`, `nightly --copy`.
#pragma once

#include <string>

namespace tactbench::bench {

struct Session;

struct OwnCopy {
  std::string verb;  // "plan"; used in the suggested next command and in the JSON
  std::string what;  // "a recipe"
  std::string from;  // the name in the text
  std::string text;  // TOML with a line `name = "FROM"`
  std::string to;    // NAME, or a path NAME.toml
};

// Writes NAME.toml: `text` with the new name, comments included; and prints what to do next. Throws Error TB-USAGE for
// an invalid name, TB-FILE-EXISTS.
void write_own_copy(const OwnCopy& copy, const Session& session);

}  // namespace tactbench::bench
