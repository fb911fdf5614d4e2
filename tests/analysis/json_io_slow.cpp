// The longest JSON that is read: 64 MB, too many characters for sanitizers.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "analysis/json_io.h"

using namespace tactbench::analysis;

TEST_CASE("JSON: text beyond 64 MB is refused with the limit named") {
  const std::string blanks(kMaxJsonBytes - 1, ' ');
  CHECK(parse_json(blanks + "7") == 7);
  CHECK_THROWS_WITH(parse_json(blanks + "77"), Catch::Contains("64000000"));
  CHECK(try_ordered_json(blanks + "77").is_discarded());
}
