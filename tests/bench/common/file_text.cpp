// A file that is not there has no text; one that cannot be read to its end is an error, not half a text.
#include "bench/common/file_text.h"

#include <catch2/catch.hpp>
#include <ios>

#include "tests/support/process.h"

using namespace tactbench::bench;
using namespace tactbench::tests;

TEST_CASE("file text: every byte of it, nothing of a missing file, and an error where reading fails") {
  const TemporaryFolder folder;
  std::string bytes;
  for (int i = 0; i < 40000; ++i) bytes += static_cast<char>(i * i);
  write_file(folder.path("bytes"), bytes);
  write_file(folder.path("empty"), "");
  CHECK(file_text(folder.path("bytes")) == bytes);
  CHECK(file_text(folder.path("empty")).empty());
  CHECK(file_text(folder.path("missing")).empty());
  CHECK_THROWS_AS(file_text(folder.path(".")), std::ios_base::failure);
}
