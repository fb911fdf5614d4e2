// What the tables of keys (sequences/toml/key_table.h) say of each kind of TOML file that the program reads: the page
// of reference, and the comments of the files that `tactbench init` writes.
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

// docs/reference-keys.md, in Markdown.
std::string key_reference();

// `toml` with what each of its keys means above the key's first line, also where that line is a comment ("# key = 1").
std::string with_meanings(const std::string& toml, const std::vector<sequences::KeyFacts>& keys);

void add_key_reference(CLI::App& app);  // the hidden verb reference-keys, for tests/docs/reference.py

}  // namespace tactbench::bench
