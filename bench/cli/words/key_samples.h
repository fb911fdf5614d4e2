// Files in which all keys stand that the parsers know, for the page of keys.
#pragma once

#include <functional>
#include <vector>

namespace tactbench::bench {

struct FileKind {
  const char *title, *about;
  const char* name;            // under which read() gives its files to the parser; empty: under several
  std::function<void()> read;  // throws sequences::FileError when the parser refuses one
};
const std::vector<FileKind>& file_kinds();

}  // namespace tactbench::bench
