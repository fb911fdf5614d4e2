// JSON from outside has bounds: too long or too deep texts are refused, so that neither memory nor stack runs out.
#include "analysis/json_io.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

using namespace tactbench::analysis;

namespace {

std::string nested(int depth) {
  const auto count = static_cast<std::size_t>(depth);
  return std::string(count, '[') + std::string(count, ']');
}

}  // namespace

TEST_CASE("JSON: every reader refuses nesting beyond the depth limit") {
  CHECK(parse_json(nested(kMaxJsonDepth)).is_array());
  for (const std::string& deep : {nested(kMaxJsonDepth + 1), nested(10'000'000), std::string(10'000'000, '['),
                                  "{\"a\":" + nested(kMaxJsonDepth) + "}"}) {
    CHECK_THROWS_WITH(parse_json(deep), Catch::Contains("100"));
    CHECK_THROWS_AS(parse_ordered_json(deep), nlohmann::json::exception);
    CHECK(try_json(deep).is_discarded());
    CHECK(try_ordered_json(deep).is_discarded());
    CHECK(ordered_json_or_null(deep).is_null());
  }
}

TEST_CASE("JSON: adjacent brackets and brackets in strings do not count as nesting") {
  std::string flat = "[";
  for (int i = 0; i < 1000; ++i) flat += "[{}],";
  CHECK(parse_json(flat + "0]").size() == 1001);
  const std::string brackets(200, '[');
  CHECK(parse_json("\"" + brackets + "\"") == brackets);
  CHECK(parse_json("[\"\\\"" + brackets + "\\\\\"]").at(0) == "\"" + brackets + "\\");
}
