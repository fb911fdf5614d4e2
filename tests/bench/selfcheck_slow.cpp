// The validation record: every check passes on a sound installation, and what is broken is named.
#include <catch2/catch.hpp>
#include <filesystem>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>

#include "db/run_store.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"

using namespace tactbench::tests;
using nlohmann::ordered_json;

namespace {

Finished selfcheck_in(const TemporaryFolder& folder, std::vector<std::string> more) {
  more.insert(more.begin(), "selfcheck");
  return run_program(program_path(), more, folder.path());
}

}  // namespace

TEST_CASE("selfcheck: all pass here, and the record carries its own hash") {
  const TemporaryFolder folder;
  const Finished finished = selfcheck_in(folder, {"--json", "-o", "record.json"});
  INFO(finished.out << finished.err);
  REQUIRE(finished.code == 0);
  ordered_json record = ordered_json::parse(finished.out);
  CHECK(record == ordered_json::parse(read_file(folder.path("record.json"))));
  CHECK(record["schema"] == "tactbench.selfcheck");
  CHECK(record["failed"] == 0);
  CHECK(record["libraries"].size() >= 10);
  std::map<std::string, int> areas;
  for (const auto& check : record["checks"]) {
    CHECK(check["pass"] == true);
    ++areas[check["area"].get<std::string>()];
  }
  CHECK(areas["identification"] == 4);
  CHECK(areas["inverse"] == 4);
  CHECK(areas["store"] == 4);
  CHECK(areas["run"] == 3);
  for (const char* area : {"clock", "dispatch", "compensator"}) CHECK(areas[area] >= 1);
  const std::string hash = record["sha256"];
  record.erase("sha256");
  CHECK(hash == tactbench::db::sha256_hex(record.dump()));
  CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 1);  // the record, and nothing else
}

TEST_CASE("selfcheck: what does not hold is a failed line and exit code 1, the text says which") {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder.path("share/bench"));
  std::filesystem::copy(source_path("bench/config"), folder.path("share/bench/config"));
  write_file(folder.path("share/bench/config/simulated.toml"), "schema = 1\n");
  const Finished finished = run_program(
      "/usr/bin/env",
      {"TACTBENCH_SHARE=" + folder.path("share"), program_path(), "selfcheck", "-o", folder.path("record.txt")},
      folder.path());
  CHECK(finished.code == 1);
  CHECK_THAT(finished.out, Catch::Contains("FAIL  run: ") && Catch::Contains("could not be checked: ") &&
                               Catch::Contains("pass  identification: elam") && Catch::Contains("3 failed"));
  CHECK(read_file(folder.path("record.txt")) == finished.out);
  const Finished nowhere = selfcheck_in(folder, {"--db", folder.path("no/such/runs.db")});
  CHECK(nowhere.code == 2);
  CHECK_THAT(nowhere.err, Catch::Contains("TB-FILE-WRITE"));
}
