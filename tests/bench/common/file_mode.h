// Permissions of a file, for tests.
#pragma once

#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <string>

namespace tactbench::tests {

// Of a link its own.
inline mode_t mode_of(const std::string& path) {
  struct stat found {};
  REQUIRE(lstat(path.c_str(), &found) == 0);
  return found.st_mode & 07777;
}

}  // namespace tactbench::tests
