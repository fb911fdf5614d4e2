// A file of one's own, begun as a copy of another: `plan --copy`, `nightly --copy`.
#pragma once

#include <string>

namespace tactbench::bench {

struct Session;

struct OwnCopy {
  std::string verb;  // "plan", whose name the next command and JSON have
  std::string what;  // "a recipe"
  std::string from;  // name that stands in the text
  std::string text;  // TOML with a line `name = "FROM"`
  std::string to;    // NAME, or a path NAME.toml
};

// Writes NAME.toml, which has its own name and all else, comments too, as `text`, and says what to do next. Throws
// Error TB-USAGE for what is no name, TB-FILE-EXISTS.
void write_own_copy(const OwnCopy& copy, const Session& session);

}  // namespace tactbench::bench
