// Files in which all keys stand that the parsers know, for the page of keys and the manual pages of section 5.
#pragma once

#include <functional>
#include <vector>

#include "bench/cli/words/meanings/meanings.h"

namespace tactbench::bench {

struct FileKind {
  const char *title, *about;   // about: Markdown
  const char *page, *summary;  // of the manual, section 5, and its line in lists
  KeyMeanings meanings;
  const char* name;            // under which read() gives its files to the parser; empty: under several
  std::function<void()> read;  // throws sequences::FileError when the parser refuses one
};
const std::vector<FileKind>& file_kinds();

}  // namespace tactbench::bench
