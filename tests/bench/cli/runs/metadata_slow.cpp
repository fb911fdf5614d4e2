// Lot, order and other metadata of a run, from the command line to lists, exports and the report.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/support/process.h"

using namespace tactbench::tests;
using nlohmann::json;

namespace {

Finished measured_with(const TemporaryFolder& folder, const std::vector<std::string>& more) {
  std::vector<std::string> words = {"run", "small.toml", "--bench",    "bench.toml", "--sensor",
                                    "S-1", "-q",         "--operator", "tester",     "--no-seating"};
  words.insert(words.end(), more.begin(), more.end());
  return call(folder, words);
}

void make_bench(const TemporaryFolder& folder) {
  REQUIRE(call(folder, {"init"}).code == 0);
  write_file(folder.path("small.toml"),
             "schema = 1\nname = \"small\"\nunit = \"psi\"\nturning_points = [0, 60, 20, 60, 0]\nstep = 20\n"
             "repeats = 1\ndwell_s = 1.0\n");
  REQUIRE(call(folder, {"sensors", "add", "S-1"}).code == 0);
}

}  // namespace

TEST_CASE("lot, order and key=value are stored with a run, shown, found, exported and printed on its report") {
  const TemporaryFolder folder;
  make_bench(folder);
  REQUIRE(
      measured_with(folder, {"--lot", "A7", "--order", "55/26", "--meta", "film=B12", "--meta", "station=left"}).code ==
      0);
  REQUIRE(measured_with(folder, {}).code == 0);
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
  const Finished differ = call(folder, {"runs", "diff", "1", "2"});
  CHECK(differ.code == 0);
  CHECK_THAT(differ.out, Catch::Contains("metadata.lot") && Catch::Contains("A7 | nothing"));
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

TEST_CASE("metadata that cannot be kept is refused before anything is touched") {
  const TemporaryFolder folder;
  make_bench(folder);
  for (const std::vector<std::string>& wrong :
       std::vector<std::vector<std::string>>{{"--meta", "film"},
                                             {"--meta", "=x"},
                                             {"--meta", "a b=x"},
                                             {"--meta", "a="},
                                             {"--lot", "1", "--meta", "lot=2"}}) {
    INFO(wrong.back());
    CHECK(measured_with(folder, wrong).code == 2);
  }
  CHECK(json::parse(call(folder, {"runs", "list", "--json"}).out).at("runs").empty());
}
