// Files at their longest.
#include <algorithm>
#include <catch2/catch.hpp>
#include <string>

#include "analysis/error.h"
#include "analysis/whole_file.h"
#include "tests/support/process.h"

using namespace tactbench::analysis;
using tactbench::tests::TemporaryFolder;
using tactbench::tests::write_file;

TEST_CASE("a file is read whole up to its most bytes, in blocks, and one byte more is refused") {
  const TemporaryFolder folder;
  const std::string path = folder.path("f");
  for (const std::size_t bytes : {0U, 10U, 65536U, 65537U, 200001U}) {
    CAPTURE(bytes);
    std::string text(bytes, 'a');
    if (!text.empty()) text.back() = 'z';
    write_file(path, text);
    CHECK(whole_file(path, {.most_bytes = std::max(bytes, std::size_t{10}), .or_pipe = false}, "TB-X", "mend it") ==
          text);
    if (bytes < 10) continue;
    try {
      (void)whole_file(path, {.most_bytes = bytes - 1, .or_pipe = false}, "TB-X", "mend it");
      FAIL_CHECK("read");
    } catch (const AnalysisError& error) {
      CHECK(error.id() == "TB-X");
      CHECK_THAT(error.what(), Catch::Contains(std::to_string(bytes - 1)));
    }
  }
  for (const char* none : {"none", ""})
    CHECK_THROWS_AS(whole_file(folder.path(none), {.most_bytes = 10, .or_pipe = true}, "TB-X", "mend it"),
                    AnalysisError);
}
