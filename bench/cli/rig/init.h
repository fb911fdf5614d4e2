// Documentation generated from the key tables (sequences/toml/key_table.h) for each kind of TOML file that the program
// reads: the reference page, and the comments in the files that `tactbench init` writes.
#pragma once

#include <string>
#include <vector>

#include "sequences/toml/key_table.h"

namespace CLI {
class App;
}

namespace tactbench::bench {

struct FileKind {
  const char *title, *about;  // Markdown
  std::vector<sequences::KeyFacts> (*keys)();
};
const std::vector<FileKind>& file_kinds();

// `toml` with the meaning of each key as a comment above its first line, also for a line that is commented out ("# key
// = 1").
std::string with_key_comments(const std::string& toml, const std::vector<sequences::KeyFacts>& keys);

}  // namespace tactbench::bench
