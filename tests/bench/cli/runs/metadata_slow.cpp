// Lot, order and other metadata of a run, from the command line to lists, exports and the report.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/bench/cli/small_bench.h"
#include "tests/support/run_recipe.h"

using namespace tactbench::tests;
using nlohmann::json;

TEST_CASE("lot, order and key=value are stored with a run, shown, found, exported and printed on its report") {
  const TemporaryFolder folder;
  begin_bench(folder);
  run_recipe(folder, "small.toml", {"--lot", "A7", "--order", "55/26", "--meta", "film=B12", "--meta", "station=left"});
  run_recipe(folder, "small.toml");
  const auto found = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"runs", "list", "--json"};
    words.insert(words.end(), more.begin(), more.end());
    return json::parse(call(folder, words).out).at("runs").size();
  };
  CHECK(found({}) == 2);
  CHECK(found({"--lot", "A7"}) == 1);
  CHECK(found({"--order", "55/26", "--meta", "station=left"}) == 1);
  CHECK(found({"--meta", "film"}) == 1);
  CHECK(found({"--lot", "A8"}) == 0);
  CHECK(found({"--meta", "film=B13"}) == 0);
  // The same seeds give the same run, whatever lot it is of.
  CHECK_THAT(well(call(folder, {"runs", "diff", "1", "2"})).out, Catch::Contains("metadata.lot"));
  REQUIRE(call(folder, {"runs", "export", "1", "-o", "1.csv"}).code == 0);
  CHECK_THAT(read_file(folder.path("1.csv")), Catch::Contains("\n# metadata lot: A7\n"));
  REQUIRE(call(folder, {"runs", "export", "1", "--format", "json", "-o", "1.json"}).code == 0);
  CHECK(json::parse(read_file(folder.path("1.json"))).at("metadata").at("film") == "B12");
  REQUIRE(call(folder, {"report", "1"}).code == 0);
  CHECK(call(folder, {"verify", "1"}).code == 0);
  // Corrected later: a key has one value.
  REQUIRE(call(folder, {"runs", "tag", "1", "lot=A8"}).code == 0);
  CHECK(found({"--lot", "A7"}) == 0);
  CHECK(found({"--lot", "A8"}) == 1);
  CHECK(call(folder, {"verify", "1"}).code == 0);
}
